# SPDX-License-Identifier: MIT
"""Bags of every kind that recorders leave: the same content is the same recording."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from bag_tools import (
    SECOND,
    START,
    WRITERS,
    Sent,
    drive,
    header,
    joy_sent,
    mcap,
    other_sent,
    pose,
    poses_sent,
    quaternion,
    ros1,
    ros2,
    stamp,
    sticks,
    store,
    turn,
    vehicle,
)
from rosbags.highlevel import AnyReader

import seatrial
from seatrial.errors import SeatrialError
from seatrial.faults import FaultKind
from seatrial.frames import POSE_SIGNS
from seatrial.io.bags import open_bag
from seatrial.io.write import EPOCH, write_trial
from seatrial.io.write_bag import BagTopic, write_bag
from seatrial.streams import Clock

LENGTH = 3.0  # [s]
JOY = "sensor_msgs/msg/Joy"


@pytest.fixture(scope="module")
def sent() -> list[Sent]:
    return drive(LENGTH)


def assert_same(found: seatrial.Recording, wanted: seatrial.Recording) -> None:
    """Everything that numbers are made of."""
    for name in ("stamps", "eta", "raw", "valid", "segment"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name), err_msg=name)
    np.testing.assert_array_equal(found.commands.stamps, wanted.commands.stamps)
    np.testing.assert_array_equal(found.commands.values, wanted.commands.values)
    assert found.commands.names == wanted.commands.names
    assert found.faults == wanted.faults


def through(fields, folder, *, topic="/cmd", kind=JOY, rate=20.0, **changes):
    """A recording with commands of a type, as a .bag and as an .mcap; both are the same."""
    times = np.arange(0, LENGTH, 1 / rate)
    commands = [
        Sent(topic, kind, START + round(t * 1e9), fields(t, START + round(t * 1e9))) for t in times
    ]
    boat = vehicle(commands={"topic": topic, "inputs": changes.pop("inputs")}, **changes)
    records = [
        seatrial.read(make(folder / name, poses_sent(LENGTH) + commands), boat)
        for make, name in ((ros1, "run.bag"), (mcap, "run.mcap"))
    ]
    assert_same(*records)
    return times, records[0]


# One content, every kind of bag #


@pytest.mark.parametrize("kind", WRITERS)
def test_the_same_content_is_the_same_recording(tmp_path, sent, kind):
    record = seatrial.read(WRITERS[kind](tmp_path, sent), vehicle())
    t, eta = turn(LENGTH)
    s, axes = sticks(LENGTH)
    np.testing.assert_array_equal(record.stamps, START + t)
    np.testing.assert_allclose(record.eta, eta, atol=1e-14)
    np.testing.assert_array_equal(record.commands.stamps, START + s)
    np.testing.assert_array_equal(record.commands.values, axes[:, [1, 0, 3]])  # to the last bit
    assert record.commands.names == ("F_u", "F_v", "F_r")
    assert record.valid.all()
    assert record.faults == record.remarks == ()
    assert [(x.role, x.source, x.count, x.clock) for x in record.streams] == [
        ("poses", "/slam/pose", len(t), Clock.HEADER),
        ("commands", "/joy", len(s), Clock.HEADER),
    ]
    assert [x.delay.median for x in record.streams] == pytest.approx([0.003, 0.001])
    assert record.name in ("run", "run-alone", "old_0")
    assert all(len(source.sha256) == 64 for source in record.sources)


@pytest.mark.parametrize(
    "kind", ["bag", "bag split", "db3 folder", "mcap split", "mcap, no chunks"]
)
def test_salvage_of_a_whole_bag_changes_nothing_and_remarks_nothing(tmp_path, sent, kind):
    path = WRITERS[kind](tmp_path, sent)
    record = seatrial.read(path, vehicle(), salvage=True)
    assert_same(record, seatrial.read(path, vehicle()))
    assert record.remarks == ()


@pytest.mark.parametrize("kind", ["bag", "bag bz2", "db3 folder", "mcap, lz4 and checksums"])
def test_every_message_is_the_one_that_rosbags_reads(tmp_path, sent, kind):
    path = WRITERS[kind](tmp_path, sent)
    with AnyReader([path]) as reader:
        wanted = [(c.topic, t, bytes(raw)) for c, t, raw in reader.messages()]
    with open_bag(path) as bag:
        found = list(bag.messages(bag.topics.keys()))
        assert {t.name: t.messages for t in bag.topics.values()} == {
            name: sum(topic == name for topic, _, _ in wanted) for name in bag.topics
        }
    assert sorted(found) == sorted(wanted)
    assert [m for m in found if m[0] == "/joy"] == [m for m in wanted if m[0] == "/joy"]


@pytest.mark.parametrize("suffix", ["bag", "mcap", "db3"])
def test_what_we_write_is_read_back_and_read_the_same_by_rosbags(tmp_path, suffix):
    t, eta = turn(LENGTH)
    s, axes = sticks(LENGTH)
    axes = axes.astype(float)
    path = write_bag(
        tmp_path / "deep" / f"run.{suffix}",
        [
            BagTopic(
                "/slam/pose", "geometry_msgs/msg/PoseStamped", START + t + 7, START + t,
                {"pose.position.x": eta[:, 0], "pose.position.y": eta[:, 1],
                 "pose.orientation.z": np.sin(eta[:, 2] / 2),
                 "pose.orientation.w": np.cos(eta[:, 2] / 2)},
                {"header.frame_id": "map"},
            ),
            BagTopic("/joy", JOY, START + s, START + s, {f"axes[{i}]": axes[:, i] for i in range(4)}),
        ],
    )  # fmt: skip
    assert [p.name for p in (tmp_path / "deep").iterdir()] == [f"run.{suffix}"]
    record = seatrial.read(path, vehicle())
    np.testing.assert_array_equal(record.stamps, START + t)
    np.testing.assert_allclose(record.eta, eta, atol=1e-14)
    np.testing.assert_array_equal(record.commands.stamps, START + s)
    np.testing.assert_array_equal(record.commands.values, axes[:, [1, 0, 3]])
    with AnyReader([path]) as reader:
        messages = [
            (c.topic, t, reader.deserialize(raw, c.msgtype)) for c, t, raw in reader.messages()
        ]
    poses = [(t, m) for topic, t, m in messages if topic == "/slam/pose"]
    joys = [m for topic, _, m in messages if topic == "/joy"]
    assert [t for t, _ in poses] == (START + t + 7).tolist()
    assert {m.header.frame_id for _, m in poses} == {"map"}
    assert [m.pose.position.x for _, m in poses] == eta[:, 0].tolist()
    np.testing.assert_array_equal([m.axes for m in joys], axes)
    assert [m.header.stamp.sec * SECOND + m.header.stamp.nanosec for m in joys] == (
        START + s
    ).tolist()


@pytest.mark.parametrize("suffix", ["bag", "mcap", "db3"])
def test_messages_with_texts_and_lists_are_written_as_rosbags_would(tmp_path, suffix):
    n = np.arange(5)
    path = write_bag(
        tmp_path / f"run.{suffix}",
        [
            BagTopic(
                "/rc", "mavros_msgs/msg/RCOut", n + START, n + START, {"channels[7]": 1500.0 + n}
            )
        ],
    )
    with AnyReader([path], default_typestore=store(ros1=False)) as reader:
        found = [reader.deserialize(raw, c.msgtype).channels for c, _, raw in reader.messages()]
    np.testing.assert_array_equal([c[7] for c in found], 1500 + n)
    assert all(c.dtype == np.uint16 and len(c) == 8 for c in found)


@pytest.mark.parametrize("suffix", ["bag", "mcap", "db3"])
@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
def test_a_simulated_trial_as_a_bag_is_the_trial(tmp_path, clean_mp, suffix, axes):
    """Through a servo's pulses, in the vehicle's own axes, units and signs."""
    pulses = {
        n: {"field": f"channels[{i}]", "scale": 400, "offset": 1500, "sign": s}
        for i, (n, s) in enumerate((("F_u", 1), ("F_v", -1), ("F_r", 1)))
    }
    boat = vehicle(
        axes=axes, commands={"topic": "/rc", "inputs": pulses},
        pose={"x": {"column": "x", "unit": "mm"},
              "psi": {"column": "psi", "unit": "deg", "sign": -1, "offset": 30}},
    )  # fmt: skip
    trial = replace(clean_mp["S1"], vehicle=boat)
    path = write_trial(trial, tmp_path, suffix)
    assert path == tmp_path / f"{trial.name}.{suffix}"
    record = seatrial.read(path, boat)
    wanted = trial.recording
    np.testing.assert_array_equal(np.diff(record.stamps), np.diff(wanted.stamps))
    turns = np.round((record.eta[0, 2] - wanted.eta[0, 2]) / (2 * np.pi))
    np.testing.assert_allclose(
        record.eta, wanted.eta + np.array([0, 0, 2 * np.pi * turns]), atol=1e-9
    )
    np.testing.assert_allclose(
        record.commands.values, wanted.commands.values, atol=0.5 / 400 + 1e-9
    )
    np.testing.assert_array_equal(record.commands.stamps, trial.command_stamps + EPOCH)


def test_what_can_not_be_written_is_refused_and_leaves_nothing(tmp_path):
    n = np.arange(3) + START

    def topic(kind, columns):
        return [BagTopic("/cmd", kind, n, n, {c: np.full(3, v) for c, v in columns.items()})]

    for name, topics, words in (
        ("run.txt", [], "expected a file name ending in .bag, .mcap or .db3"),
        ("run.bag", topic("mavros_msgs/msg/RCOut", {"channels[0]": -1.0}),
         r"topic /cmd: 'channels\[0\]' would hold -1 to -1; it can hold 0 to 65535"),
        ("run.mcap", topic("mavros_msgs/msg/RCOut", {"channels[0]": np.nan}), "would hold nan"),
        ("run.db3", topic(JOY, {"axis[0]": 1.0}), r"has no 'axis'; did you mean 'axes'"),
        ("run.bag", topic(JOY, {"axes[0]": 1.0, "channels[1]": 1.0}), "has no 'channels'"),
    ):  # fmt: skip
        with pytest.raises(SeatrialError, match=words):
            write_bag(tmp_path / "out" / name, topics)
        assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())
    with pytest.raises(SeatrialError, match="is a folder; give a file name"):
        (tmp_path / "run.bag").mkdir()
        write_bag(tmp_path / "run.bag", [])


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
    np.testing.assert_allclose(flipped.raw, eta * POSE_SIGNS, atol=1e-12)
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
        zip(
            ("F_u", "F_v", "F_r"),
            (f"{prefix}force.x", f"{prefix}force.y", f"{prefix}torque.z"),
            strict=True,
        )
    )


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


# Clocks #


def test_headers_without_a_time_are_arrivals_and_the_stream_says_so(tmp_path):
    t, _ = turn(LENGTH)
    s, _ = sticks(LENGTH)
    sent = [
        m._replace(fields={**m.fields, "header": header(0, "map")}) for m in drive(LENGTH)
        if "header" in m.fields
    ]  # fmt: skip
    for path in (ros1(tmp_path / "run.bag", sent), mcap(tmp_path / "run.mcap", sent)):
        record = seatrial.read(path, vehicle())
        assert [x.clock for x in record.streams] == [Clock.ZERO, Clock.ZERO]
        np.testing.assert_array_equal(record.stamps, START + t + 3_000_000)
        np.testing.assert_array_equal(record.commands.stamps, START + s + 1_000_000)
        assert record.streams[0].delay is None


def test_the_bags_time_can_be_asked_for(tmp_path, sent):
    record = seatrial.read(
        ros1(tmp_path / "run.bag", sent), vehicle(pose={"clock": "bag"}, commands={"clock": "bag"})
    )
    np.testing.assert_array_equal(record.stamps, START + turn(LENGTH)[0] + 3_000_000)
    np.testing.assert_array_equal(record.commands.stamps, START + sticks(LENGTH)[0] + 1_000_000)
    assert {x.clock for x in record.streams} == {Clock.ARRIVAL}


@pytest.mark.parametrize("make", [ros1, mcap])
def test_a_joypad_that_publishes_on_change_is_not_silent_unless_a_timeout_says_so(tmp_path, make):
    changes = [(0.0, 0.0), (0.5, 0.3), (0.52, 0.4), (2.5, -1.0), (7.0, 0.0)]
    sent = poses_sent(9.0) + [
        Sent("/joy", JOY, START + round(t * 1e9),
             {"header": header(START + round(t * 1e9)), "axes": [x] * 4})
        for t, x in changes
    ]  # fmt: skip
    path = make(tmp_path / f"run.{'bag' if make is ros1 else 'mcap'}", sent)
    record = seatrial.read(path, vehicle())
    assert record.faults == ()
    assert record.valid.all()
    assert record.streams[1].on_change
    limited = seatrial.read(path, vehicle(command_timeout=1.0))
    assert [f.kind for f in limited.faults] == [FaultKind.SILENT] * 3
    assert [(f.start, f.end) for f in limited.faults] == [
        pytest.approx(pair, abs=0.07) for pair in ((1.52, 2.5), (3.5, 7.0), (8.0, 9.0))
    ]
    hidden = ((limited.t >= 1.52) & (limited.t < 2.5)) | ((limited.t >= 3.5) & (limited.t < 7.0))
    np.testing.assert_array_equal(~limited.valid, hidden | (limited.t >= 8.0))


# Names and places #


def test_topics_without_their_slash_and_bags_beside_others_are_found(tmp_path, sent):
    folder = ros2(tmp_path / "run", sent)
    boat = vehicle(pose={"topic": "slam/pose"}, commands={"topic": "joy"})
    assert_same(seatrial.read(folder, boat), seatrial.read(folder, vehicle()))
    one, two = ros1(tmp_path / "one.bag", sent), ros1(tmp_path / "two.bag", sent)
    assert_same(seatrial.read(one, vehicle()), seatrial.read(two, vehicle()))
    with pytest.raises(SeatrialError, match=r"2 bags of different names; .*\(one\.bag, two\.bag"):
        shutil.rmtree(folder)
        seatrial.read(tmp_path, vehicle())


def test_definitions_in_idl_are_read(tmp_path):
    """ROS 2 records a type's IDL where that is what the package has."""
    idl = (
        "=" * 80 + "\nIDL: boat_msgs/msg/Motors\n"
        '#include "boat_msgs/msg/Motor.idl"\n'
        "module boat_msgs { module msg {\n"
        "  typedef boat_msgs::msg::Motor boat_msgs__msg__Motor__2[2];\n"
        "  struct Motors { uint8 id; sequence<boat_msgs::msg::Motor> motors;\n"
        "    boat_msgs__msg__Motor__2 spare; };\n"
        "}; };\n" + "=" * 80 + "\nIDL: boat_msgs/msg/Motor\n"
        "module boat_msgs { module msg {\n"
        "  typedef float float__2[2];\n"
        "  struct Motor { string name; float__2 raw; int16 duty; };\n"
        "}; };\n"
    )
    commands = [
        Sent("/cmd", "boat_msgs/msg/Motors", START + i * SECOND // 20,
             {"motors": [{"name": "port", "duty": i, "raw": [0.5, 1.5]}], "spare": [{"duty": -i}, {}]})
        for i in range(60)
    ]  # fmt: skip
    path = mcap(
        tmp_path / "run.mcap", poses_sent(LENGTH) + commands, idl={"boat_msgs/msg/Motors": idl}
    )
    named = {"F_u": "motors[0].duty", "F_v": "motors[0].raw[1]", "F_r": "spare[0].duty"}
    record = seatrial.read(path, vehicle(commands={"topic": "/cmd", "inputs": named}))
    wanted = [(i, 1.5, -i) for i in range(60)]
    np.testing.assert_array_equal(record.commands.values, wanted)


