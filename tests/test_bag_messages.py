# SPDX-License-Identifier: MIT
"""Poses and commands come from every usual message."""

import numpy as np
import pytest
from bag_tools import (
    SECOND,
    START,
    Sent,
    drive,
    header,
    joy_sent,
    pose,
    poses_sent,
    quaternion,
    ros1,
    turn,
    vehicle,
)
from bags_same import LENGTH, through
from mcap_writer import mcap

import seatrial
from seatrial.recording.timing import Clock
from seatrial.util.frames import Axes

# Poses #


def test_poses_come_from_every_usual_message(tmp_path):
    def each(t, at, x, y, psi):
        del t
        body = pose(x, y, psi)
        return {
            "geometry_msgs/msg/PoseStamped": {"header": header(at, "map"), "pose": body},
            "geometry_msgs/msg/PoseWithCovarianceStamped": {
                "header": header(at, "map"), "pose": {"pose": body},
            },
            "nav_msgs/msg/Odometry": {
                "header": header(at, "odom"), "child_frame_id": "base_link", "pose": {"pose": body},
                "twist": {"twist": {"linear": {"x": 99.0}}},
            },
            "geometry_msgs/msg/TransformStamped": {
                "header": header(at, "map"), "child_frame_id": "boat",
                "transform": {"translation": {"x": x, "y": y}, "rotation": quaternion(psi)},
            },
            "geometry_msgs/msg/Pose": body,
            "geometry_msgs/msg/Pose2D": {"x": x, "y": y, "theta": psi},
        }  # fmt: skip

    t, eta = turn(LENGTH)
    for kind in each(0, 0, 0, 0, 0):
        poses = [
            Sent("/where", kind, START + i, each(None, START + i, *row)[kind])
            for i, row in zip(t.tolist(), eta.tolist(), strict=True)
        ]
        folder = tmp_path / kind.replace("/", "-")
        folder.mkdir()
        for path in (
            ros1(folder / "run.bag", poses + joy_sent(LENGTH)),
            mcap(folder / "run.mcap", poses + joy_sent(LENGTH)),
        ):
            record = seatrial.read(path, vehicle(pose={"topic": "/where"}))
            np.testing.assert_array_equal(record.stamps, START + t, err_msg=kind)
            np.testing.assert_allclose(record.eta, eta, atol=1e-14, err_msg=kind)
            clock = Clock.HEADER if "header" in str(each(0, 0, 0, 0, 0)[kind]) else Clock.ARRIVAL
            assert record.streams[0].clock is clock, kind


@pytest.mark.parametrize("unit", ["rad", "deg"])
def test_a_quaternion_has_no_unit_whatever_a_tables_heading_is_in(tmp_path, unit):
    boat = vehicle(pose={"psi": {"column": "psi", "unit": unit}})
    record = seatrial.read(mcap(tmp_path / "run.mcap", drive(LENGTH)), boat)
    np.testing.assert_allclose(record.eta, turn(LENGTH)[1], atol=1e-14)


def test_pose_fields_may_be_named_with_units_signs_and_axes(tmp_path):
    t, eta = turn(LENGTH)
    poses = [  # a rover's: millimetres, degrees clockwise from above
        Sent("/xy", "geometry_msgs/msg/Vector3", START + i,
             {"x": 1000 * x, "y": -1000 * y + 5, "z": -np.rad2deg(psi)})
        for i, (x, y, psi) in zip(t.tolist(), eta.tolist(), strict=True)
    ]  # fmt: skip
    fields = {
        "topic": "/xy", "x": {"field": "x", "unit": "mm"},
        "y": {"field": "y", "unit": "mm", "sign": -1, "offset": 5.0},
        "psi": {"field": "z", "unit": "deg", "sign": -1},
    }  # fmt: skip
    path = ros1(tmp_path / "run.bag", poses + joy_sent(LENGTH))
    record = seatrial.read(path, vehicle(pose=fields))
    np.testing.assert_allclose(record.eta, eta, atol=1e-12)
    boat = vehicle(pose=fields, axes="forward-right-down")
    flipped = seatrial.read(path, boat)
    np.testing.assert_allclose(flipped.raw, eta * Axes.FRD.signs, atol=1e-12)
    np.testing.assert_array_equal(
        flipped.commands.values, record.commands.values * [1.0, -1.0, -1.0]
    )


# Commands #


