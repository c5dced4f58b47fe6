# SPDX-License-Identifier: MIT
"""Commands in autopilots' logs and in tables: which are samples, by the log or the vehicle file."""

from dataclasses import replace

import numpy as np
import pytest
from autopilot_logs import TWIN, ardupilot, trial
from logs import nanoseconds

from seatrial import identify, load_vehicle
from seatrial import read as read_recording
from seatrial.boat.findings import FindingKind
from seatrial.boat.model import sampling_period
from seatrial.io.convert import convert
from seatrial.recording.sampled_commands import (
    are_samples,
    sampled_commands,
    sampling_doubt,
    sampling_unknown,
)
from seatrial.recording.timing import Clock, describe
from seatrial.util.errors import SeatrialError

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


@pytest.mark.system
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


def signals(source, clock, rate):
    """Poses at 10 Hz of a.csv, and commands of a source."""
    commands = describe(
        "commands", source, "", clock=clock, stamps=nanoseconds(np.arange(200) / rate)
    )
    poses = describe(
        "poses", "a.csv", "table", clock=Clock.COLUMN, stamps=nanoseconds(np.arange(200) / 10.0)
    )
    return [poses, commands]


@pytest.mark.parametrize(("source", "clock"), [("RCOU", Clock.LOG), ("a.csv", Clock.COLUMN)])
def test_rare_samples_of_commands_are_found(source, clock):
    found = sampled_commands(signals(source, clock, 10.0))
    assert found.source == source
    assert found.rate == pytest.approx(10.0)
    assert are_samples(found) == (clock is Clock.LOG)
    assert are_samples(found, stated=True)
    assert not are_samples(found, stated="estimate")
    assert sampled_commands(signals(source, clock, 10.0), stated=False) is None


@pytest.mark.parametrize(("source", "clock"), [("RCOU", Clock.LOG), ("b.csv", Clock.COLUMN)])
def test_rows_may_be_samples_where_they_are_rarer_than_a_loop(source, clock):
    """Those of a fast loop are the commands themselves; 20 ms apart they may be either."""
    found = sampled_commands(signals(source, clock, 50.0))
    assert not are_samples(found)
    assert are_samples(found, stated=True)
    assert sampled_commands(signals(source, clock, 250.0)) is None
    assert sampled_commands(signals(source, clock, 250.0), stated="estimate").rate > 249.0


def test_messages_are_commands_themselves():
    assert sampled_commands(signals("/joy", Clock.HEADER, 10.0)) is None
    assert sampled_commands(signals("/joy", Clock.HEADER, 10.0), stated=True).source == "/joy"
