# SPDX-License-Identifier: MIT
"""A current, wind or trim of the recordings as process noise: what a filter that does not know of it is to expect."""

from dataclasses import replace

import numpy as np
import pytest
from survey_boat import boat

import seatrial
from seatrial.boat.noise_parameters import DISTURBANCES, MEMORY, NOISE_LEAST
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.effects_as_noise import with_effects_as_noise
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.recording.from_poses import make_recording
from seatrial.recording.velocity import Motion, motion
from seatrial.simulation.plan import DisturbanceForce
from tests.boats.drives import follow, of_recording
from tests.boats.hulls import MIDDLE, driven

FLOW = 0.04  # [m/s]
MUNK = {"surge": ["X_u * u"], "sway": ["Y_v * v"], "yaw": ["N_uv * u * v"]}
X_U, Y_V, N_UV = -0.2, -0.6, -2.5
SPEED, TURN = 0.8, 0.25  # [m/s], [rad/s]


def circle(speed, turn):
    """Steady through the water, whole turns at 20 Hz."""
    t = np.arange(0.0, 20.0 * np.pi / TURN, 0.05)
    nu = np.tile([speed, 0.0, turn], (len(t), 1))
    eta = np.column_stack([0.0 * t, 0.0 * t, turn * t])
    return Motion(t, eta, nu, np.ones(len(t), dtype=bool))


def as_noise(effects, path, noise=NOISE_LEAST):
    """Disturbances and memory, and whether they are earth-fixed."""
    vehicle = vehicle_from(boat().to_mapping() | {"structure": MUNK}, "munk")
    values = {"X_u": X_U, "Y_v": Y_V, "N_uv": N_UV}
    theta = np.array([values[n] for n in vehicle.structure.coefficients])
    found, earth = with_effects_as_noise(noise, [effects], [path], vehicle, theta)
    return found[DISTURBANCES], found[MEMORY], earth


def test_a_current_turns_a_boat_at_speed_by_its_munk_moment():
    """By hand: the water's velocity across is FLOW sin, so the moment missed is N_uv u FLOW / sqrt(2) (RMS)."""
    (linear, yaw), memory, _ = as_noise({"current_x": FLOW, "current_y": 0.0}, circle(SPEED, TURN))
    square = FLOW**2 / 2.0
    own = (X_U**2 + Y_V**2) / 2.0 * square  # drag
    own += (
        TURN**2 * square
    )  # no Coriolis terms in this structure: the current's own turn in body axes
    assert linear == pytest.approx(np.sqrt(own), rel=0.01)
    across = np.sqrt(square * SPEED**2 + square**2 / 2.0)  # of (u + c cos) c sin
    cosine = (
        np.arccos(1.0 / np.e) / TURN
    )  # memory of one in body axes; the drag lasts longer in earth axes
    assert memory == pytest.approx(cosine, rel=0.1)
    # the quicker axis changes within a short time as it does with its own memory
    assert yaw == pytest.approx(
        abs(N_UV) * across * np.sqrt(memory / cosine), rel=0.02
    )  # lags of 0.1 s


def test_a_current_on_a_boat_that_lies_still_is_its_drag_and_lasts():
    path = circle(0.0, 0.0)
    along = replace(path, nu=np.tile([-FLOW, 0.0, 0.0], (len(path.t), 1)))
    (linear, yaw), memory, earth = as_noise({"current_x": FLOW, "current_y": 0.0}, along)
    assert linear == pytest.approx(abs(X_U) * FLOW / np.sqrt(2.0)) and yaw < 1e-8
    assert memory == pytest.approx(30.0) and earth


def test_without_a_velocity_a_current_is_taken_to_pass_a_boat_at_rest_on_any_heading():
    path = circle(SPEED, TURN)
    none = replace(path, valid=np.zeros(len(path.t), dtype=bool))
    (linear, _), _, _ = as_noise({"current_x": FLOW, "current_y": 0.0}, none)
    assert linear == pytest.approx(FLOW * np.sqrt((X_U**2 + Y_V**2) / 4.0), rel=0.01)


def test_gusts_beside_a_steady_force_stay_as_quick_as_they_are():
    """Sums of variances, and of variances over memories: twice the latter is the force's change in a short time."""
    noise = NOISE_LEAST.copy()
    noise[DISTURBANCES], noise[MEMORY] = (0.03, 0.02), 1.5
    trim = {"trim_u": 0.05, "trim_v": 0.01, "trim_r": 0.01}
    (linear, yaw), memory, _ = as_noise(trim, circle(SPEED, TURN), noise)
    steady = (0.05**2 + 0.01**2) / 2.0, 0.01**2
    squares = 0.03**2 + steady[0], 0.02**2 + steady[1]
    changes = 0.03**2 / 1.5 + steady[0] / 30.0, 0.02**2 / 1.5 + steady[1] / 30.0
    assert memory == pytest.approx(sum(squares) / sum(changes))
    # yaw changes quicker than a force of this memory and its variance would
    assert changes[1] * memory > squares[1]
    assert linear == pytest.approx(np.sqrt(squares[0]))
    assert yaw == pytest.approx(np.sqrt(changes[1] * memory))


@pytest.mark.system
@pytest.mark.parametrize("seed", [1, 2])
def test_in_the_current_of_its_recordings_a_filters_intervals_hold_the_velocity(seed):
    """Of a hull that is long and narrow. They held the surge velocity in 60 and 68 % of cases."""
    hull = replace(MIDDLE, mass=(11.0, 22.0, 0.9))
    push = DisturbanceForce(0.02, 1.5)
    vehicle, exact = driven(
        hull, {"latency": 0.06, "lag": 0.1}, seed=seed, push=push, white=1e-9, rate=25.0, drives=3
    )
    rng = np.random.default_rng(seed)
    flow = np.array([0.05, -0.03, 0.0])
    seen, truth = [], []
    for one in exact:
        way = one.raw + one.t[:, None] * flow
        truth.append(motion(make_recording(one.name, one.stamps, way, one.commands)))
        noisy = way + 3e-3 * rng.normal(size=way.shape)
        seen.append(make_recording(one.name, one.stamps, noisy, one.commands))
    model = output_error(seen[:2], vehicle, settings=OutputErrorSettings(effects=("current",)))
    after = truth[2].t > 5.0
    asked = truth[2].valid & after
    track = follow(seatrial.Predictor(model), of_recording(seen[2]), truth[2].t[asked])
    off = track.state[:, 3:] - truth[2].nu[asked]
    spread = np.sqrt(np.diagonal(track.covariance, axis1=1, axis2=2)[:, 3:])
    inside = np.mean(np.abs(off) < 1.96 * spread, axis=0)
    assert inside.min() > 0.85, inside
    assert spread.mean() < 1.5 * off.std(), (spread.mean(axis=0), off.std(axis=0))
