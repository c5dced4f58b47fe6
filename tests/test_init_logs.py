# SPDX-License-Identifier: MIT
"""`init` on logs of autopilots: the file it writes reads the truth, by the parameters of the log."""

import re
from dataclasses import replace
from functools import partial
from pathlib import Path

import autopilot_logs
import init_tools
import numpy as np
import pytest
from autopilot_logs import ARMED, DISARMED, HOLONOMIC, TWIN, ardupilot, trial
from cli_tools import done
from conftest import at_length
from mavlink_logs import telemetry
from px4_logs import px4

from seatrial.boat.vehicle import load_vehicle
from seatrial.inspection.overview import inspect
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices
from seatrial.io.reader import read
from seatrial.util.errors import RecordingError

WRITERS = {
    "run.BIN": ardupilot,
    "run.log": lambda path, run: ardupilot(path, run, text=True),
    "run.ulg": px4,
    "old.ulg": lambda path, run: px4(path, run, old=True),
    "run.tlog": telemetry,
}
BOATS = {"twin": TWIN, "holonomic": HOLONOMIC}
FRD, FLU = "forward-right-down", "forward-left-up"
proposed = partial(init_tools.proposed, axes=FRD)


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    made = {}
    for boat, hull in BOATS.items():
        (folder / boat).mkdir()
        for name, write in WRITERS.items():
            made[boat, name] = write(folder / boat / name, trial(hull))
    return made


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("boat", BOATS)
@pytest.mark.parametrize("axes", [FRD, at_length(FLU)])
def test_the_proposed_file_reads_the_truth(logs, name, boat, axes):
    """Position within GNSS's noise, heading and yaw rate, commands to the resolution of a pulse."""
    _, vehicle = proposed(logs[boat, name], axes=axes)
    recording = read(logs[boat, name], vehicle)
    run = trial(BOATS[boat])
    stamps = recording.stamps * 1e-9
    # the clock's zero is that of the first position, 0.031 s after the trial's begin
    t = stamps - stamps[0] + 0.031
    truth = run.at(t)
    north, east = truth[:, :2].T
    expected = (north, -east) if axes == FRD else (east, north)
    origin = np.array([x[0] for x in expected])
    error = recording.eta[:, :2] - np.array(expected).T
    error -= np.median(error, axis=0)
    assert np.abs(error).max() < 0.12
    assert np.abs(origin).max() < 1.0
    psi = -truth[:, 2] if axes == FRD else np.pi / 2 - truth[:, 2]
    turned = np.angle(np.exp(1j * (recording.eta[:, 2] - psi)))
    assert np.abs(turned).max() < 0.1  # interpolated from 20 Hz, at up to 3.8 rad/s
    armed = (t > ARMED) & (t < run.seconds - DISARMED)
    held = recording.commands
    at = np.searchsorted(held.stamps, recording.stamps, side="right") - 1
    began = (held.stamps[at] - recording.stamps[0]) * 1e-9 + 0.031
    known = armed & (at >= 0) & (began > ARMED)
    exact = np.abs(held.values[at] - run.command_at(began + 0.002))[known]
    assert known.sum() > 400
    assert np.mean(exact.max(axis=1) < 0.002) > 0.98  # but for ticks within a millisecond of a step


@pytest.mark.parametrize("name", WRITERS)
def test_forces_of_a_holonomic_boat_are_found(logs, name):
    found, vehicle = proposed(logs["holonomic", name])
    x, y, angle = np.array(HOLONOMIC.thrusters).T
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    for force, signs in (("F_u", c), ("F_v", s), ("F_r", x * s - y * c)):
        weights = found.drive.forces[force]["of"]
        assert [np.sign(w) for w in weights.values()] == np.sign(signs).tolist()
        assert list(weights) == [f"motor_{i}" for i in range(1, 5)]
    assert inspect([read(logs["holonomic", name], vehicle)], vehicle).signs.findings == ()