def test_joypad_axes_by_path_and_by_index(tmp_path):
    t, record = through(
        lambda t, at: {"header": header(at), "axes": [t, 2 * t, 3 * t], "buttons": [1]},
        tmp_path,
        inputs={
            "F_u": "axes[2]", "F_v": {"field": "axes", "index": 0},
            "F_r": {"field": "axes[1]", "sign": -1, "scale": 4.0, "offset": 1.0},
        },
    )  # fmt: skip
    t = t.astype(np.float32).astype(float)
    np.testing.assert_allclose(record.commands.values[:, 0], 3 * t, rtol=1e-6)
    np.testing.assert_allclose(record.commands.values[:, 1], t, rtol=1e-6)
    np.testing.assert_allclose(record.commands.values[:, 2], -(2 * t - 1) / 4, rtol=1e-6)


WRENCH = {"force": {"x": 1.0, "y": 2.0}, "torque": {"z": 3.0}}


TWIST = {"linear": {"x": 1.0, "y": 2.0}, "angular": {"z": 3.0}}


THREE = {"F_u": "data[0]", "F_v": "data[1]", "F_r": "data[2]"}


PWM = {"offset": 1500, "scale": 400}


def wrench(prefix=""):
    return dict(
        zip(("F_u", "F_v", "F_r"), (f"{prefix}force.x", f"{prefix}force.y", f"{prefix}torque.z"), strict=True)
    )  # fmt: skip


def twist(prefix=""):
    return dict(
        zip(
            ("F_u", "F_v", "F_r"),
            (f"{prefix}linear.x", f"{prefix}linear.y", f"{prefix}angular.z"),
            strict=True,
        )
    )


