# SPDX-License-Identifier: MIT
"""Fields of a bag's topics that the user chooses."""

import numpy as np
import pytest
import yaml
from bag_tools import START, Sent, header, quaternion, ros2
from conftest import at_length
from init_tools import refused
from logs import AXES_OF_JOY, JOY, POSE, drive, half
from test_init_choices import tf_log

import seatrial

FIELDS = "x={0}/pose.position.x,y={0}/pose.position.y,heading={0}/pose.orientation.z"


@pytest.mark.parametrize("topic", [at_length(POSE), POSE.lstrip("/")])
def test_chosen_fields_of_a_bag_read_as_those_that_are_recognised(tmp_path, propose, topic):
    """With the topic's slash and without, all fields or some; of a quaternion one component names all."""
    log = drive(joypad=20.0, sticks=half)
    path = half_bag(tmp_path / "pool", log)
    usual = seatrial.read(path, propose(path)[0])
    commands = [f"{JOY}/axes[{i}]" for i in AXES_OF_JOY]
    for options in (
        ("--pose", FIELDS.format(topic)),
        ("--pose", FIELDS.format(topic).rpartition(",")[0]),
        ("--pose", FIELDS.format(topic).rpartition(",")[2]),
        ("--commands", ",".join(commands)),
        ("--commands", ",".join(f"c{i}={text}" for i, text in enumerate(commands))),
    ):
        vehicle, _ = propose(path, *options, "--force")
        found = seatrial.read(path, vehicle)
        np.testing.assert_allclose(found.eta, usual.eta, atol=1e-12)
        np.testing.assert_array_equal(found.stamps, usual.stamps)
        np.testing.assert_array_equal(found.commands.values, usual.commands.values)


def half_bag(path, log):
    """Poses and sticks with headers."""
    return ros2(path, half_sent(log))


def half_sent(log):
    """Messages of it."""
    sent = [
        Sent(POSE, "geometry_msgs/msg/PoseStamped", START + t + 2_000_000,
             {"header": header(START + t), "pose": {"position": {"x": x, "y": y, "z": 0.0}, "orientation": quaternion(psi)}})
        for t, (x, y, psi) in zip((log.pose_t * 1e9).astype(int).tolist(), log.pose.tolist(), strict=True)
    ]  # fmt: skip
    return [*sent, *(s for s in tf_log(log) if s.topic == JOY)]


def test_a_topic_for_each_thruster_whatever_its_type(tmp_path, propose):
    """Of simulators and of drivers: one number, and a header."""
    log = drive(joypad=20.0, sticks=half)
    sent = [s for s in half_sent(log) if s.topic == POSE]
    times = (log.command_t * 1e9).astype(int).tolist()
    sent += [
        Sent(
            f"/otter/thrusters/{i}/input", "uuv_gazebo_ros_plugins_msgs/msg/FloatStamped",
            START + t + 1_000_000, {"header": header(START + t), "data": value},
        )
        for t, row in zip(times, log.command.tolist(), strict=True)
        for i, value in enumerate(row)
    ]  # fmt: skip
    path = ros2(tmp_path / "thrusters", sent)
    vehicle, _ = propose(path)
    topics = [column.topic for column in vehicle.file.commands.inputs.values()]
    assert topics == [f"/otter/thrusters/{i}/input" for i in range(3)]
    found = seatrial.read(path, vehicle)
    np.testing.assert_array_equal(found.commands.values, log.command[: len(found.commands.values)])


def test_a_compass_of_its_own_topic_is_chosen_with_its_zero_and_sense(tmp_path, propose):
    """A number in degrees from north, clockwise, that no name shows."""
    log = drive(joypad=20.0, sticks=half)
    path = half_bag(tmp_path / "pool", log)
    usual = seatrial.read(path, propose(path)[0])
    sent = [s for s in tf_log(log) if s.topic == JOY]
    for t, (x, y, psi) in zip(
        (log.pose_t * 1e9).astype(int).tolist(), log.pose.tolist(), strict=True
    ):
        when = START + t
        point = {"header": header(when), "point": {"x": x, "y": y, "z": 0.0}}
        sent += [
            Sent("/fix", "geometry_msgs/msg/PointStamped", when, point),
            Sent("/angle", "std_msgs/msg/Float64", when, {"data": float(np.degrees(np.pi / 2 - psi) % 360)}),
        ]  # fmt: skip
    path = ros2(tmp_path / "compass", sent)
    pose = "east=/fix/point.x,north=/fix/point.y,heading=/angle/data"
    vehicle, text = propose(path, "--pose", pose, "--commands", JOY)
    assert yaml.safe_load(text)["pose"] == {
        "topic": "/fix", "x": {"field": "point.x"}, "y": {"field": "point.y"},
        "psi": {"topic": "/angle", "field": "data", "unit": "deg", "sign": -1, "offset": 90},
    }  # fmt: skip
    found = seatrial.read(path, vehicle)
    np.testing.assert_allclose(found.eta, usual.eta[: len(found.eta)], atol=1e-6)


@pytest.mark.parametrize(
    ("option", "text", "line"),
    [
        ("--pose", "heading=/slam/pose/pose.orientation.q", "numbers there: pose.orientation.x, "),
        ("--pose", "heading=/nowhere/data", "no topic /nowhere (--pose)"),
        ("--pose", "heading=data", "--pose data: expected TOPIC/FIELD; the topics are "),
        ("--commands", "left=/joy/axes", "'axes' is not a number"),
        ("--commands", "left=/joyy/axes[0]", "no topic /joyy (--commands); did you mean /joy?"),
    ],
)
def test_a_field_of_a_bag_that_is_not_there_is_refused(tmp_path, capsys, option, text, line):
    path = half_bag(tmp_path / "pool", drive(joypad=20.0, sticks=half))
    assert line in refused(capsys, path, "-o", tmp_path / "v.yaml", option, text)
