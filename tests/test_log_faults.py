# SPDX-License-Identifier: MIT
"""Logs with the faults that real ones have: the right numbers with honest intervals, or one clear line."""

from contextlib import suppress

import msgspec
import numpy as np
import pytest

import seatrial
from seatrial.boat.schema import Column
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.poolside.drive_log import DriveLog
from seatrial.poolside.sources import open_source
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import RecordingError
from tests.boats.log_faults import FAULTS, vehicle_for, written
from tests.boats.plans import planned

NAMES = ("S1", "S2", "S3")
HONEST = 3.0  # standard errors


@pytest.fixture(scope="module")
def trials(mp):
    """Poses and commands of three clean trials."""
    plan = planned("paper-like", *NAMES, seconds=100.0)
    made = {t.name[:2]: t for t in simulate(plan, mp)}
    found = {}
    for name in NAMES:
        trial = made[name]
        poses = np.column_stack([1e-9 * trial.pose_stamps, trial.pose])
        commands = np.column_stack([1e-9 * trial.command_stamps, trial.command])
        found[name] = (poses[poses[:, 0] >= 0], commands)
    return found


RIGHT = sorted(set(FAULTS) - {"utm_single_precision", "utm_eight_digits"})


@pytest.mark.system
@pytest.mark.parametrize("fault", RIGHT)
def test_the_coefficients_are_those_of_the_boat(mp, trials, fault, tmp_path):
    vehicle = vehicle_for(mp, fault)
    recordings = [seatrial.read(path, vehicle) for path in written(trials, fault, tmp_path)]
    model = seatrial.identify(recordings, vehicle)
    truth = plant_model(load_plan("paper-like"), mp).values
    for name, error in model.standard_errors.items():
        if name in truth and error > 0:
            assert abs(model.values[name] - truth[name]) < HONEST * error, name


@pytest.mark.parametrize("fault", ["held_position", "empty_position", "latitude_longitude"])
def test_position_and_heading_are_each_used_where_they_are_new(mp, trials, fault, tmp_path):
    vehicle = vehicle_for(mp, fault)
    recording = seatrial.read(written(trials, fault, tmp_path)[0], vehicle)
    rows = len(trials["S1"][0])
    assert len(recording.t) == (rows + 1) // 2
    assert len(recording.asynchronous.stamps) == rows // 2
    assert any("two rates" in remark for remark in recording.remarks)


def test_bursts_are_named_and_put_on_the_clock_that_the_poses_left_with(mp, trials, tmp_path):
    vehicle = vehicle_for(mp, "arrival_bursts")
    recording = seatrial.read(written(trials, "arrival_bursts", tmp_path)[0], vehicle)
    assert "bursts" in recording.remarks[-1] and "15 Hz" in recording.remarks[-1]
    right = trials["S1"][0][:, 0]
    off = recording.t - (right - right[0])
    assert np.std(off) < 1.2e-3 and np.ptp(off) < 6e-3  # before: 0.2 s


def live_log(vehicle, path):
    """The drive log of a live session that a replay fills."""
    log = DriveLog(vehicle)
    for event in open_source(str(path), vehicle, 0.0):
        log.add(event.kind, event.stamp, event.values)
    return log


def test_a_live_session_reads_bursts_as_the_log_is_read(mp, trials, tmp_path):
    vehicle = vehicle_for(mp, "arrival_bursts")
    path = written(trials, "arrival_bursts", tmp_path)[0]
    log = live_log(vehicle, path)
    whole = log.recording()
    np.testing.assert_array_equal(whole.stamps, seatrial.read(path, vehicle).stamps)
    assert "bursts" in log.doubt and "15 Hz" in log.doubt and not log.coarse


def test_a_live_session_names_rounded_coordinates(mp, trials, tmp_path):
    vehicle = vehicle_for(mp, "utm_eight_digits")
    log = live_log(vehicle, written(trials, "utm_eight_digits", tmp_path)[0])
    with suppress(RecordingError):
        log.recording()
    assert "x moves in steps of 0.01 m, y in steps of 0.1 m" in log.doubt and log.coarse


def test_a_disarmed_autopilot_without_off_is_refused_with_the_line_to_add(mp, trials, tmp_path):
    vehicle = vehicle_for(mp, "pwm_zero_disarmed")
    inputs = {n: Column(column=n, offset=1500, scale=400) for n in mp.inputs}
    commands = msgspec.structs.replace(vehicle.file.commands, inputs=inputs)
    wrong = Vehicle(msgspec.structs.replace(vehicle.file, commands=commands))
    recordings = [seatrial.read(p, wrong) for p in written(trials, "pwm_zero_disarmed", tmp_path)]
    with pytest.raises(RecordingError, match=r"is -3.75 on .*off: 0"):
        seatrial.identify(recordings, wrong)


def test_a_compass_is_one_edit_of_the_heading(mp, trials, tmp_path):
    vehicle = vehicle_for(mp, "compass", psi={"column": "psi", "unit": "deg"})
    recordings = [seatrial.read(p, vehicle) for p in written(trials, "compass", tmp_path)]
    (finding,) = check_consistency(recordings, vehicle).findings
    assert finding.kind is InconsistencyKind.HEADING
    assert "set sign: -1, offset: 90 at pose: psi" in finding.text


@pytest.mark.parametrize(
    ("fault", "steps"),
    [
        ("utm_single_precision", "x moves in steps of 0.062 m, y in steps of 0.5 m"),
        ("utm_eight_digits", "x moves in steps of 0.01 m, y in steps of 0.1 m"),
    ],
)
def test_rounded_coordinates_are_named_with_their_steps(mp, trials, fault, steps, tmp_path):
    vehicle = vehicle_for(mp, fault)
    said = []
    for path in written(trials, fault, tmp_path):
        try:
            said += seatrial.read(path, vehicle).doubts
        except RecordingError as error:
            said.append(str(error))
    assert len(said) == len(NAMES) and all(steps in text for text in said)
    assert (fault == "utm_single_precision") == all("log them as 64-bit" in text for text in said)
