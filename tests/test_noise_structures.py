# SPDX-License-Identifier: MIT
"""Searches that begin anew: of boats that are pushed, with correlated pose errors."""

from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from conftest import at_length

from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.disturbed_intervals import squared_innovations
from seatrial.identification.estimator import Fit, fit
from seatrial.identification.likelihood import noise_structures as subject
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.noise_structures import (
    DISTURBANCE_MEMORY,
    SWITCH_GAIN,
    force_for_walk,
    refined,
    simplified,
)
from seatrial.identification.likelihood.optimiser import maximise_likelihood
from seatrial.identification.likelihood.start_noise import correlated_size, noise_from_poses
from seatrial.identification.likelihood.whiteness import is_white
from seatrial.simulation.plan import DisturbanceForce, load_plan, with_seed
from seatrial.simulation.trials import simulate
from tests.boats.drives import CORRELATED, LASTS, SCENES, trials
from tests.boats.scenes import CORRELATION, TRAINING, scenes, true_parameters

PUSHED = list(SCENES)[1]
# seeds whose search has errors last as long as they may for many steps, though nothing pushes
LONG = {"correlated 0.3 mm": 1087, "correlated 8 mm": 1092}
LET_GO, WALKING = 41, 46  # seeds: without correlated errors, with a walk for the push
OWN_BOAT = {
    "X_u": -0.30, "X_uu": -1.2, "X_F": 0.20, "Y_v": -0.35, "Y_vv": -1.5, "Y_F": 0.15,
    "N_r": -0.6, "N_rr": -0.35, "N_F": 1.0, "N_ud": 0.04, "N_uu": 0.4,
}  # fmt: skip
DRIFTING = 13  # a seed whose search has errors last as long as they may for eight steps
SIGMA = 4e-3  # [m], [rad] of the preset's poses
TRUTH = load_plan("hard").plant.coefficients
PUSH = SCENES[PUSHED] * np.array([TRUTH["X_F"], TRUTH["N_F"]])  # [m/s^2, rad/s^2]
RATIO = TRUTH["Y_F"] / TRUTH["X_F"]
# the filter's noise as the plan has it
AS_DRIVEN = np.array([1e-4, 1e-4, 1e-9, 1e-9, *PUSH, LASTS, SIGMA, SIGMA, CORRELATION, 1e-9, RATIO])


def solved(seed: int) -> Fit:
    made = trials(CORRELATED[PUSHED], seed, TRAINING)
    return fit([made[name].recording for name in TRAINING], made["S1"].vehicle)


@pytest.fixture(scope="module")
def found() -> Fit:
    return solved(LET_GO)


@pytest.mark.system
def test_a_pushed_boat_whose_pose_errors_hang_together_is_found(found):
    """By differences the poses look white, and such a boat much less damped than it is."""
    truth = true_parameters(load_plan("hard"), found.names)
    theta = found.theta[list(found.problem.free)]
    errors = np.array([found.errors[name] for name in found.names])
    assert np.all(np.abs(theta - truth) < 4.5 * errors)
    drags = [found.names.index(name) for name in ("X_u", "Y_v", "N_r")]
    assert np.all(errors[drags] < 0.3 * np.abs(truth[drags]))
    coloured = found.model().noise.correlated
    assert coloured is not None
    assert [coloured.position, coloured.heading, coloured.memory] == pytest.approx(
        [SIGMA, SIGMA, CORRELATION], rel=0.15
    )


@pytest.mark.system
def test_it_is_as_likely_as_what_a_search_from_the_truth_finds(found):
    """Such errors and white ones are hard to tell apart: the top is flat, and not quite even."""
    problem = found.problem
    truth = found.theta.copy()
    truth[list(problem.free)] = true_parameters(load_plan("hard"), found.names)
    best = simplified(maximise_likelihood(problem, truth, AS_DRIVEN))
    assert found.runs.cost < best.runs.cost + SWITCH_GAIN


@pytest.mark.system
def test_a_push_that_comes_and_goes_is_not_taken_for_a_random_walk():
    process = solved(WALKING).model().noise.process
    assert [process.disturbance_linear, process.disturbance_yaw] == pytest.approx(PUSH, rel=0.15)
    assert process.sway_ratio == pytest.approx(RATIO, rel=0.15)
    assert process.walk_linear < 1e-3


@pytest.mark.parametrize("name", ["correlated 0.3 mm", at_length("correlated 8 mm")])
def test_errors_that_last_long_for_many_steps_are_no_motion_where_nothing_pushes(name):
    scene = scenes()[name]
    made = scene.trials(LONG[name])
    found = fit([trial.recording for trial in made.values()], made["S1-MP"].vehicle)
    theta = found.theta[list(found.problem.free)]
    errors = np.array([found.errors[n] for n in found.names])
    assert np.all(np.abs(theta - true_parameters(scene.plan, found.names)) < 4.5 * errors)
    coloured = found.model().noise.correlated
    assert coloured is not None
    assert coloured.memory == pytest.approx(0.3, rel=0.15)