def test_big_endian_recordings_are_read(tmp_path, monkeypatch, sent):
    import bag_tools

    little = seatrial.read(mcap(tmp_path / "little.mcap", sent), vehicle())

    def big(message: Sent, *, ros1: bool) -> bytes:
        assert not ros1
        types = store(ros1=False)
        built = bag_tools.build(types, message.type, message.fields)
        return bytes(types.serialize_cdr(built, message.type, little_endian=False))

    monkeypatch.setattr(bag_tools, "raw", big)
    assert_same(seatrial.read(mcap(tmp_path / "big.mcap", sent), vehicle()), little)


def test_several_publishers_of_one_topic_are_one_stream(tmp_path):
    """Two connections of one topic in ROS 1, told apart by their callers."""
    from rosbags.rosbag1 import Writer

    types = store(ros1=True)
    with Writer(tmp_path / "run.bag") as writer:
        pair = [
            writer.add_connection("/joy", JOY, typestore=types, callerid=f"/joy_{i}")
            for i in range(2)
        ]
        where = writer.add_connection(
            "/slam/pose", "geometry_msgs/msg/PoseStamped", typestore=types
        )
        import bag_tools

        for i, message in enumerate(bag_tools.by_time(poses_sent(LENGTH) + joy_sent(LENGTH))):
            connection = where if message.topic == "/slam/pose" else pair[i % 2]
            writer.write(connection, message.time, bag_tools.raw(message, ros1=True))
    record = seatrial.read(tmp_path / "run.bag", vehicle())
    np.testing.assert_array_equal(record.commands.values, sticks(LENGTH)[1][:, [1, 0, 3]])
    with open_bag(tmp_path / "run.bag") as bag:
        assert bag.topics["/joy"].messages == 300
        assert bag.topics["/joy"].publishers == 2
        assert bag.topics["/slam/pose"].publishers == 1


