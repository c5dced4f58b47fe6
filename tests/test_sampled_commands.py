# SPDX-License-Identifier: MIT
"""Commands that a logger sampled: a change counts as halfway between two samples, with the error of that."""

from dataclasses import replace

import numpy as np
import pytest
from recording_tools import beside_poses

from seatrial import identify
from seatrial.boat.findings import FindingKind, finding_text
from seatrial.boat.noise_parameters import NOISE_START
from seatrial.evaluation.input_errors import input_errors
from seatrial.identification.estimator import fit, output_error
from seatrial.identification.first_search import first_maximum
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import search
from seatrial.identification.problem_setup import problem_with, start_of, with_start
from seatrial.identification.selection.command_sampling import sampled_commands_of
from seatrial.identification.solution import OutputErrorSettings
from seatrial.identification.term_choice import choose_terms
from seatrial.identification.uncertainty.command_shape import with_ramps, with_unknown_shape
from seatrial.identification.uncertainty.covariance import sandwich_covariance
from seatrial.identification.uncertainty.dead_zone import with_dead_zone_profile
from seatrial.onboard.live.playback import replay
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.util.statistics import NORMAL_95
from tests.boats import hulls
from tests.boats.hulls import MIDDLE, driven

PERIOD = 0.1  # [s]
LAG = 0.12  # [s]


def sampled(recording: Recording) -> Recording:
    """The recording as a logger has it that looks at the commands every 0.1 s, in the middle of two ticks."""
    known = recording.commands
    stamps = np.arange(int(known.stamps[0]) + 10_000_000, int(known.stamps[-1]), 100_000_000)
    held = known.values[np.searchsorted(known.stamps, stamps, side="right") - 1]
    return replace(
        recording,
        commands=Signal(known.names, stamps, held),
        command_period=PERIOD,
        command_sampled=True,
    )


@pytest.fixture(scope="module")
def boat():
    """A vehicle, and two drives of it whose commands are samples."""
    vehicle, recordings = driven(MIDDLE, {"lag": LAG}, seed=3, white=0.003)
    return vehicle, [sampled(r) for r in recordings]


def theta_of(vehicle) -> np.ndarray:
    return np.array([MIDDLE.coefficients[name] for name in vehicle.structure.coefficients])


def with_commands(recording: Recording, values: list[float]) -> Recording:
    """Surge commands, 0.1 s apart."""
    rows = np.zeros((len(values), 3))
    rows[:, 0] = values
    stamps = recording.origin + 100_000_000 * np.arange(len(values))
    signal = Signal(recording.commands.names, stamps, rows)
    return replace(recording, commands=signal, command_period=PERIOD, command_sampled=True)


def test_a_step_was_at_any_time_between_two_samples(boat):
    vehicle, (one, _) = boat
    at, covariance = input_errors(
        vehicle, theta_of(vehicle), with_commands(one, [0, 0, 0, 0.8, 0.8, 0.8])
    )
    step = 0.8 * MIDDLE.coefficients["X_F"]
    np.testing.assert_allclose(at, 0.1 * np.arange(6), atol=1e-12)
    own = np.diff(covariance[:, 0]) / ((step * PERIOD) ** 2 / 12.0)
    np.testing.assert_allclose(own, [0.0, 0.0, 0.5, 1.0, 0.5], atol=1e-12)


def test_a_ramp_is_known_but_at_its_ends(boat):
    vehicle, (one, _) = boat
    ramp = [0, 0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.6, 0.6]
    _, covariance = input_errors(vehicle, theta_of(vehicle), with_commands(one, ramp))
    own = np.diff(covariance[:, 0]) / ((0.1 * MIDDLE.coefficients["X_F"] * PERIOD) ** 2 / 12.0)
    np.testing.assert_allclose(own, [0, 0.5, 0.5, 0, 0, 0, 0, 0.5, 0.5], atol=1e-12)


def test_commands_with_stamps_of_their_own_have_no_such_error(boat):
    vehicle, (one, _) = boat
    assert input_errors(vehicle, theta_of(vehicle), replace(one, command_period=0.0)) is None


