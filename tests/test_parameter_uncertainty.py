# SPDX-License-Identifier: MIT
"""What the on-board filter believes of a model: its noise, and the errors of its parameters."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import make_model

import seatrial
from benchmarks.predictor import accuracy
from seatrial import _core
from seatrial.boat.noise_parameters import NOISE_START
from seatrial.boat.schema import (
    CorrelatedEntry,
    EnvelopeEntry,
    EstimatorEntry,
    NoiseEntry,
    ProcessEntry,
)
from seatrial.onboard.parameter_uncertainty import onboard_uncertainty
from seatrial.onboard.predictor import Predictor
from tests.boats.drives import SCENES, model

EXACT = next(iter(SCENES))
SILENT = NoiseEntry(1e-4, 1e-4, ProcessEntry(0.0, 0.0, 0.0, 0.0, 0.3))
LENGTH, LOOK = 40.0, 0.1  # [s]


@pytest.fixture(scope="module")
def known() -> seatrial.Model:
    return model(EXACT, accuracy.SEED)


@pytest.fixture(scope="module")
def vague(known) -> seatrial.Model:
    """The same, but that structure and noise do not explain what was recorded."""
    found = known.estimator
    settings_ = {**found.settings, "belief": 0.8}
    return replace(known, estimator=msgspec.structs.replace(found, settings=settings_))


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
    trace = _core.ThrustTrace(known.vehicle.chain, known.constants, *args)
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
    white = [0.0, 0.0, NOISE_START[9], 0.0, 1.0]  # nothing is correlated, sway is as surge
    assert onboard_uncertainty(certain).noise.tolist() == [
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
    assert onboard_uncertainty(unknown).noise.tolist() == [0.002, 0.003, *NOISE_START[2:7], *white]
    coloured = replace(
        certain, noise=NoiseEntry(0.003, 0.0, process, CorrelatedEntry(0.004, 0.01, 0.2))
    )
    assert onboard_uncertainty(coloured).noise[:2].tolist() == [0.003, 1e-4]
    assert onboard_uncertainty(coloured).noise[7:11].tolist() == [0.004, 0.01, 0.2, 0.0]
    little = replace(certain, noise=NoiseEntry(0.0, 0.0, None, CorrelatedEntry(1e-7, 0.0, 1e-3)))
    assert onboard_uncertainty(little).noise[7:11].tolist() == [1e-5, 1e-5, 0.02, 0.0]
    exact = replace(certain, noise=NoiseEntry(0.0, 0.0, ProcessEntry(0.0, 0.0, 0.0, 0.0, 0.1)))
    assert onboard_uncertainty(exact).noise.tolist() == [
        1e-4,
        1e-4,
        1e-6,
        1e-6,
        1e-5,
        1e-5,
        0.3,
        *white,
    ]


def test_what_errors_of_the_parameters_do_is_believed_to_the_last_percent(known):
    """Without poses the covariance is S C S', whatever the drive does with thrusters and boat."""
    errors = onboard_uncertainty(known).errors
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


def test_the_power_of_a_scale_is_believed(known, cse1_vehicle):
    values = {name: (0.5 if "F" in name else -0.5) for name in cse1_vehicle.structure.coefficients}
    speeds = dict.fromkeys("uvr", (-2.0, 2.0))
    made = replace(
        make_model(cse1_vehicle, values),
        envelope=EnvelopeEntry(speeds, {}), estimator=known.estimator,
    )  # fmt: skip
    (power,) = [name for name in made.parameters if "scale_power" in name]
    one = only(made, power)
    scale = np.array([0.0, 4.0]), np.array([[0.3], [0.25]])
    want = spread_by_slopes(one, one.covariance, scale)
    assert sigmas(want)[3] > 1e-5
    np.testing.assert_allclose(sigmas(spread_believed(one, scale))[3:], sigmas(want)[3:], rtol=0.05, atol=2e-5)  # fmt: skip


def test_causes_never_say_more_than_the_covariance(known):
    errors = onboard_uncertainty(known).errors
    scale = np.sqrt(np.diag(known.covariance))
    left = (known.covariance - errors @ errors.T) / np.outer(scale, scale)
    assert np.linalg.eigvalsh(left).min() > -1e-9
    assert errors.shape[1] == 12
    slow = replace(known, envelope=EnvelopeEntry({}, {}))
    assert onboard_uncertainty(slow).errors.shape == (len(known.parameters), 0)
    sure = replace(known, covariance=np.zeros_like(known.covariance))
    assert onboard_uncertainty(sure).errors.shape[1] == 0


def test_errors_that_cancel_are_none(known):
    """A latency too long by what the lag is too short hardly moves the boat."""
    names = list(known.parameters)
    latency, lag = names.index("latency"), names.index("lag")
    late = only(known, "latency", size=2e-3)
    covariance = late.covariance.copy()
    covariance[lag, lag] = 2e-3**2
    covariance[lag, latency] = covariance[latency, lag] = -(2e-3**2)
    both = replace(known, covariance=covariance)
    assert onboard_uncertainty(both).errors.shape[1] == 1
    assert np.all(sigmas(spread_believed(both))[3:] < 0.4 * sigmas(spread_believed(late))[3:])


def test_poses_leave_the_causes_what_they_are(known):
    """Schmidt's filter: what the boat's own model does not know, no number of poses teaches it."""
    one = only(known, "X_F", size=0.02)
    sound = (one, only(known), only(known))
    p, sure, boat = (Predictor(replace(m, noise=SILENT)) for m in sound)
    boat.pose(0.0, np.zeros(3))
    for t in np.arange(0.0, 20.0, 0.05):
        for each in (boat, p, sure):
            each.command(t, [0.8, 0.0, 0.0])
        for each in (p, sure):
            each.pose(t, boat.at(t).pose)
    doubted, certain = (np.sqrt(each.at(20.0).covariance[3, 3]) for each in (p, sure))
    assert doubted > 3.0 * certain


