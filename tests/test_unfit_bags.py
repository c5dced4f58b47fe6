# SPDX-License-Identifier: MIT
"""Bags without what the vehicle file asks for, or with two of it, are refused in a line that says what to do."""

import itertools

import numpy as np
import pytest
from bad_bag_tools import LENGTH, both, made, refused
from bag_tools import START, Sent, joy_sent, old_db3, pose, poses_sent, raw, ros1, store, vehicle
from rosbags.rosbag2 import StoragePlugin, Writer

import seatrial
from seatrial.boat.vehicle import vehicle_from

# What was asked for is not there #


@both
def test_a_topic_that_is_not_there_lists_those_that_are(tmp_path, sent, kind):
    path = made(tmp_path, kind, sent)
    line = refused(path, "no topic /slam/pos", vehicle(pose={"topic": "/slam/pos"}))
    assert "(pose: topic); did you mean /slam/pose?" in line
    for topic in (
        "/joy (sensor_msgs/Joy, 300)", "/rosout (std_msgs/String, 42)",
        "/slam/pose (geometry_msgs/PoseStamped, 45)",
    ):  # fmt: skip
        assert topic in line
    line = refused(path, "no topic /cmd_vel", vehicle(commands={"topic": "/cmd_vel"}))
    assert "(commands: inputs: F_u)" in line
    inputs = {"F_u": "axes[0]", "F_v": "axes[1]", "F_r": {"topic": "/wheel", "field": "data"}}
    line = refused(path, "no topic /wheel", vehicle(commands={"topic": "/joy", "inputs": inputs}))
    assert "(commands: inputs: F_r)" in line


@both
def test_a_field_or_an_element_that_is_not_there_says_what_is(tmp_path, sent, kind):
    path = made(tmp_path, kind, sent)

    def asked(field, **more):
        inputs = {n: {"field": field, **more} for n in ("F_u", "F_v", "F_r")}
        return vehicle(commands={"topic": "/joy", "inputs": inputs})

    refused(
        path, r"topic /joy: sensor_msgs/Joy has no 'axis'; did you mean 'axes'", asked("axis[0]")
    )
    refused(path, r"'axes' is not a number; numbers there: axes\[\]", asked("axes"))
    refused(
        path, r"'axes\[4\]' is not in every message: axes has 4 values in 300 messages; count from 0",
        asked("axes", index=4),
    )  # fmt: skip
    boat = vehicle(pose={"topic": "/rosout"})
    refused(path, "/rosout is std_msgs/String, which has no position and orientation", boat)


def test_a_vehicle_file_for_tables_only_says_what_to_do(tmp_path, sent):
    path = made(tmp_path, "bag", sent)
    content = vehicle().to_mapping()
    del content["pose"]["topic"]
    boat = vehicle_from(content, "v.yaml")
    refused(path, "v.yaml: pose: no topic; name one for bags, or let 'seatrial init", boat)
    content = vehicle().to_mapping()
    del content["commands"]["topic"]
    boat = vehicle_from(content, "v.yaml")
    refused(path, "v.yaml: commands: inputs: F_u has no topic; name one for bags", boat)


def test_a_topic_without_messages_and_one_with_two_types_are_named(tmp_path, sent):
    with Writer(tmp_path / "run", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        known = {
            name: writer.add_connection(name, kind, typestore=store(ros1=False))
            for name, kind in {s.topic: s.type for s in sent}.items()
        }
        other = writer.add_connection("/joy", "std_msgs/msg/String", typestore=store(ros1=False))
        for s in sent:
            if s.topic == "/joy":
                writer.write(known[s.topic], s.time, raw(s, ros1=False))
        writer.write(
            other, START, raw(Sent("/joy", "std_msgs/msg/String", 0, {"data": "x"}), ros1=False)
        )
    refused(tmp_path / "run", "topic /joy carries sensor_msgs/Joy and std_msgs/String")
    line = refused(
        tmp_path / "run", "topic /slam/pose has no messages",
        vehicle(commands={"topic": "/slam/pose"}),
    )  # fmt: skip
    assert "was its publisher running?" in line


def test_a_type_that_nobody_knows_says_how_to_record_it(tmp_path, sent):
    odd = [
        s._replace(type="boat_msgs/msg/Motors", fields={}) if s.topic == "/joy" else s for s in sent
    ]
    path = old_db3(tmp_path, odd, qos=True)
    inputs = {"F_u": "id", "F_v": "id", "F_r": "id"}
    refused(
        path, "has no definition of boat_msgs/Motors, and it is not a common type; record it as",
        vehicle(commands={"inputs": inputs}),
    )  # fmt: skip


# Two robots #


@both
def test_two_robots_on_one_topic_are_refused_until_one_is_named(tmp_path, kind):
    ours, theirs = poses_sent(LENGTH), poses_sent(LENGTH, frame="robot2/map")
    for s in theirs:
        s.fields["pose"]["position"]["x"] += 5.0
    theirs = [s._replace(time=s.time + 7) for s in theirs]
    path = made(tmp_path, kind, ours + theirs + joy_sent(LENGTH))
    line = refused(path, "mixes poses of several frames, header.frame_id 'map' ")
    assert (
        "'map' (45), 'robot2/map' (45): two robots, or two sources; select one with pose: parent"
        in line
    )
    one = seatrial.read(path, vehicle(pose={"parent": "map"}))
    two = seatrial.read(path, vehicle(pose={"parent": "robot2/map"}))
    np.testing.assert_allclose(two.eta - one.eta, np.tile([5.0, 0, 0], (45, 1)), atol=1e-12)
    refused(
        path, r"no pose on /slam/pose has header.frame_id 'moon' \(pose: parent\); there are 'map'",
        vehicle(pose={"parent": "moon"}),
    )  # fmt: skip


def test_two_odometries_on_one_topic_are_told_apart_by_their_child(tmp_path):
    sent = joy_sent(LENGTH)
    for k, s in itertools.product((1, 2), poses_sent(LENGTH)):
        x = s.fields["pose"]["position"]["x"] + 5 * k
        sent.append(
            Sent("/odom", "nav_msgs/msg/Odometry", s.time + k,
                 {"header": s.fields["header"], "child_frame_id": f"boat{k}",
                  "pose": {"pose": pose(x, 0, 0)}})
        )  # fmt: skip
    path = ros1(tmp_path / "run.bag", sent)
    refused(
        path, r"child_frame_id 'boat\d' \(45\), .*pose: child", vehicle(pose={"topic": "/odom"})
    )
    for k in (1, 2):
        boat = vehicle(pose={"topic": "/odom", "child": f"boat{k}"})
        assert seatrial.read(path, boat).eta[0, 0] == pytest.approx(5 * k)
