# SPDX-License-Identifier: MIT
"""Bags whose position, heading and yaw rate come from topics of their own."""

import numpy as np
import pytest
from autopilot_logs import TWIN, sensed, trial
from bag_tools import START, Sent, header, quaternion, ros2
from init_tools import proposed

import seatrial
from seatrial.inspection.proposal.propose import init
from seatrial.io.look import look

LENGTH = 200.0  # [s]


@pytest.fixture(scope="module")
def run():
    return trial(TWIN, LENGTH)


def at(t: float) -> int:
    return START + round(1e9 * t)


def bag(folder, run, *, compass: bool):
    """NavSatFix at 5 Hz, an Imu (ENU) or a compass and an Imu without orientation, thrusters."""
    s = sensed(run)
    sent = [
        Sent("/gps/fix", "sensor_msgs/msg/NavSatFix", at(t) + 2_000_000,
             {"header": header(at(t), "gps"), "latitude": lat, "longitude": lon})
        for t, lat, lon in s.gps.tolist()
    ]  # fmt: skip
    for t, psi, rate in s.yaw.tolist():
        if compass:
            sent.append(Sent("/compass_hdg", "std_msgs/msg/Float64", at(t), {"data": np.degrees(psi)}))  # fmt: skip
            continue
        content = {
            "header": header(at(t), "imu"), "orientation": quaternion(np.pi / 2 - psi),
            "angular_velocity": {"x": 0.0, "y": 0.0, "z": -rate},
        }  # fmt: skip
        sent.append(Sent("/imu/data", "sensor_msgs/msg/Imu", at(t) + 1_000_000, content))
    for name, column in (("left", 1), ("right", 2)):
        sent += [
            Sent(f"/thruster/{name}", "std_msgs/msg/Float32", at(t), {"data": value})
            for t, value in s.motors[:, [0, column]].tolist()
        ]
    return ros2(folder, sent)


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
@pytest.mark.parametrize("compass", [False, True])
def test_init_finds_position_heading_and_yaw_rate(tmp_path, run, axes, compass):
    path = bag(tmp_path / "run", run, compass=compass)
    proposal, vehicle = proposed(path, name="twin", axes=axes)
    signals = {r.signal: r.column for r in proposal.sources.recognised}
    assert signals["position"] == "/gps/fix"
    assert signals["heading"] == ("/compass_hdg" if compass else "/imu/data")
    assert ("yaw rate" in signals) is not compass
    recording = seatrial.read(path, vehicle)
    # forward-left-up, whatever the file's axes are: both tracks turn by a quarter, not the boat
    true = run.at(recording.t + 1e-9 * (recording.origin - START))
    turned = np.unwrap(recording.eta[:, 2]) + np.unwrap(true[:, 2])
    assert np.nanstd(turned) < 0.01
    forward = np.diff(recording.eta[:, :2], axis=0)
    expected = np.diff(true[:, :2], axis=0)  # north, east
    got = forward[:, ::-1] if axes == "forward-left-up" else forward * [1, -1]
    assert np.nanstd(got - expected) < 0.04
    assert (recording.asynchronous.parts == 4).any() is np.bool_(not compass)


def test_the_topics_are_listed_with_what_they_could_be(tmp_path, run):
    text, _ = look(bag(tmp_path / "run", run, compass=True))
    rows = {line.split()[0]: line.split()[-1] for line in text.splitlines() if "/" in line}
    assert rows["/gps/fix"] == "positions" and rows["/compass_hdg"] == "headings"
    assert rows["/thruster/left"] == "commands"
    assert "no topic looks like" not in text


def test_positions_without_a_heading_are_refused_with_what_to_record(tmp_path, run):
    s = sensed(run)
    sent = [
        Sent("/gps/fix", "sensor_msgs/msg/NavSatFix", at(t), {"latitude": lat, "longitude": lon})
        for t, lat, lon in s.gps.tolist()
    ] + [Sent("/cmd_vel", "geometry_msgs/msg/Twist", at(t), {}) for t in s.motors[:, 0].tolist()]
    with pytest.raises(seatrial.util.errors.RecordingError, match="no topic has a heading"):
        init(ros2(tmp_path / "run", sent))