@pytest.mark.parametrize(
    ("name", "position", "heading", "rate", "commands"),
    [
        ("run.BIN", "GPS Lat, Lng", "ATT Yaw", "IMU GyrZ", "RCOU C3"),
        ("run.ulg", "sensor_gps latitude_deg, longitude_deg", "vehicle_attitude q[1], q[2], q[3], q[0]",
         "sensor_combined gyro_rad[2]", "actuator_motors control[1]"),
        ("old.ulg", "vehicle_gps_position lat, lon", "vehicle_attitude q[1], q[2], q[3], q[0]",
         "sensor_combined gyro_rad[2]", "actuator_motors control[1]"),
        ("run.tlog", "GPS_RAW_INT lat, lon", "ATTITUDE yaw", "ATTITUDE yawspeed",
         "SERVO_OUTPUT_RAW servo3_raw"),
    ],
)  # fmt: skip
def test_raw_positions_before_the_filters(logs, name, position, heading, rate, commands):  # noqa: PLR0917
    found, _ = proposed(logs["twin", name])
    columns = {r.signal: r.column for r in found.sources.recognised}
    assert (columns["position"], columns["heading"], columns["yaw rate"]) == (
        position,
        heading,
        rate,
    )
    assert commands in columns.values()
    (row,) = (r for r in found.sources.recognised if r.signal == "position")
    assert any("filter" in other for other in row.others)


def test_odometry_of_px4s_filter_is_a_pose_where_there_is_no_other(tmp_path):
    run = trial(TWIN, seconds=40.0)
    others = ("sensor_gps", "vehicle_attitude", "vehicle_local_position")
    log = px4(tmp_path / "run.ulg", run, without=others)
    found, vehicle = proposed(log)
    assert [r.column for r in found.sources.recognised[:2]] == [
        "vehicle_odometry position[0], position[1]",
        "vehicle_odometry q[1], q[2], q[3], q[0]",
    ]
    recording = read(log, vehicle)
    truth = run.at(recording.t + 0.007) * [1, -1, -1, 1, -1, -1]  # forward-left-up
    np.testing.assert_allclose(recording.eta, truth[:, :3], atol=1e-5)


def test_the_battery_is_a_scale_where_it_falls(logs):
    """16.6 to 15.4 V."""
    _, vehicle = proposed(logs["twin", "run.BIN"])
    assert vehicle.file.scales["battery"].reference == pytest.approx(16.0)
    recording = read(logs["twin", "run.BIN"], vehicle)
    assert recording.scales.values[[0, -1], 0] == pytest.approx([16.6, 15.4], abs=0.02)


def test_a_voltage_that_is_never_positive_is_no_scale(tmp_path):
    """Of a sensor that is wired the wrong way round."""
    run = trial(TWIN, 60.0)
    path = ardupilot(tmp_path / "run.BIN", replace(run, volts=-run.volts))
    assert proposed(path)[1].file.scales == {}


def test_another_position_is_chosen_by_its_topic(logs):
    found, vehicle = proposed(logs["twin", "run.BIN"], pose="POS")
    assert found.sources.pose["topic"] == vehicle.file.pose.topic == "POS"
    _, vehicle = proposed(logs["twin", "run.ulg"], pose="vehicle_local_position")
    recording = read(logs["twin", "run.ulg"], vehicle)
    assert np.abs(recording.eta[:, 0] - trial(TWIN).at(recording.t)[:, 0]).max() < 0.2
    with pytest.raises(RecordingError, match=r"BAT is no topic with a position.*GPS Lat, Lng"):
        proposed(logs["twin", "run.BIN"], pose="BAT")


def test_outputs_without_parameters_are_those_that_change(logs, tmp_path):
    """Pulses get the usual trim, and 0 is off."""
    data = logs["twin", "run.BIN"].read_bytes().replace(b"SERVO", b"XERVO")
    path = tmp_path / "run.BIN"
    path.write_bytes(data)
    found, vehicle = proposed(path)
    assert set(vehicle.inputs) == {"C1", "C3"}
    c = vehicle.file.commands.inputs["C3"]
    assert (c.offset, c.scale, c.off) == (1500.0, 400.0, 0.0)
    assert found.drive.forces["F_r"]["of"]["C1"] > 0
    assert found.drive.forces["F_u"]["of"]["C3"] < 0  # reversed, which no parameter states


