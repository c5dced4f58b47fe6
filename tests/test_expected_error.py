# SPDX-License-Identifier: MIT
"""What a model says of its own predictions, against closed forms and what it then scores."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, at_length, in_coarse_steps, make_model
from scipy.linalg import expm

from seatrial.boat.findings import FindingKind, of_kinds
from seatrial.boat.model import Model
from seatrial.boat.schema import NoiseEntry, ProcessEntry
from seatrial.evaluation.expected_error import (
    parameter_sensitivities,
    process_noise_variance,
    variance_of,
)
from seatrial.evaluation.filtering import filter_pass, filter_series, run_filter
from seatrial.evaluation.prediction import Lookahead
from seatrial.evaluation.unexpected_error import unexpected_errors
from seatrial.evaluation.validation import validate
from seatrial.simulation.plan import DisturbanceForce, PlanFile
from seatrial.simulation.trials import plant_model, simulate
from tests.boats.plans import driven_by, planned

SEEDS = (23, 24)
FORCE = DisturbanceForce(share=0.04, correlation=2.0)

BEYOND = FindingKind.EXCEEDS_EXPECTED_ERROR


def plan_of(force: DisturbanceForce | None = FORCE, trial: str = "S7", seed: int = 5) -> PlanFile:
    return planned(
        "paper-like", trial, seed=seed, pose={"stamp_jitter": 0.0}, plant={"unmodelled": force},
        joypad={"clock_offset": 0.0},
    )  # fmt: skip


def believing(model: Model, plan: PlanFile, process: ProcessEntry) -> Model:
    noise = NoiseEntry(plan.pose.position_noise, plan.pose.heading_noise, process)
    return in_coarse_steps(replace(model, noise=noise))


def true_process(plan: PlanFile) -> ProcessEntry:
    c, share = plan.plant.coefficients, plan.plant.unmodelled.share
    linear = share * np.sqrt((c["X_F"] ** 2 + c["Y_F"] ** 2) / 2.0)
    return ProcessEntry(0.0, 0.0, float(linear), share * c["N_F"], FORCE.correlation)


@pytest.fixture(scope="module")
def drive(af):
    """A boat that something pushes, and the model that is right about it."""
    plan = plan_of()
    (trial,) = simulate(plan, af)
    return believing(plant_model(plan, af), plan, true_process(plan)), trial.recording


@pytest.mark.parametrize("seconds", [0.2, 1.0, at_length(5.0)])
def test_what_the_force_makes_is_the_closed_form(af, drive, seconds):
    """Yaw with linear drag alone: a linear system, its variance by Van Loan's matrix exponential."""
    _, recording = drive
    drag, walk, force, memory = 0.6, 0.02, 0.1, 1.5
    values = dict.fromkeys(TABLE_II["AF"], 0.0) | {"X_u": -0.5, "Y_v": -0.5, "N_r": -drag}
    process = ProcessEntry(0.001, walk, 0.001, force, memory)
    model = replace(make_model(af, values), noise=NoiseEntry(1e-3, 1e-3, process))
    look = Lookahead(model, recording)
    found = look.predict(seconds)
    variance = process_noise_variance(model, recording, look.reference, found.begun, found.index)
    a = np.array([[-drag, 1.0], [0.0, -1.0 / memory]])
    q = np.diag([walk**2, 2.0 * force**2 / memory])
    both = expm(np.block([[-a, q], [np.zeros((2, 2)), a.T]]) * seconds)
    passed = both[2:, 2:].T
    after = passed @ np.diag([0.0, force**2]) @ passed.T + passed @ both[:2, 2:]
    # the filter adds what is new of the walk at the poses, where it has not faded yet
    assert variance[2] == pytest.approx(after[0, 0], rel=0.02)