@pytest.mark.system
def test_where_errors_drift_the_search_begins_with_all_of_them_hanging_together(mp):
    """Without them it crept for 40 steps, and good recordings were refused."""
    found, truth = solved_on(mp, OWN_BOAT, DRIFTING)
    theta = found.theta[list(found.problem.free)]
    errors = np.array([found.errors[n] for n in found.names])
    assert np.all(np.abs(theta - truth) < 4.5 * errors)
    push = SCENES[PUSHED] * np.array(
        [np.sqrt(0.5 * (OWN_BOAT["X_F"] ** 2 + OWN_BOAT["Y_F"] ** 2)), OWN_BOAT["N_F"]]
    )
    driven = AS_DRIVEN.copy()
    driven[[4, 5]] = push
    there = found.theta.copy()
    there[list(found.problem.free)] = truth
    assert (
        found.runs.cost < maximise_likelihood(found.problem, there, driven).runs.cost + SWITCH_GAIN
    )
    process = found.model().noise.process
    assert [process.disturbance_linear, process.disturbance_yaw] == pytest.approx(push, rel=0.2)
    assert process.walk_linear < 1e-3


def solved_on(
    vehicle: Vehicle, coefficients: dict[str, float], seed: int
) -> tuple[Fit, np.ndarray]:
    """What a pushed boat of these coefficients is found to be, and the truth."""
    plan = with_seed(load_plan("hard"), seed)
    replace = msgspec.structs.replace
    plan = replace(
        plan,
        plant=replace(
            plan.plant,
            coefficients=coefficients,
            unmodelled=DisturbanceForce(SCENES[PUSHED], LASTS),
        ),
        pose=replace(plan.pose, noise_correlation=CORRELATION),
        trials={name: replace(plan.trials[name], duration=150.0) for name in TRAINING},
    )
    made = list(simulate(plan, vehicle))
    found = fit([trial.recording for trial in made], made[0].vehicle)
    return found, true_parameters(plan, found.names)


@pytest.mark.system
def test_white_innovations_and_the_right_frame_are_searched_no_further(found, monkeypatch):
    def refused(*_, **__):
        raise AssertionError("another noise structure is searched")

    at = Point(found.theta, found.noise, filter_along(found.problem, found.theta, found.noise))
    assert is_white(at)
    assert not at.runs.problem.earth_fixed
    monkeypatch.setattr(subject, "search", refused)
    # whether a push is unequal that is so by little is searched
    monkeypatch.setattr(subject, "with_unequal_axes", lambda at: at)
    monkeypatch.setattr(subject, "SOURCES", subject.SOURCES[:-1])
    assert refined(at) is at


def test_innovations_of_a_filter_that_diverged_are_not_white():
    """Their variances are no numbers or below zero; they counted as white."""
    white = np.random.default_rng(1).normal(size=(500, 3))
    for variance, expected in ((1.0, True), (-1.0, False), (np.nan, False)):
        spread = np.tile([1.0, 0.0, 0.0, 1.0, 0.0, variance], (500, 1))
        run = SimpleNamespace(spread=spread, innovation=white, weight=np.ones(500))
        assert is_white(SimpleNamespace(runs=SimpleNamespace(by_recording=[run]))) is expected


@pytest.mark.parametrize("wave", [0.0, 1.0])
def test_positions_between_two_headings_are_white_where_their_own_innovations_are(wave):
    """They have no innovation of the heading, and counted as of a filter that diverged: a model mismatch."""
    own = np.random.default_rng(1).normal(size=(500, 3)) + wave * np.sin(np.arange(500.0))[:, None]
    own[:, 2] = np.nan
    spread = np.tile([1.0, 0.0, np.nan, 1.0, np.nan, np.nan], (500, 1))
    run = SimpleNamespace(spread=spread, innovation=own, weight=np.ones(500))
    assert is_white(SimpleNamespace(runs=SimpleNamespace(by_recording=[run]))) is (wave == 0.0)
    squares = squared_innovations(run)
    np.testing.assert_allclose(squares, np.sum(own[:, :2] ** 2, axis=1).clip(max=squares.max()))


def test_a_force_in_place_of_a_walk_moves_the_velocity_as_far():
    """Both added up in small steps, over a time long beside the force's memory."""
    walk = 8e-3
    dt, n, memory = 0.05, 8000, DISTURBANCE_MEMORY
    rng = np.random.default_rng(8)
    fades = np.exp(-dt / memory)
    force = float(force_for_walk(np.array([walk]))[0])
    d = force * rng.normal(size=500)
    renewed = force * np.sqrt(1.0 - fades**2)
    v = np.zeros(500)
    for _ in range(n):
        v += d * dt
        d = fades * d + renewed * rng.normal(size=500)
    assert np.std(v) == pytest.approx(walk * np.sqrt(n * dt), rel=0.1)


@pytest.mark.system
def test_correlated_errors_as_large_as_they_are_have_the_fourth_differences_of_white_ones(found):
    """The poses have no white noise; differences alone take it for a third of its size."""
    recordings = found.problem.recordings
    white = noise_from_poses(recordings)[:2]
    assert np.all(white < 0.5 * SIGMA)
    size = correlated_size(found.problem.period, CORRELATION)
    assert white * size == pytest.approx([SIGMA, SIGMA], rel=0.05)