def test_commands_are_chosen_by_their_topic(logs):
    _, vehicle = proposed(logs["twin", "run.BIN"], commands="RCOU")
    assert set(vehicle.inputs) == {"throttle_left", "throttle_right"}
    with pytest.raises(RecordingError, match=r"no topic NONE \(--commands\); it has ARM, ATT"):
        proposed(logs["twin", "run.BIN"], commands="NONE")


@pytest.mark.parametrize(
    ("lost", "message"),
    [(b"GPS", "positions|position"), (b"ATT", "heading"), (b"RCOU", "motor outputs")],
)
def test_what_a_log_lacks_is_named(tmp_path, lost, message):
    """With what to do, and the topics that there are."""
    path = ardupilot(tmp_path / "run.BIN", trial(TWIN, 30.0))
    data = path.read_bytes()
    for word in (lost, *([b"POS"] if lost == b"GPS" else [])):  # the names of their definitions
        data = data.replace(word.ljust(4, b"\0"), (b"ZZ" + word[2:]).ljust(4, b"\0"), 1)
    path.write_bytes(data)
    with pytest.raises(RecordingError, match=message) as caught:
        init(path, choices=Choices(axes=FRD))
    assert "BAT" in str(caught.value)


def test_positions_without_a_fix_are_none(tmp_path, monkeypatch):
    monkeypatch.setattr(autopilot_logs, "geodetic", lambda north, east: (0.0 * north, 0.0 * east))
    path = ardupilot(tmp_path / "run.BIN", trial(TWIN, 30.0))
    with pytest.raises(
        RecordingError, match=r"GPS has 0 in 150 messages, POS has 0 in 150 messages \(no fix"
    ):
        init(path, choices=Choices(axes=FRD))


def test_the_command_needs_no_axes(logs, tmp_path, capsys):
    """An autopilot's are known; the next command that it names runs."""
    out = tmp_path / "vehicle.yaml"
    path = logs["twin", "run.ulg"]
    text = done(capsys, "init", path, "-o", out)
    assert "axes: forward-right-down" in text
    assert "how sure" in text
    assert "consistent with the vehicle file" in done(capsys, "inspect", path, "--vehicle", out)
    assert "actuator_motors" in done(capsys, "inspect", path)