def test_what_uncertain_coefficients_make_is_what_they_make_when_moved(drive):
    """Along each column of their covariance's root, both ways, so that what is not linear falls out."""
    model, whole = drive
    recording = whole.cut(20.0, 60.0)
    errors = 0.01 * np.abs(model.coefficients)
    size = len(errors)
    common = np.linalg.cholesky(np.eye(size) + 0.5)
    spread = np.zeros((len(model.covariance),) * 2)
    spread[:size, :size] = errors[:, None] * (common @ common.T) * errors
    uncertain = replace(model, covariance=spread)
    look = Lookahead(uncertain, recording)
    found = look.predict(2.0, 20)
    total = np.zeros(3)
    for column in (errors[:, None] * common).T:
        ahead, back = (
            Lookahead(replace(model, coefficients=model.coefficients + off), recording)
            .predict(2.0, 20)
            .nu
            for off in (column, -column)
        )
        total += np.mean(np.square(ahead - back) / 4.0, axis=0)
    slopes = parameter_sensitivities(uncertain, recording, look.reference, found.begun, found.index)
    variance = variance_of(slopes, uncertain.covariance)
    np.testing.assert_allclose(variance, total, rtol=0.01)


@pytest.mark.system
def test_a_model_that_is_right_scores_what_it_foresees(drive):
    """At all horizons and from both starts; noise alone would be half of it 5 s ahead."""
    model, recording = drive
    row = validate(model, [recording], reference="stencil").recordings[0]
    assert [(h.horizon, h.start) for h in row.horizons][-1] == (5.0, "filter")
    for found in row.horizons:
        for symbol, score in found.scores.items():
            assert score.rms == pytest.approx(score.expected_rms, rel=0.1), (found.horizon, symbol)
    last = row.horizons[-1].scores
    assert all(score.rms > 1.4 * score.floor for score in last.values())
    assert not of_kinds(row.findings, BEYOND)


@pytest.mark.parametrize("earth", [False, True])
def test_with_the_disturbance_it_predicts_as_the_filter_does_without_poses(drive, earth):
    model, recording = drive
    process = msgspec.structs.replace(model.noise.process, earth_fixed=earth)
    model = replace(model, noise=msgspec.structs.replace(model.noise, process=process))
    filtered = run_filter(model, recording)
    found = Lookahead(model, recording, filtered=filtered).predict(
        2.0, 600, filtered.motion, disturbed=True
    )
    for begun, index, nu in zip(found.begun, found.index, found.nu, strict=True):
        blind = replace(recording, valid=recording.valid & (np.arange(len(recording.t)) <= begun))
        blind = filter_pass(model, blind, filter_series(blind), filtered.noise)
        # with sensitivities steps end elsewhere: their error is the difference
        np.testing.assert_allclose(nu, blind.state[index][3:6], rtol=1e-6)
    assert len(found.nu) > 3


@pytest.mark.system
def test_odometry_scores_what_the_model_foresees_and_less_than_the_model_alone(drive):
    """The force stays for 2 s: what the filter knows of it is worth most 1 s ahead.

    Process noise has one force for surge and sway, which is a tenth too large in one and too small in the other.
    """
    model, recording = drive
    (row,) = validate(model, [recording]).recordings
    of = {(h.horizon, h.start): h.scores for h in row.horizons}
    for horizon in (0.5, 1.0, 2.0, 5.0):
        for symbol, score in of[horizon, "odometry"].items():
            off = 0.1 if symbol == "r" else 0.2
            assert score.rms == pytest.approx(score.expected_rms, rel=off), (horizon, symbol)
            assert score.rms < 1.02 * of[horizon, "filter"][symbol].rms
    for symbol, score in of[1.0, "odometry"].items():
        assert score.rms < 0.9 * of[1.0, "filter"][symbol].rms, symbol


@pytest.mark.system
def test_a_boat_that_has_changed_scores_more_and_is_told(af, drive):
    model, _ = drive
    plan = plan_of(seed=6)
    heavy = planned(plan, coefficients={"X_F": 0.7 * plan.plant.coefficients["X_F"]})
    recording = driven_by(heavy, af)[0].cut(0.0, 150.0)
    found = of_kinds(validate(model, [recording]).recordings[0].findings, BEYOND)
    axes = [finding.part("axis") for finding in found]
    assert "surge" in axes
    assert "yaw" not in axes
    assert {finding.values["cause"] for finding in found} == {"change"}