@pytest.mark.parametrize(
    ("kind", "fields", "named", "wanted"),
    [
        ("geometry_msgs/msg/Wrench", WRENCH, wrench(), (1, 2, 3)),
        ("geometry_msgs/msg/WrenchStamped", {"header": {}, "wrench": WRENCH}, wrench("wrench."), (1, 2, 3)),
        ("geometry_msgs/msg/Twist", TWIST, twist(), (1, 2, 3)),
        ("geometry_msgs/msg/TwistStamped", {"header": {}, "twist": TWIST}, twist("twist."), (1, 2, 3)),
        ("std_msgs/msg/Float32MultiArray", {"data": [0.25, -1.5, 4.0]}, THREE, (0.25, -1.5, 4.0)),
        (
            "std_msgs/msg/Float64MultiArray",
            {"layout": {"dim": [{"label": "a b", "size": 3}]}, "data": [0.1, -1 / 3, 1e-9]},
            THREE, (0.1, -1 / 3, 1e-9),
        ),
        (
            "mavros_msgs/msg/RCOut", {"header": {}, "channels": [1500, 1900, 1100, 1700]},
            {"F_u": {"field": "channels[1]", **PWM}, "F_v": {"field": "channels[2]", **PWM},
             "F_r": {"field": "channels", "index": 3, "sign": -1, **PWM}}, (1, -1, -0.5),
        ),
        (
            "mavros_msgs/msg/RCIn", {"header": {}, "rssi": 77, "channels": [1300, 1500]},
            {"F_u": {"field": "channels[0]", **PWM}, "F_v": {"field": "channels[1]", **PWM},
             "F_r": {"field": "rssi", "scale": 100}}, (-0.5, 0, 0.77),
        ),
        (
            "mavros_msgs/msg/ManualControl", {"header": {}, "x": 500.0, "y": -250.0, "r": 1000.0},
            {"F_u": {"field": "x", "scale": 1000}, "F_v": {"field": "y", "scale": 1000},
             "F_r": {"field": "r", "scale": 1000}}, (0.5, -0.25, 1),
        ),
        (
            "boat_msgs/msg/Motors",
            {"id": 3, "motors": [{"name": "port", "duty": -100, "raw": [1.5, 2.5]},
                                 {"name": "starboard", "duty": 50}], "spare": [None, {"duty": 7}]},
            {"F_u": {"field": "motors[0].duty", "scale": 100}, "F_v": "motors[0].raw[1]",
             "F_r": "spare[1].duty"}, (-1, 2.5, 7),
        ),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)  # fmt: skip
def test_commands_come_from_every_usual_message_by_field_path(
    tmp_path, kind, fields, named, wanted
):
    def made(_, at):
        stamped = {"header": header(at)} if "header" in fields else {}
        return {**fields, **stamped}

    times, record = through(made, tmp_path, kind=kind, inputs=named)
    np.testing.assert_allclose(record.commands.values, np.tile(wanted, (len(times), 1)), rtol=1e-15)
    assert record.streams[1].clock is (Clock.HEADER if "header" in fields else Clock.ARRIVAL)
    assert record.streams[1].kind == kind.replace("/msg", "")


def test_names_of_changing_length_move_the_fields_and_they_are_found(tmp_path):
    """Every message has a shape of its own; all are read at the right place."""
    times, record = through(
        lambda t, _: {
            "motors": [
                {"name": "p" * int(40 * t), "duty": int(1000 * t)},
                *[{"name": "x", "duty": 1}] * int(3 * t),
                {"name": "q", "duty": 2},
            ]
        },
        tmp_path, kind="boat_msgs/msg/Motors",
        inputs={"F_u": "motors[0].duty", "F_v": "motors[1].duty", "F_r": "spare[0].duty"},
    )  # fmt: skip
    np.testing.assert_array_equal(record.commands.values[:, 0], (1000 * times).astype(int))
    np.testing.assert_array_equal(record.commands.values[:, 1], np.where(3 * times < 1, 2, 1))


def test_one_topic_for_each_thruster_and_a_scale_of_its_own(tmp_path):
    """Values hold until their topic's next; nothing is known before all have spoken."""
    sent = poses_sent(LENGTH)
    begin = {"port": 0.2, "starboard": 0.3}
    for name, first in begin.items():
        sent += [
            Sent(f"/thrust/{name}", "std_msgs/msg/Float64", START + round(t * 1e9), {"data": t})
            for t in np.arange(first, LENGTH, 0.1)
        ]
    sent += [
        Sent("/rpm", "std_msgs/msg/Float32", START + round(t * 1e9), {"data": 100 * t})
        for t in np.arange(0, LENGTH, 0.5)
    ]
    boat = vehicle(
        commands={
            "inputs": {n: {"topic": f"/thrust/{n}", "field": "data"} for n in begin},
        },
        thrusters={}, allocation={"scheme": "direct"},
        forces={"F_u": {"axis": "surge", "of": {"port": 0.5, "starboard": 0.5}},
                "F_r": {"axis": "yaw", "of": {"port": -0.5, "starboard": 0.5}}},
        structure={"surge": ["v * r", "X_u * u", "X_F * F_u"], "sway": ["Y_v * v"],
                   "yaw": ["N_r * r", "N_F * F_r"]},
        scales={"rpm": {"column": {"topic": "/rpm", "field": "data", "scale": 10}, "reference": 20.0}},
        chain=[{"scale": {"signal": "rpm"}}],
    )  # fmt: skip
    for path in (ros1(tmp_path / "run.bag", sent), mcap(tmp_path / "run.mcap", sent)):
        record = seatrial.read(path, boat)
        at = record.seconds(record.commands.stamps)
        np.testing.assert_allclose(at, np.arange(0.3, LENGTH - 0.01, 0.1), atol=1e-9)
        np.testing.assert_allclose(record.commands.values, np.column_stack([at, at]), atol=1e-9)
        assert record.scales.names == ("rpm",)
        np.testing.assert_allclose(
            record.scales.values[:, 0], 10 * record.seconds(record.scales.stamps), atol=1e-5
        )
        assert [s.role for s in record.streams] == ["poses", "commands", "commands", "scales"]


def test_the_order_of_the_inputs_is_the_vehicle_files_whatever_the_topics(tmp_path):
    sent = poses_sent(LENGTH)
    for k, name in enumerate("abc"):
        sent += [
            Sent(
                f"/{name}", "std_msgs/msg/Int16", START + i * SECOND // 10, {"data": 10 * k + i % 3}
            )
            for i in range(30)
        ]
    named = {"F_v": "b", "F_r": "c", "F_u": "a"}
    boat = vehicle(
        commands={"inputs": {n: {"topic": f"/{t}", "field": "data"} for n, t in named.items()}}
    )
    record = seatrial.read(ros1(tmp_path / "run.bag", sent), boat)
    assert record.commands.names == ("F_v", "F_r", "F_u")
    assert record.commands.values[4].tolist() == [11.0, 21.0, 1.0]
