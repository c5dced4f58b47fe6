# SPDX-License-Identifier: MIT
"""Bags of boats whose poses and commands are in messages of other types: `init` and `read` give what was sent."""

import numpy as np
import pytest
from bag_tools import START, Sent, header, pose, quaternion, ros2
from init_tools import proposed
from logs import drive, half

import seatrial
from seatrial.util.errors import RecordingError

LOG = drive(joypad=20.0, sticks=half)
NONE = float("nan")


def ahead(t, seed=0):
    """Sticks of a boat that mostly goes ahead, so that its motion shows the sense of its heading."""
    return np.abs(half(t, seed)) * [2, 0, 0] + half(t, seed) * [0, 0, 0.3]


TYPES = {  # of a pose: topic, type, fields by t [ns], x, y, psi
    "names": ("/stateHat", "auv_msgs/msg/NavSts", lambda t, x, y, psi: {
        "header": header(t), "position": {"north": x, "east": y}, "orientation": {"yaw": psi}}),
    "numbers in arrays": ("/fmu/out/vehicle_odometry", "px4_msgs/msg/VehicleOdometry", lambda t, x, y, psi: {
        "timestamp": t // 1000, "position": [x, y, 0.0], "q": [quaternion(psi)[k] for k in "wxyz"]}),
    "an array of one pose": ("/wamv/pose", "geometry_msgs/msg/PoseArray", lambda t, x, y, psi: {
        "header": header(t), "poses": [pose(x, y, psi)]}),
    "a robot's frame": ("/tf", "tf2_msgs/msg/TFMessage", lambda t, x, y, psi: {"transforms": [
        {"header": header(t, "world"), "child_frame_id": "wamv/base_link",
         "transform": {"translation": {"x": x, "y": y, "z": 0.0}, "rotation": quaternion(psi)}}]}),
}  # fmt: skip


def sent(topic, kind, fields, t, rows):
    """Messages of these rows at t [s]."""
    times = START + np.rint(t * 1e9).astype(np.int64)
    return [
        Sent(topic, kind, stamp, fields(stamp, *row))
        for stamp, row in zip(times.tolist(), rows.tolist(), strict=True)
    ]


def sticks():
    """The three commands on a topic of twelve places, with a time of its own."""
    fields = lambda t, *c: {"timestamp": t // 1000, "control": [*c, *([NONE] * 9)]}  # noqa: E731
    kind = "px4_msgs/msg/ActuatorMotors"
    return sent("/fmu/in/actuator_motors", kind, fields, LOG.command_t, LOG.command)


@pytest.mark.parametrize("case", TYPES)
def test_poses_of_other_types(tmp_path, case):
    """By the names of fields, in arrays, between frames; places that are never filled, and times, are no commands."""
    path = ros2(tmp_path / "run", [*sent(*TYPES[case], LOG.pose_t, LOG.pose), *sticks()])
    axes = "forward-right-down" if case == "names" else "forward-left-up"
    _, vehicle = proposed(path, axes=axes)
    found = seatrial.read(path, vehicle)
    mirror = [1.0, -1.0, -1.0] if case == "names" else 1.0
    np.testing.assert_allclose(found.raw, LOG.pose[: len(found.raw)] * mirror, atol=1e-6)
    assert vehicle.inputs == ("F_u", "F_v", "F_r")
    fields = [column.field for column in vehicle.file.commands.inputs.values()]
    assert fields == ["control[0]", "control[1]", "control[2]"]


def test_a_position_beside_a_number_that_is_a_heading(tmp_path):
    """A point and a compass, which no type of a message calls poses."""
    point = lambda t, x, y, psi: {"header": header(t), "point": {"x": x, "y": y, "z": 0.0}}  # noqa: E731
    compass = lambda t, x, y, psi: {"data": np.degrees(np.pi / 2 - psi) % 360}  # noqa: E731
    log = drive(sticks=ahead)
    path = ros2(tmp_path / "run", [
        *sent("/utm", "geometry_msgs/msg/PointStamped", point, log.pose_t, log.pose),
        *sent("/compass", "std_msgs/msg/Float64", compass, log.pose_t, log.pose), *sticks(),
    ])  # fmt: skip
    _, vehicle = proposed(path, axes="forward-left-up")
    psi = vehicle.file.pose.psi
    assert (psi.topic, psi.field, psi.sign, psi.offset) == ("/compass", "data", -1, 90)
    assert vehicle.file.pose.x.field == "point.x"


def test_several_poses_in_an_array_are_a_question(tmp_path):
    """The options that choose the first one are those that read it, with its whole quaternion."""
    topic, kind, _ = TYPES["an array of one pose"]

    def both(t, *eta):
        return {"header": header(t), "poses": [pose(*eta), pose(1.0, 2.0, 0.0)]}

    path = ros2(tmp_path / "run", [*sent(topic, kind, both, LOG.pose_t, LOG.pose), *sticks()])
    with pytest.raises(
        RecordingError, match="several poses in arrays; choose the boat's: --pose "
    ) as error:
        proposed(path)
    _, vehicle = proposed(path, pose=str(error.value).partition("--pose ")[2])
    np.testing.assert_allclose(seatrial.read(path, vehicle).raw, LOG.pose, atol=1e-6)


def test_thrusters_of_two_numbers_each_beside_a_voltage(tmp_path):
    """A topic for each, a throttle and an angle; the angle is at rest, and the battery is no thruster."""
    messages = sent(*TYPES["an array of one pose"], LOG.pose_t, LOG.pose)
    for i in range(3):
        fields = lambda t, c: {"throttle": round(1000 * c), "angle": 0}  # noqa: E731
        rows = LOG.command[:, i : i + 1]
        messages += sent(f"/actuator_{i + 1}", "boat_msgs/msg/Azimuth", fields, LOG.command_t, rows)
    volts = np.linspace(12.6, 12.4, 20)[:, None]
    voltage = lambda t, v: {"data": v}  # noqa: E731
    messages += sent("/BatteryVoltage", "std_msgs/msg/Float32", voltage, np.arange(20.0), volts)
    _, vehicle = proposed(ros2(tmp_path / "run", messages))
    topics = [column.topic for column in vehicle.file.commands.inputs.values()]
    assert topics == ["/actuator_1", "/actuator_2", "/actuator_3"]