@pytest.mark.system
def test_poses_that_err_otherwise_are_told_from_a_boat_that_changed(af):
    """Swinging by 4 mm within a second: far ahead that is drowned in what a strong force makes."""
    plan = plan_of(DisturbanceForce(share=0.15, correlation=2.0))
    (trial,) = simulate(plan, af)
    model = believing(plant_model(plan, af), plan, true_process(plan))
    recording = trial.recording.cut(0.0, 200.0)
    assert not of_kinds(validate(model, [recording]).recordings[0].findings, BEYOND)
    swing = 0.004 * np.sin(2.0 * np.pi * recording.t[:, None] + np.array([0.0, 1.0, 2.0]))
    shaken = replace(recording, eta=recording.eta + swing * [1.0, 1.0, 0.0])
    found = of_kinds(validate(model, [shaken]).recordings[0].findings, BEYOND)
    assert {finding.values["cause"] for finding in found} == {"pose noise"}
    assert "yaw" not in [finding.part("axis") for finding in found]


@pytest.mark.system
@pytest.mark.parametrize(("reference", "kinds"), [("smoothed", 1), ("stencil", 2)])
def test_every_error_of_an_unchanged_boat_is_marked_as_expected_or_noise(af, reference, kinds):
    """Where hardly anything pushes and intervals are narrow: pose noise is known to some per cent only."""
    process = ProcessEntry(1e-9, 1e-9, 1e-9, 1e-9, 2.0)
    cells, narrow = 0, 0
    for seed in SEEDS:
        plan = plan_of(None, seed=seed)
        (trial,) = simulate(plan, af)
        model = believing(plant_model(plan, af), plan, process)
        (row,) = validate(model, [trial.recording], reference=reference).recordings
        for found in row.horizons:
            for score in found.scores.values():
                cells += 1
                narrow += score.rms_interval[0] > score.expected_rms
                assert score.as_expected or score.at_floor, (seed, found.horizon, found.start)
    assert cells == len(SEEDS) * 3 * kinds * len((0.1, 0.2, 0.5, 1.0, 2.0, 5.0))
    assert narrow > 0


def test_a_model_without_process_noise_expects_no_error(af, drive):
    _, recording = drive
    model = make_model(af, TABLE_II["AF"])
    score = validate(model, [recording.cut(20.0, 60.0)]).recordings[0].scores["u"]
    assert score.expected_rms is None
    assert score.parameter_rms is None
    assert not score.as_expected


@pytest.mark.parametrize("seconds", [0.5, 2.0])
def test_what_stencils_miss_between_rare_poses_is_in_the_floor(af, seconds):
    """Two poses a second, as slow SLAM has them, and hardly any noise: a right model's errors are these."""
    plan = plan_of(None)
    rare = {"rate": 2.0, "position_noise": 2e-4, "heading_noise": 2e-4}
    (recording,) = driven_by(planned(plan, pose=rare), af)
    found = Lookahead(plant_model(plan, af), recording).predict(seconds)
    rms = np.sqrt(np.mean(found.errors**2, axis=0))
    assert found.floor == pytest.approx(rms, rel=0.15)
    assert rms[2] > 3e-3  # noise alone would make a tenth of it


@pytest.mark.system
def test_a_filter_that_has_seen_the_references_poses_is_not_held_against_the_boat(af):
    """One pose ahead, half a second, errors of filter and reference are in part the same."""
    rare = {"rate": 2.0, "position_noise": 5e-3, "heading_noise": 5e-3}
    plan = planned(plan_of(seed=3), pose=rare)
    (trial,) = simulate(plan, af)
    model = believing(plant_model(plan, af), plan, true_process(plan))
    (scores,) = validate(model, [trial.recording]).recordings
    assert not of_kinds(scores.findings, BEYOND)


@pytest.fixture(scope="module")
def furthest(drive):
    """The scores at the longest horizon."""
    model, recording = drive
    return validate(model, [recording.cut(20.0, 80.0)]).recordings[0].horizons[-1]


@pytest.mark.parametrize(
    ("start", "steps", "said"),
    [("filter", 2, False), ("filter", 3, True), ("stencil", 2, True), ("odometry", 3, False)],
)
def test_of_errors_that_filter_and_reference_share_no_word_is_said(furthest, start, steps, said):
    replace = msgspec.structs.replace
    far = {
        symbol: replace(score, rms=3.0 * score.rms, rms_interval=(2.9 * score.rms, 3.1 * score.rms))
        for symbol, score in furthest.scores.items()
    }
    found = unexpected_errors([replace(furthest, start=start, steps=steps, scores=far)], False)
    assert bool(found) == said