def doubt(model):
    """Noise (10,) that the errors of the parameters alone amount to."""
    return onboard_uncertainty(replace(model, noise=SILENT)).noise


def power(noise):
    """Of the disturbances (2,) at low frequency."""
    return 2.0 * noise[4:6] ** 2 * noise[6]


def test_only_where_structure_and_noise_explain_the_recordings_are_errors_constants(known, vague):
    paper = replace(known, estimator=EstimatorEntry("equation-error", {}))
    for model_, exact in ((known, True), (vague, False), (paper, False)):
        found, own = onboard_uncertainty(model_), onboard_uncertainty(replace(known, covariance=0.0 * known.covariance))  # fmt: skip
        assert (found.errors.shape[1] > 0) == exact
        assert np.array_equal(found.noise, own.noise) == exact


def test_what_the_errors_of_a_model_do_is_added_in_variance_and_in_power(vague):
    own = replace(vague, noise=NoiseEntry(0.002, 0.003, ProcessEntry(0.01, 0.02, 2e-5, 1e-4, 5.0)))
    alone = doubt(vague)
    noise = onboard_uncertainty(own).noise
    np.testing.assert_allclose(noise[2:4], np.hypot([0.01, 0.02], alone[2:4]), rtol=1e-3)
    # whatever the shared memory is
    np.testing.assert_allclose(power(noise), power(alone) + 2.0 * np.array([2e-5, 1e-4]) ** 2 * 5.0, rtol=1e-3)  # fmt: skip
    slow = replace(own, envelope=EnvelopeEntry({}, {}))
    np.testing.assert_allclose(onboard_uncertainty(slow).noise[2:7], [0.01, 0.02, 2e-5, 1e-4, 5.0])


def test_the_doubt_gives_the_velocity_the_error_that_other_parameters_give_it(vague):
    """Beside boats with parameters drawn from the covariance, driven by the same commands."""
    random, n = np.random.default_rng(3), len(vague.coefficients)
    t = np.arange(0.0, 300.0, 0.1)
    stamps = np.cumsum(random.uniform(1.0, 3.0, 140)) - 1.0
    rows = random.uniform(-1.0, 1.0, (140, 3))
    drawn = random.multivariate_normal(np.zeros(len(vague.parameters)), vague.covariance, 40)

    def velocity(off):
        other = replace(
            vague, coefficients=vague.coefficients + off[:n], constants=vague.constants + off[n:]
        )
        args = (np.zeros(0), np.zeros((0, 0)), False, [], [])
        trace = _core.ThrustTrace(other.vehicle.chain, other.constants, stamps, rows, *args)
        return _core.simulate(other.boat, trace, np.zeros(6), t)[0][:, 3:]

    own = velocity(0.0 * drawn[0])
    wrong = np.array([velocity(off) - own for off in drawn])
    spread = np.sqrt(np.mean(wrong[:, 200:] ** 2, axis=(0, 1)))
    damping = -np.array([_damping(vague, own[200::50], a) for a in range(3)])
    noise = doubt(vague)
    both = power(noise) + noise[2:4] ** 2  # surge and sway share one
    np.testing.assert_allclose(
        np.sqrt(both / (2.0 * np.array([np.mean(damping[:2]), damping[2]]))),
        [np.sqrt(np.mean(spread[:2] ** 2)), spread[2]], rtol=0.35,
    )  # fmt: skip


def _damping(vague, nu, axis):
    """Mean d nu_dot / d nu of an axis [1/s]."""
    step = 1e-4 * np.eye(3)[axis]
    force = np.zeros((len(nu), 3))
    ends = [
        _core.accelerations(
            vague.structure.compiled, vague.coefficients, np.ascontiguousarray(nu + s), force
        )
        for s in (step, -step)
    ]
    return float(np.mean((ends[0] - ends[1])[:, axis]) / 2e-4)


def test_doubts_that_cancel_in_part_count_less(vague):
    """Thrust and drag by one factor less: the boat goes as fast, only changes take longer."""
    names, values = list(vague.parameters), np.array([*vague.coefficients, *vague.constants])
    alone, tied = np.zeros_like(vague.covariance), np.zeros_like(vague.covariance)
    row = np.array([0.02 * x if n in ("X_u", "X_uu", "X_F") else 0.0 for n, x in zip(names, values, strict=True)])  # fmt: skip
    tied[:] = np.outer(row, row)
    alone[:] = np.diag(row**2)
    one, other = (doubt(replace(vague, covariance=c)) for c in (tied, alone))
    assert power(one)[0] < 0.9 * power(other)[0]


def test_noise_of_a_latency_and_a_lag_that_cancel_is_none(vague):
    names, n = vague.vehicle.constants.names, len(vague.coefficients)
    latency, lag = n + names.index("latency"), n + names.index("lag")
    covariance = np.zeros_like(vague.covariance)
    covariance[latency, latency] = 0.002**2
    late = doubt(replace(vague, covariance=covariance))
    assert late[2] > 1e-5
    assert late[4:6].tolist() == [1e-5, 1e-5]  # the least
    covariance[lag, lag] = 0.002**2
    covariance[lag, latency] = covariance[latency, lag] = -(0.002**2)
    both = doubt(replace(vague, covariance=covariance))
    assert np.all(both[2:4] < 0.3 * late[2:4])
