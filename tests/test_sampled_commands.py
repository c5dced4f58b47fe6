# SPDX-License-Identifier: MIT
"""Commands that a logger sampled: a change counts as halfway between two samples, with the error of that."""

from dataclasses import replace

import numpy as np
import pytest
from autopilot_logs import TWIN, ardupilot, trial
from recording_tools import beside_poses

from seatrial import identify, load_vehicle
from seatrial import read as read_recording
from seatrial.boat.findings import FindingKind, finding_text
from seatrial.boat.model import sampling_period
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
from seatrial.io.convert import convert
from seatrial.onboard.live.playback import replay
from seatrial.recording.recording import Recording
from seatrial.recording.sampled_commands import sampling_doubt, sampling_unknown
from seatrial.recording.signal import Signal
from seatrial.util.errors import SeatrialError
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


AUTOPILOT = """seatrial: vehicle 1
name: twin
axes: forward-right-down
pose:
  topic: GPS
  latitude: {field: Lat}
  longitude: {field: Lng}
  psi: {topic: ATT, field: Yaw, unit: deg}
commands:
  topic: RCOU
  inputs:
    left: {field: C1, offset: 1500, scale: 400, "off": 0}
    right: {field: C3, offset: 1500, scale: 400, "off": 0, sign: -1}
forces:
  F_u: {axis: surge, of: {left: 0.5, right: 0.5}}
  F_r: {axis: yaw, of: {left: 0.5, right: -0.5}}
structure: auto
"""
GYRO = "  yaw_rate: {topic: IMU, field: GyrZ}"
TABLE = """seatrial: vehicle 1
name: barge
axes: forward-left-up
pose: {stamp: t, x: {column: x}, y: {column: y}, psi: {column: psi}}
commands: {stamp: t, inputs: {ahead: {column: ahead}}}
forces: {F_u: {axis: surge, of: {ahead: 1.0}}}
structure: auto
"""


def vehicle_of(tmp_path, text):
    path = tmp_path / "vehicle.yaml"
    path.write_text(text)
    return load_vehicle(path)


def test_an_autopilot_log_has_samples_of_its_outputs(tmp_path):
    log = ardupilot(tmp_path / "run.BIN", trial(seconds=20.0))
    found = read_recording(log, vehicle_of(tmp_path, AUTOPILOT))
    assert found.command_period == pytest.approx(0.1, rel=1e-3)
    assert found.command_sampled
    (remark,) = [r for r in found.remarks if "samples" in r]
    assert "RCOU are samples, 0.1 s apart: each change counts as halfway" in remark
    assert not found.doubts


def test_rows_of_an_autopilots_log_are_samples_where_the_recordings_show_it(tmp_path):
    """At 25 Hz they may be the outputs of its loop, or samples of them; thrust that is late tells."""
    truth = {
        "latency": 0.0,
        "X_F": 2 * TWIN.full / TWIN.mass[0],
        "N_F": 0.6 * TWIN.full / TWIN.mass[2],
    }
    vehicle = vehicle_of(tmp_path, AUTOPILOT.replace("pose:", f"pose:\n{GYRO}"))
    log = ardupilot(tmp_path / "run.BIN", trial(), outputs=25.0)
    looked_at = read_recording(log, vehicle)
    assert looked_at.command_period == pytest.approx(0.04, rel=1e-3)
    assert not looked_at.command_sampled
    model = identify([looked_at], vehicle)
    assert model.findings_of(FindingKind.COMMANDS_SAMPLED)
    assert not model.warnings
    off = {n: (model.parameter_values[n] - x) / model.standard_errors[n] for n, x in truth.items()}
    assert max(map(abs, off.values())) < 3.0
    late = identify([replace(looked_at, command_period=0.0)], vehicle)
    assert late.parameter_values["latency"] < -10.0 * late.standard_errors["latency"]
    # a table of it keeps the question
    convert(log, tmp_path / "out", vehicle)
    known = load_vehicle(tmp_path / "out" / "vehicle.yaml")
    again = read_recording(tmp_path / "out", known)
    assert known.file.commands.sampled == "estimate"
    assert sampling_unknown(again)
    assert again.command_period == pytest.approx(0.04, rel=1e-3)


def test_a_column_beside_the_poses_may_be_exact(tmp_path):
    rows = [f"{0.1 * k:.1f},{0.01 * k},0,0,{k // 40 % 2}" for k in range(300)]
    path = tmp_path / "run.csv"
    path.write_text("\n".join(["t,x,y,psi,ahead", *rows]))
    found = read_recording(path, vehicle_of(tmp_path, TABLE))
    assert found.command_period == pytest.approx(0.1)
    assert not found.command_sampled
    (doubt,) = sampling_doubt(found)
    assert "'sampled: false' if each row is a new command" in doubt
    for stated in ("true", "false"):
        text = TABLE.replace("commands: {", f"commands: {{sampled: {stated}, ")
        vehicle = vehicle_of(tmp_path, text)
        again = read_recording(path, vehicle)
        assert sampling_period(vehicle, again) == pytest.approx(0.1 if stated == "true" else 0.0)
        assert not sampling_doubt(again)


def test_a_table_of_commands_may_be_samples_and_whoever_wrote_it_is_not_asked(tmp_path):
    """Who writes a table of commands writes each of them, as a rule; where not, the likelihood says so."""
    poses = [f"{0.2 * k:.1f},{0.01 * k},0,0" for k in range(150)]
    (tmp_path / "poses.csv").write_text("\n".join(["t,x,y,psi", *poses]))
    rows = [f"{0.1 * k:.1f},{k // 40 % 2}" for k in range(300)]
    (tmp_path / "commands.csv").write_text("\n".join(["t,ahead", *rows]))
    text = TABLE.replace("pose: {", "pose: {file: poses.csv, ").replace(
        "commands: {", "commands: {file: commands.csv, "
    )
    found = read_recording(tmp_path, vehicle_of(tmp_path, text))
    assert found.command_period == pytest.approx(0.1)
    assert sampling_unknown(found)
    assert not sampling_doubt(found)


def test_what_is_no_truth_value_is_refused(tmp_path):
    text = TABLE.replace("commands: {", "commands: {sampled: maybe, ")
    with pytest.raises(
        SeatrialError, match=r"commands\.sampled: got 'maybe'; expected true or false, or estimate"
    ):
        vehicle_of(tmp_path, text)
    with pytest.raises(SeatrialError, match="sampled: expected true, false or a word, got a whole"):
        vehicle_of(tmp_path, text.replace("maybe", "1"))


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
