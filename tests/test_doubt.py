# SPDX-License-Identifier: MIT
"""What the on-board filter believes of a model: its noise, and the errors of its parameters."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, make_model

import seatrial
from seatrial import _core
from seatrial.doubt import believed_on_board, doubt
from seatrial.filter_noise import NOISE_START
from seatrial.predictor import Predictor
from seatrial.schema import CorrelatedEntry, EnvelopeEntry, NoiseEntry, ProcessEntry

sys.path.insert(0, str(ROOT))
from benchmarks.predictor import accuracy
from benchmarks.predictor.drives import SCENES, model

EXACT = next(iter(SCENES))
SILENT = NoiseEntry(1e-4, 1e-4, ProcessEntry(0.0, 0.0, 0.0, 0.0, 0.3))
LENGTH, LOOK = 40.0, 0.1  # [s]


@pytest.fixture(scope="module")
def known() -> seatrial.Model:
    return model(EXACT, accuracy.SEED)


def sticks(width, seed=1, most=1.0):
    """Stamps [s] and commands, each held for 1 to 3 s; the first is at rest."""
    random = np.random.default_rng(seed)
    stamps = np.cumsum(random.uniform(1.0, 3.0, 40))
    rows = random.uniform(-most, most, (len(stamps), width))
    return np.concatenate([[0.0], stamps]), np.vstack([np.zeros(width), rows])


def spread_by_slopes(known, covariance, scale=None):
    """S C S' (n, 6, 6) of the state along the drive, by the core's own derivatives."""
    n, k = len(known.coefficients), len(known.constants)
    scales = (np.zeros(0), np.zeros((0, 0))) if scale is None else scale
    args = (*sticks(len(known.vehicle.inputs)), *scales, False, list(range(n)), list(range(k)))
    trace = _core.Trace(known.vehicle.chain, known.constants, *args)
    t = np.arange(0.0, LENGTH, LOOK)
    _, slope = _core.simulate(known.boat, trace, np.zeros(6), t, True)
    s = slope[:, :, -(n + k) :]
    return np.einsum("nij,jk,nlk->nil", s, covariance, s)


def spread_believed(known, scale=None):
    """Covariances (n, 6, 6) along the same drive, of a predictor that knew the start exactly."""
    p = Predictor(replace(known, noise=SILENT), disturbance="body")
    stamps, commands = sticks(len(known.vehicle.inputs))
    for t in np.arange(-6.0, 0.001, 0.05):
        p.pose(t, np.zeros(3), 1e-14 * np.eye(3))
    for stamp, row in zip(*scale, strict=True) if scale is not None else ():
        p.scale(stamp, row)
    found, given = [], 0
    for t in np.arange(0.0, LENGTH, LOOK):
        while given < len(stamps) and stamps[given] <= t:
            p.command(stamps[given], commands[given])
            given += 1
        found.append(p.at(t).covariance)
    return np.array(found)


def sigmas(spread):
    """Root mean squares (6,) over the drive's second half."""
    return np.sqrt(np.einsum("nii->ni", spread[len(spread) // 2 :]).mean(axis=0))


def only(known, *names, size=1e-3):
    """The model with a covariance of some parameters only, independent of each other."""
    covariance = np.diag([size**2 if name in names else 0.0 for name in known.parameters])
    return replace(known, covariance=covariance)


def test_the_noise_is_the_models_as_far_as_it_is_large_enough(known):
    process = ProcessEntry(0.01, 0.02, 0.03, 0.04, 5.0)
    certain = replace(known, noise=NoiseEntry(0.002, 0.003, process))
    white = [0.0, 0.0, NOISE_START[9]]  # nothing hangs together
    assert believed_on_board(certain).tolist() == [
        0.002,
        0.003,
        0.01,
        0.02,
        0.03,
        0.04,
        5.0,
        *white,
    ]
    unknown = replace(certain, noise=NoiseEntry(0.002, 0.003))
    assert believed_on_board(unknown).tolist() == [0.002, 0.003, *NOISE_START[2:7], *white]
    hangs = replace(
        certain, noise=NoiseEntry(0.003, 0.0, process, CorrelatedEntry(0.004, 0.01, 0.2))
    )
    assert believed_on_board(hangs)[:2].tolist() == [0.003, 1e-4]
    assert believed_on_board(hangs)[7:].tolist() == [0.004, 0.01, 0.2]
    little = replace(certain, noise=NoiseEntry(0.0, 0.0, None, CorrelatedEntry(1e-7, 0.0, 1e-3)))
    assert believed_on_board(little)[7:].tolist() == [1e-5, 1e-5, 0.02]
    exact = replace(certain, noise=NoiseEntry(0.0, 0.0, ProcessEntry(0.0, 0.0, 0.0, 0.0, 0.1)))
    assert believed_on_board(exact).tolist() == [1e-4, 1e-4, 1e-6, 1e-6, 1e-5, 1e-5, 0.3, *white]


def test_what_errors_of_the_parameters_do_is_believed_to_the_last_percent(known):
    """Without poses the covariance is S C S', whatever the drive does with thrusters and boat."""
    errors = doubt(known)
    believed = spread_believed(known)
    whole = sigmas(spread_by_slopes(known, known.covariance))
    kept = sigmas(spread_by_slopes(known, errors @ errors.T))
    np.testing.assert_allclose(sigmas(believed)[3:], kept[3:], rtol=0.02)
    np.testing.assert_allclose(kept, whole, rtol=0.02)
    np.testing.assert_allclose(sigmas(believed)[:3], whole[:3], rtol=0.15)  # and a start's rest


@pytest.mark.parametrize("parameter", ["latency", "lag", "edge_forward", "X_F", "N_rr", "N_ud"])
def test_every_kind_of_parameter_is_believed(known, parameter):
    one = only(known, parameter)
    want = spread_by_slopes(one, one.covariance)
    np.testing.assert_allclose(sigmas(spread_believed(one))[3:], sigmas(want)[3:], rtol=0.03, atol=2e-5)  # fmt: skip


def test_a_latency_without_a_lag_is_believed(known):
    """Then a level jumps: that it does so at the wrong time is an impulse."""
    names = known.vehicle.constants.names
    constants = known.constants.copy()
    constants[names.index("lag")] = 0.0
    one = only(replace(known, constants=constants), "latency")
    want = spread_by_slopes(one, one.covariance)
    np.testing.assert_allclose(sigmas(spread_believed(one))[3:], sigmas(want)[3:], rtol=0.1)


def test_the_power_of_a_scale_is_believed(cse1_vehicle):
    values = {name: (0.5 if "F" in name else -0.5) for name in cse1_vehicle.structure.coefficients}
    speeds = dict.fromkeys("uvr", (-2.0, 2.0))
    made = replace(make_model(cse1_vehicle, values), envelope=EnvelopeEntry(speeds, {}))
    (power,) = [name for name in made.parameters if "scale_power" in name]
    one = only(made, power)
    scale = np.array([0.0, 4.0]), np.array([[0.3], [0.25]])
    want = spread_by_slopes(one, one.covariance, scale)
    assert sigmas(want)[3] > 1e-5
    np.testing.assert_allclose(sigmas(spread_believed(one, scale))[3:], sigmas(want)[3:], rtol=0.05, atol=2e-5)  # fmt: skip


def test_causes_never_say_more_than_the_covariance(known):
    errors = doubt(known)
    scale = np.sqrt(np.diag(known.covariance))
    left = (known.covariance - errors @ errors.T) / np.outer(scale, scale)
    assert np.linalg.eigvalsh(left).min() > -1e-9
    assert errors.shape[1] == 12
    slow = replace(known, envelope=EnvelopeEntry({}, {}))
    assert doubt(slow).shape == (len(known.parameters), 0)
    sure = replace(known, covariance=np.zeros_like(known.covariance))
    assert doubt(sure).shape[1] == 0


def test_errors_that_cancel_are_none(known):
    """A latency too long by what the lag is too short hardly moves the boat."""
    names = list(known.parameters)
    latency, lag = names.index("latency"), names.index("lag")
    late = only(known, "latency", size=2e-3)
    covariance = late.covariance.copy()
    covariance[lag, lag] = 2e-3**2
    covariance[lag, latency] = covariance[latency, lag] = -(2e-3**2)
    both = replace(known, covariance=covariance)
    assert doubt(both).shape[1] == 1
    assert np.all(sigmas(spread_believed(both))[3:] < 0.4 * sigmas(spread_believed(late))[3:])


def test_poses_leave_the_causes_what_they_are(known):
    """Schmidt's filter: what the boat's own model does not know, no number of poses teaches it."""
    one = only(known, "X_F", size=0.02)
    p, sure = (Predictor(replace(m, noise=SILENT)) for m in (one, only(known)))
    for t in np.arange(0.0, 20.0, 0.05):
        for each in (p, sure):
            each.command(t, [0.8, 0.0, 0.0])
            each.pose(t, [0.2 * t, 0.0, 0.0])
    doubted, certain = (np.sqrt(each.at(20.0).covariance[3, 3]) for each in (p, sure))
    assert doubted > 3.0 * certain
