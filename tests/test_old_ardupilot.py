# SPDX-License-Identifier: MIT
"""Logs of ArduPilot from 2013 and 2014: the formats of ArduCopter 3.1 and 3.0, as public logs have them."""

import struct

import autopilot_logs
import numpy as np
import pytest
from autopilot_logs import TWIN, binary_message, geodetic, text_message, trial
from init_tools import proposed

import seatrial
from seatrial.io.formats import open_log
from seatrial.io.log import Wanted
from seatrial.util.errors import RecordingError

BOOT = 95_890  # [ms] since the autopilot began; the week is far further on
OLD = {
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "PARM": (129, "Nf", "Name,Value"),
    "GPS": (130, "BIHBcLLeeEefI", "Status,TimeMS,Week,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs,VZ,T"),
    "IMU": (131, "Iffffff", "TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    "RCOU": (134, "Ihhhhhhhh", "TimeMS," + ",".join(f"Chan{i}" for i in range(1, 9))),
    "ATT": (1, "IccccCC", "TimeMS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
}  # fmt: skip
OLDER = {
    "GPS": (130, "BIBcLLeeEe", "Status,Time,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs"),
    "ATT": (1, "cccccCC", "RollIn,Roll,PitchIn,Pitch,YawIn,Yaw,NavYaw"),
}  # fmt: skip


def drive(path, monkeypatch, formats, *, text):
    """Of 60 s of a boat: positions at 5 Hz, 40 ms after the rest; the trial."""
    monkeypatch.setattr(autopilot_logs, "FORMATS", OLD | formats)
    run, message = trial(TWIN, 60.0, 0), text_message if text else binary_message
    parts = [b"ArduRover V2.43\n\n"] if text else []
    for name, (number, characters, columns) in (OLD | formats).items():
        size = 3 + struct.calcsize(autopilot_logs._packed(characters))
        parts.append(message("FMT", (number, size, name, characters, columns)))
    parts.append(message("PARM", ("COMPASS_MOT_X", float("nan"))))
    for i, t in enumerate(np.arange(0.0, run.seconds - 0.05, 0.02)):
        ms = BOOT + round(t * 1e3)
        command = run.command_at(np.array([t]))[0]
        yaw, rate = run.at(np.array([t]))[0][[2, 5]]
        pulses = [round(1500 + 400 * c) for c in command]
        if not formats:
            parts.append(message("IMU", (ms, 0.0, 0.0, rate, 0.0, 0.0, -9.8)))
        if i % 5 == 0:
            angles = (0.0, 0.1, 0.0, 0.2, 0.0, np.degrees(yaw) % 360)
            parts.append(message("ATT", (*angles, 0.0) if formats else (ms, *angles)))
            if not formats:
                parts.append(message("RCOU", (ms, pulses[0], 1500, pulses[1], 1500, 0, 0, 0, 0)))
        if i % 10 == 0:
            north, east = run.at(np.array([t + 0.04]))[0][:2]
            lat, lon = (float(v) for v in geodetic(np.array(north), np.array(east)))
            week = 308_900_000 + 200 * (i // 10)
            fix = (10, 1.49, lat, lon, 0.1, 9.4, 0.5, 347.0)
            row = (3, week, 1777, *fix, -1.2, ms + 40) if not formats else (3, week, *fix)
            parts.append(message("GPS", row))
    path.write_bytes(b"".join(parts))
    return path, run


@pytest.mark.parametrize("text", [True, False])
def test_positions_have_the_time_of_the_autopilot_not_of_the_week(tmp_path, monkeypatch, text):
    """TimeMS of a GPS message is that of the week, and not its first column; T is as TimeMS of the others."""
    from pymavlink import mavutil

    path, run = drive(tmp_path / ("run.log" if text else "run.BIN"), monkeypatch, {}, text=text)
    gps, att = open_log(path).read([Wanted("GPS", ("Lat", "Lng")), Wanted("ATT", ("Yaw",))])
    times = gps.stamps * 1e-9 - BOOT * 1e-3
    np.testing.assert_allclose(times, 0.04 + 0.2 * np.arange(len(times)), atol=0.0011)
    expected = np.column_stack(geodetic(*run.at(times)[:, :2].T))
    np.testing.assert_allclose(gps.values, expected, atol=1.2e-7)
    other = mavutil.mavlink_connection(str(path))
    rows = {"GPS": [], "ATT": []}
    while (m := other.recv_match(type=[*rows])) is not None:
        rows[m.get_type()].append(m._timestamp)
    other.close()
    apart = rows["GPS"][5] - rows["ATT"][5]
    assert (gps.stamps[5] - att.stamps[5]) * 1e-9 == pytest.approx(apart, abs=1e-3)


def test_the_boat_of_such_a_log_is_found(tmp_path, monkeypatch):
    path, run = drive(tmp_path / "run.log", monkeypatch, {}, text=True)
    _, vehicle = proposed(path)
    assert [c.field for c in vehicle.file.commands.inputs.values()] == ["Chan1", "Chan3"]
    assert vehicle.file.pose.yaw_rate is not None
    recording = seatrial.read(path, vehicle)
    true = run.at(recording.t + 0.04 - recording.t[0])
    apart = recording.eta[:, :2] - true[:, 1::-1]
    assert np.abs(apart - apart.mean(axis=0)).max() < 0.02  # whole 1e-7 deg


def test_messages_without_any_time_are_said_to_have_none(tmp_path, monkeypatch):
    """ArduCopter 3.0: only GPS has a time, that of the week."""
    path, _ = drive(tmp_path / "run.log", monkeypatch, OLDER | {"IMU": OLD["IMU"]}, text=True)
    with pytest.raises(
        RecordingError, match="one from before 2014, whose messages have no time: it"
    ):
        open_log(path)