def point(vehicle, recordings) -> Point:
    """The filter's run at start values."""
    problem = problem_with(vehicle, vehicle, recordings, OutputErrorSettings())
    theta, _ = start_of(problem, recordings, None)
    problem = with_start(problem, theta)
    return Point(theta, NOISE_START, filter_along(problem, theta, NOISE_START))


def test_the_linearised_run_has_the_same_errors(boat):
    vehicle, recordings = boat
    here = point(vehicle, recordings)
    assert here.runs.linearised().cost(NOISE_START) == pytest.approx(here.runs.cost, rel=1e-5)


def test_the_filter_is_less_sure_of_the_velocity(boat):
    vehicle, recordings = boat
    here = point(vehicle, recordings)
    exact = filter_along(replace(here.runs.problem, input_errors=()), here.theta, NOISE_START)
    with_errors, without = (
        np.asarray(runs.by_recording[0].deviation) for runs in (here.runs, exact)
    )
    assert np.nanmean(with_errors / without) > 1.1


@pytest.fixture(scope="module")
def model(boat):
    vehicle, recordings = boat
    return output_error(recordings, vehicle)


def test_coefficients_latency_and_lag_are_within_their_intervals(boat, model):
    vehicle, recordings = boat
    truth = {**MIDDLE.coefficients, "latency": 0.0, "lag": LAG}
    found = dict(zip(model.parameters, [*model.coefficients, *model.constants], strict=True))
    off = {
        name: (found[name] - value) / model.standard_errors[name]
        for name, value in truth.items()
        if name in found
    }
    assert {"X_F", "Y_F", "N_F", "latency", "lag"} <= set(off)
    assert max(map(abs, off.values())) < 3.0
    # the same samples, each taken for the time of its change
    late = output_error([replace(r, command_period=0.0) for r in recordings], vehicle)
    found = dict(zip(late.parameters, [*late.coefficients, *late.constants], strict=True))
    assert found["latency"] < -10.0 * late.standard_errors["latency"]


def test_a_ramp_has_the_mean_and_the_variance_of_a_steady_change(boat):
    _, (one, _) = boat
    step = with_commands(one, [0, 0, 0.8, 0.8])
    ramp = with_ramps(step, PERIOD)
    np.testing.assert_allclose(ramp.commands.values[-1], step.commands.values[-1])
    changes = np.diff(ramp.commands.values[:, 0])
    times = ramp.seconds(ramp.commands.stamps)[1:][changes > 0]
    changes = changes[changes > 0]
    mean = float(changes @ times) / 0.8
    assert mean == pytest.approx(0.2, abs=1e-8)
    assert float(changes @ (times - mean) ** 2) / 0.8 == pytest.approx(PERIOD**2 / 12.0, rel=1e-6)


def test_ramps_of_irregular_samples_sum_up(boat):
    _, (one, _) = boat
    rows = with_commands(one, [0, 0.5, -0.2, 0.9])
    close = rows.commands.stamps[0] + np.array([0, 100_000_000, 110_000_000, 111_000_000])
    ramp = with_ramps(replace(rows, commands=replace(rows.commands, stamps=close)), PERIOD)
    np.testing.assert_allclose(ramp.commands.values[[0, -1], 0], [0.0, 0.9], atol=1e-12)


def test_what_a_ramp_would_make_of_the_estimates_is_in_their_errors(boat):
    vehicle, recordings = boat
    found = fit(recordings, vehicle)
    at = search(found.problem, found.theta, found.noise, hold=True)[0]
    plain = with_dead_zone_profile(at, sandwich_covariance(at))
    wider = with_unknown_shape(at, plain) - plain
    # against the solution with ramps
    ramps = replace(at.runs.problem, recordings=tuple(with_ramps(r, PERIOD) for r in recordings))
    there = search(ramps, at.theta, at.noise, hold=True)[0]
    move = (there.theta - at.theta)[list(at.runs.problem.free)]
    lag = found.names.index("lag")
    assert wider[lag, lag] == pytest.approx(move[lag] ** 2, rel=0.1)
    assert abs(move[lag]) > 0.01 * LAG
    # commands with stamps of their own have no such error
    exact = replace(
        at.runs.problem, recordings=tuple(replace(r, command_period=0.0) for r in recordings)
    )
    here = Point(at.theta, at.noise, filter_along(exact, at.theta, at.noise))
    assert with_unknown_shape(here, plain) is plain