def test_the_documented_vehicle_file_reads_a_log(logs, tmp_path):
    page = Path(__file__).resolve().parents[1] / "docs" / "formats.md"
    (block,) = re.findall(r"^```yaml\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)
    rest = """seatrial: vehicle 1
name: twin
forces:
  F_u: {axis: surge, of: {left: 0.5, right: 0.5}}
  F_r: {axis: yaw, of: {left: 0.5, right: -0.5}}
structure: auto
"""
    (tmp_path / "vehicle.yaml").write_text(rest + block)
    vehicle = load_vehicle(tmp_path / "vehicle.yaml")
    assert inspect([read(logs["twin", "run.BIN"], vehicle)], vehicle).signs.findings == ()


# Fields that the user chooses. #

CHOSEN = {  # fields of position, heading, yaw rate and motors, as `init` finds them by itself
    "run.BIN": ("lat=GPS/Lat,lon=GPS/Lng", "heading=ATT/Yaw", "yaw_rate=IMU/GyrZ", "left=RCOU/C1,right=RCOU/C3"),
    "run.log": ("lat=GPS/Lat,lon=GPS/Lng", "heading=ATT/Yaw", "yaw_rate=IMU/GyrZ", "left=RCOU/C1,right=RCOU/C3"),
    "old.ulg": ("lat=vehicle_gps_position/lat,lon=vehicle_gps_position/lon", "heading=vehicle_attitude/q[3]",
                "yaw_rate=sensor_combined/gyro_rad[2]", "left=actuator_motors/control[0],right=actuator_motors/control[1]"),
    "run.tlog": ("lat=GPS_RAW_INT/lat,lon=GPS_RAW_INT/lon", "heading=ATTITUDE/yaw", "yaw_rate=ATTITUDE/yawspeed",
                 "left=SERVO_OUTPUT_RAW/servo1_raw,right=SERVO_OUTPUT_RAW/servo3_raw"),
}  # fmt: skip


@pytest.mark.parametrize("axes", [at_length(FRD), FLU])
@pytest.mark.parametrize("name", CHOSEN)
def test_chosen_fields_read_as_those_that_are_recognised(logs, name, axes):
    """All of them, the position alone, the heading alone, the commands alone."""
    position, heading, rate, motors = CHOSEN[name]
    path = logs["twin", name]
    _, usual = proposed(path, axes=axes)
    expected = read(path, usual)
    for pose, commands in (
        (f"{position},{heading},{rate}", motors), (position, None), (heading, None), (None, motors),
    ):  # fmt: skip
        found, vehicle = proposed(path, axes=axes, pose=pose, commands=commands)
        recording = read(path, vehicle)
        np.testing.assert_allclose(recording.eta, expected.eta, atol=1e-9)
        np.testing.assert_array_equal(recording.stamps, expected.stamps)
        assert vehicle.file.pose.yaw_rate == usual.file.pose.yaw_rate
        np.testing.assert_allclose(recording.commands.values, expected.commands.values)
        assert vehicle.inputs == (("left", "right") if commands else usual.inputs)
        chosen = {r.signal for r in found.sources.recognised if r.sure.value == "chosen"}
        assert ("heading" in chosen, "left" in chosen) == ("heading" in str(pose), bool(commands))


def test_another_position_and_heading_than_those_recognised(logs):
    """Metres north and east of the filter, its heading in radians."""
    pose = "x=vehicle_local_position/x,y=vehicle_local_position/y,heading=vehicle_local_position/heading"
    path = logs["twin", "run.ulg"]
    found, vehicle = proposed(path, pose=pose)
    recording, run = read(path, vehicle), trial(TWIN)
    assert found.sources.pose["topic"] == "vehicle_local_position"
    truth = run.at((recording.stamps - recording.stamps[0]) * 1e-9 + 0.007)
    np.testing.assert_allclose(recording.eta[:, :2], truth[:, :2] * [1, -1], atol=1e-3)
    turned = np.angle(np.exp(1j * (recording.eta[:, 2] + truth[:, 2])))
    assert np.abs(turned).max() < 1e-3


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"pose": "heading=ATT/Yam"}, "topic ATT has no field 'Yam' (--pose); did you mean Yaw?"),
        ({"pose": "x=GP/Lat,y=GPS/Lng"}, "no topic GP (--pose); did you mean GPS?"),
        ({"pose": "heading=Yaw"}, "--pose Yaw: expected TOPIC/FIELD; the topics are "),
        ({"pose": "course=ATT/Yaw"}, "expected NAME=COLUMN,NAME=COLUMN with x, y, east,"),
        ({"pose": "stamp=GPS/Lat"}, "expected NAME=COLUMN,NAME=COLUMN with x, y, east,"),
        ({"pose": "x=GPS/Lat,heading=ATT/Yaw"}, "--pose has x; give x and y, east and north, or lat and lon"),
        ({"pose": "lat=GPS/Lat,lon=POS/Lng"}, "both coordinates are columns of one table"),
        ({"commands": "left=RCOU/C99"}, "topic RCOU has no field 'C99' (--commands); did you mean C9?"),
        ({"commands": "left=RCOU/C1,left=RCOU/C3"}, "left is there twice"),
        ({"commands": "RCOU/C1,C3"}, "no topic RCOU/C1,C3 (--commands)"),
    ],
)  # fmt: skip
def test_a_field_that_is_not_there_is_refused_with_those_that_are(logs, options, line):
    with pytest.raises(RecordingError, match=re.escape(line)):
        init(logs["twin", "run.BIN"], choices=Choices(axes=FRD, **options))
