# SPDX-License-Identifier: MIT
"""A boat on waves: its poses swing, by their errors or by what the waves do to it, and the model is that of the boat."""

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import at_length, make_model
from survey_boat import both, pulses
from test_correlated_pose_noise import SURGE, tug

from seatrial.boat.findings import FindingKind
from seatrial.boat.model_file import load, save
from seatrial.boat.schema import NoiseEntry, ProcessEntry
from seatrial.evaluation.filtering import run_filter
from seatrial.identification.console import summary
from seatrial.identification.estimator import output_error
from seatrial.identification.likelihood.noise_structures import wave_periods
from seatrial.onboard.predictor import Predictor
from tests.boats.motions import recorded, traced

PUSHED = ProcessEntry(2e-3, 1e-2, 3e-2, 5e-2, 2.0)


def waves(rng, t, period, size):
    """Sums (n, 3) of thirty waves with periods around `period` [s], `size` (3,) their standard deviations."""
    out = np.zeros((len(t), 3))
    for turn in 2.0 * np.pi / (period * rng.uniform(0.85, 1.15, 30)):
        out += np.sin(turn * t[:, None] + rng.uniform(0.0, 2.0 * np.pi, 3))
    return out / np.sqrt(15.0) * size


def on_waves(seed, period, size):
    """A recording of a boat that waves swing by `size` [m], [rad]."""
    return sailed(seed, period, moved=(size, size, size))[0]


def sailed(seed, period, *, moved=(0.0, 0.0, 0.0), pushed=(0.0, 0.0, 0.0), seconds=150.0):
    """Poses at 10 Hz, 2 mm and 2 mrad, of a boat that waves move [m, m, rad] or push [m/s^2, m/s^2, rad/s^2].

    And its velocity but for the moves.
    """
    rng = np.random.default_rng(seed)
    truth = make_model(tug([{"latency": 0.05, "lag": 0.1}]), SURGE)
    values = np.column_stack([pulses(rng, seconds, both, 0.3) for _ in range(3)])
    begin, step = np.arange(len(values)) / 20.0, 0.01
    trace = traced(truth, begin, values)
    fine = np.arange(0.0, seconds, step)
    push = waves(rng, fine, period, np.array(pushed))
    thrust = np.asarray(trace.forces(fine + step / 2)) * [SURGE["X_F"], SURGE["Y_F"], SURGE["N_F"]]
    path = midpoints(thrust, push, step)
    t = fine[::10]
    path = path[::10]
    poses = path[:, 0] + rng.normal(size=(len(t), 3)) * 2e-3
    poses += waves(rng, t, period, np.array(moved))
    return recorded(f"drive {seed}", truth.vehicle, (t, poses), (begin, values)), path[:, 1]


def midpoints(thrust, push, step):
    """Poses and velocities (n, 2, 3) by the midpoint rule, in plain numbers: an array of three is slow.

    Accelerations (n, 3) by the thrust, in body axes, and by the waves, in earth axes.
    """
    linear = [SURGE["X_u"], SURGE["Y_v"], SURGE["N_r"]]
    squares = [SURGE["X_uu"], SURGE["Y_vv"], SURGE["N_rr"]]

    def rate(x, own, waves):
        _, _, psi, u, v, r = x
        c, s = math.cos(psi), math.sin(psi)
        body = (c * waves[0] + s * waves[1], c * waves[1] - s * waves[0], waves[2])
        carried = (v * r, -u * r, 0.0)
        slow = [a * w + b * abs(w) * w for a, b, w in zip(linear, squares, (u, v, r), strict=True)]
        gained = [sum(part) for part in zip(carried, slow, own, body, strict=True)]
        return (c * u - s * v, s * u + c * v, r, *gained)

    x, path = [0.0] * 6, []
    for own, waves in zip(thrust.tolist(), push.tolist(), strict=True):
        path.append(x)
        half = [a + 0.5 * step * b for a, b in zip(x, rate(x, own, waves), strict=True)]
        x = [a + step * b for a, b in zip(x, rate(half, own, waves), strict=True)]
    return np.array(path).reshape(-1, 2, 3)


@pytest.fixture(scope="module", params=[(1.5, 0.02), at_length((4.0, 0.1))], ids=["1.5 s", "4 s"])
def on_swell(request):
    period, size = request.param
    recordings = [on_waves(seed, period, size) for seed in (1, 2)]
    return period, size, output_error(recordings, tug())


@pytest.mark.system
def test_swinging_poses_are_no_motion(on_swell):
    """Without a kind of noise that swings, disturbances stood for it, and drag came out 5 times too large."""
    _, _, model = on_swell
    for name, value in SURGE.items():
        error = model.standard_errors[name]
        assert model.values[name] == pytest.approx(value, abs=4.5 * error), name
        assert error < max(0.02 * abs(value), 0.03), name
    assert not model.findings_of(FindingKind.MODEL_MISMATCH)


def test_the_swing_is_found_and_said(on_swell, tmp_path):
    period, size, model = on_swell
    swings = model.noise.correlated
    assert swings.period == pytest.approx(period, rel=0.1)
    assert swings.position == pytest.approx(size, rel=0.5)
    assert swings.memory > period
    assert f"oscillating with a period of {swings.period:.2g} s" in summary(model)
    save(model, tmp_path / "model.yaml")
    assert load(tmp_path / "model.yaml").noise.correlated.period == pytest.approx(swings.period)


def test_the_velocity_on_board_is_without_the_swing(on_swell):
    """In batch and live; a filter that is not told of the swing takes it for motion."""
    period, size, model = on_swell
    recording, nu = sailed(7, period, moved=(size, size, size), seconds=60.0)
    own = model.noise
    noises = (
        NoiseEntry(own.position, own.heading, PUSHED, own.correlated),
        NoiseEntry(size, size, PUSHED),
    )
    told, deaf = ([f(replace(model, noise=n), recording) for f in (batch, live)] for n in noises)
    settled = recording.t > 10.0

    def off(found):
        return np.sqrt(np.mean((found - nu)[settled] ** 2, axis=0))

    assert (off(told[0]) < 0.8 * off(deaf[0])).all()
    assert (off(told[1]) < 0.8 * off(deaf[1])).all()
    np.testing.assert_allclose(told[1][settled], told[0][settled], atol=3.0 * off(told[0]).min())


def batch(model, recording):
    return run_filter(model, recording).motion.nu


def live(model, recording):
    """Fed as the boat's node is."""
    predictor, commands, given, found = Predictor(model), recording.commands, 0, []
    stamps = 1e-9 * (commands.stamps - recording.origin)
    for t, eta in zip(recording.t, recording.eta, strict=True):
        while given < len(stamps) and stamps[given] <= t:
            predictor.command(stamps[given], commands.values[given])
            given += 1
        predictor.pose(t, eta)
        found.append(predictor.at(t).velocity)
    return np.array(found)


def test_poses_too_rare_for_waves_are_tried_for_none():
    for period, known in ((0.1, True), (4.0, False)):
        assert bool(len(wave_periods(period))) == known
