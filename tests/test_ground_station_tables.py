# SPDX-License-Identifier: MIT
"""Tables that QGroundControl writes of its telemetry (CSV): `--.--` where there is no value, a clock of whole seconds."""

from datetime import datetime, timedelta

import numpy as np
import pytest
from autopilot_logs import TWIN, geodetic, trial
from init_tools import proposed

import seatrial
from seatrial.io.table import open_tables

START = datetime(2024, 5, 6, 7, 8, 9)
HEADER = (
    "Timestamp,roll,pitch,heading,yawRate,groundSpeed,airSpeed,distanceToHome,gps.lat,gps.lon,gps.hdop,"
    "servoRaw.servo1,servoRaw.servo3,clock.currentTime,wind.direction"
)
LOCKED = 20  # row of the first fix


def table(path, run):
    """At 4 Hz; without a fix in the first 5 s."""
    lines = [HEADER]
    for i, t in enumerate(np.arange(0.0, run.seconds - 0.1, 0.25)):
        (north, east, yaw, u, v, rate), command = (
            run.at(np.array([t]))[0],
            run.command_at(np.array([t]))[0],
        )
        lat, lon = geodetic(np.array(north), np.array(east))
        stamp = (START + timedelta(seconds=float(t))).strftime("%Y-%m-%d %H:%M:%S.%f")[:-3]
        at = f"{lat:.7f},{lon:.7f},0.70" if i >= LOCKED else "--.--,--.--,--.--"
        left, right = 1500 + 400 * command
        lines.append(
            f"{stamp},0.1,0.2,{np.degrees(yaw) % 360:.2f},{np.degrees(rate):.3f},{np.hypot(u, v):.2f},--.--,"
            f"--.--,{at},{left:.0f},{right:.0f},{stamp[11:19]},--.--"
        )
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_table_of_qgroundcontrol(tmp_path):
    run = trial(TWIN, 120.0, 0)
    path = table(tmp_path / "telemetry.csv", run)
    found, vehicle = proposed(path)
    assert [c.column for c in vehicle.file.commands.inputs.values()] == [
        "servoRaw.servo1",
        "servoRaw.servo3",
    ]
    assert vehicle.file.pose.stamp.column == "Timestamp"
    # clock.currentTime has whole seconds, and is not the stamp
    assert "whole steps" not in found.text
    recording = seatrial.read(path, vehicle)
    assert not any("whole steps" in remark for remark in recording.remarks)
    true = run.at(0.25 * np.arange(LOCKED, len(recording.eta)))
    known = np.isfinite(recording.eta).all(axis=1)
    np.testing.assert_array_equal(np.flatnonzero(known), np.arange(LOCKED, len(recording.eta)))
    apart = recording.eta[known, :2] - true[:, 1::-1]
    assert np.abs(apart - apart.mean(axis=0)).max() < 0.02  # [m] of 1e-7 deg
    np.testing.assert_allclose(np.diff(recording.t), 0.25, atol=1e-6)


@pytest.mark.parametrize("cell", ["-", "--", "--.--", "-.-", "---", "--:--:--", "n/a", ""])
def test_a_cell_without_a_digit_has_no_value(tmp_path, cell):
    path = tmp_path / "log.csv"
    path.write_text("t,x,y\n" + "".join(f"{i},{cell if i == 3 else i},{i}\n" for i in range(9)))
    (found,) = open_tables(path).values()
    x = found.columns(["x"])[:, 0]
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(x)), [3])