def test_messages_that_arrive_late_are_put_aside_not_mixed_in(tmp_path):
    """Two stamps change places on their way; the later one counts."""
    sent = joy_sent(LENGTH)
    sent[10], sent[11] = (
        sent[11]._replace(time=sent[10].time), sent[10]._replace(time=sent[11].time),
    )  # fmt: skip
    record = seatrial.read(ros1(tmp_path / "run.bag", poses_sent(LENGTH) + sent), vehicle())
    assert len(record.commands.stamps) == 299
    assert record.streams[1].backward == 1


def test_topics_that_nobody_asks_for_are_not_decoded(tmp_path):
    """Even if they could not be: their types are never looked at."""
    sent = drive(LENGTH)
    path = mcap(tmp_path / "run.mcap", sent + other_sent(LENGTH), "")
    content = path.read_bytes()
    path.write_bytes(content.replace(b"string data", b"strung data"))
    with pytest.raises(SeatrialError, match="checksum"):
        seatrial.read(path, vehicle())
    path = mcap(tmp_path / "run.mcap", sent, "", crc=False)
    path.write_bytes(path.read_bytes().replace(b"string data", b"strung data"))
    assert len(seatrial.read(path, vehicle()).stamps) == 45


def test_a_stamp_of_a_header_is_exact_to_the_nanosecond(tmp_path):
    odd = [START + i * SECOND // 15 + i % 7 for i in range(45)]
    t, eta = turn(LENGTH)
    sent = [
        Sent("/slam/pose", "geometry_msgs/msg/PoseStamped", at + 5,
             {"header": {"stamp": stamp(at), "frame_id": "map"}, "pose": pose(*row)})
        for at, row in zip(odd, eta.tolist(), strict=True)
    ]  # fmt: skip
    del t
    record = seatrial.read(mcap(tmp_path / "run.mcap", sent + joy_sent(LENGTH)), vehicle())
    assert record.stamps.tolist() == odd