@pytest.mark.system
def test_the_lag_of_sticks_that_ramp_is_within_its_interval():
    """A stick takes 0.2 s from rest to its end."""

    def ramps(rng, seconds):
        wanted, most = hulls.sticks(rng, seconds), 5.0 * hulls.TICK
        out = np.zeros_like(wanted)
        for i in range(1, len(out)):
            out[i] = out[i - 1] + np.clip(wanted[i] - out[i - 1], -most, most)
        return out

    vehicle, recordings = driven(
        MIDDLE, {"lag": LAG}, seed=3, white=0.003, seconds=600.0, pattern=ramps
    )
    found = fit([sampled(r) for r in recordings], vehicle)
    place = found.names.index("lag")
    off = found.theta[found.problem.names.index("lag")] - LAG
    assert abs(off) < NORMAL_95 * np.sqrt(found.covariance[place, place])
    # by the scatter of the innovations alone it is not
    at = search(found.problem, found.theta, found.noise, hold=True)[0]
    alone = np.sqrt(sandwich_covariance(at)[place, place])
    assert abs(off) > NORMAL_95 * alone


def test_odometry_of_a_log_has_each_change_halfway(boat, model):
    _, exact = driven(MIDDLE, {"lag": LAG}, seed=3, white=0.003, drives=1)
    logs = {"exact": exact[0], "halfway": sampled(exact[0])}
    logs["late"] = replace(logs["halfway"], command_period=0.0)
    speeds = {
        name: {o.stamp: o.motion.velocity for o in replay(model, r)} for name, r in logs.items()
    }
    times = sorted(set.intersection(*map(set, speeds.values())))
    true, halfway, late = (np.array([found[t] for t in times]) for found in speeds.values())
    errors = [np.sqrt(np.mean((one - true) ** 2, axis=0)) for one in (halfway, late)]
    assert np.all(errors[0] < 0.8 * errors[1])


def test_the_recordings_show_which_it_is(boat):
    """Of a column beside the poses nobody knows it."""
    vehicle, recordings = boat
    looked_at = [replace(r, command_sampled=False) for r in recordings]
    at = first_maximum(looked_at, vehicle)
    found = sampled_commands_of(at, vehicle)
    assert found.gain > 100.0
    _, changed = driven(MIDDLE, {"lag": LAG}, seed=3, white=0.003)
    exact = [replace(r, command_period=0.1) for r in changed]
    assert sampled_commands_of(first_maximum(exact, vehicle), vehicle) is None


def test_the_doubt_stays_where_the_recordings_show_no_samples(boat):
    """Of samples the error may pass as correlated pose noise."""
    vehicle, _ = boat
    _, changed = driven(MIDDLE, {"lag": LAG}, seed=3, white=0.003)
    exact = [beside_poses(r, PERIOD) for r in changed]
    model = identify(exact, vehicle.with_automatic_structure())
    assert model.vehicle.file.commands.sampled is None
    assert any("rows of the commands" in warning for warning in model.warnings)


def test_a_model_of_terms_that_the_recordings_choose_says_so(boat):
    vehicle, recordings = boat
    looked_at = [replace(r, command_sampled=False) for r in recordings]
    choice = choose_terms(looked_at, vehicle.with_automatic_structure())
    assert choice.vehicle.file.commands.sampled
    (finding,) = [f for f in choice.findings if f.kind is FindingKind.COMMANDS_SAMPLED]
    assert "'sampled: true'" in finding_text(finding)
    stated = choose_terms(recordings, vehicle.with_automatic_structure())
    assert not stated.findings
