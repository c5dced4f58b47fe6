# SPDX-License-Identifier: MIT
"""Every kind of bag: one content, one recording; what we write is read back."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from bag_shapes import WRITERS
from bag_tools import (
    SECOND,
    START,
    Sent,
    drive,
    joy_sent,
    other_sent,
    poses_sent,
    ros1,
    ros2,
    sticks,
    store,
    turn,
    vehicle,
)
from bags_same import JOY, LENGTH, assert_same
from mcap_writer import mcap
from rosbags.highlevel import AnyReader

import seatrial
from seatrial.io.bags.opening import open_bag
from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.io.trial_files import BAG_EPOCH, write_trial
from seatrial.recording.timing import Clock
from seatrial.util.errors import SeatrialError

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
        [BagTopic("/rc", "mavros_msgs/msg/RCOut", n + START, n + START, {"channels[7]": 1500.0 + n})],
    )  # fmt: skip
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
    np.testing.assert_array_equal(record.commands.stamps, trial.command_stamps + BAG_EPOCH)


def test_what_can_not_be_written_is_refused_and_leaves_nothing(tmp_path):
    n = np.arange(3) + START

    def topic(kind, columns):
        return [BagTopic("/cmd", kind, n, n, {c: np.full(3, v) for c, v in columns.items()})]

    for name, topics, words in (
        ("run.txt", [], "expected a file name ending in .bag, .mcap or .db3"),
        ("run.bag", topic("mavros_msgs/msg/RCOut", {"channels[0]": -1.0}),
         r"topic /cmd: 'channels\[0\]' gets -1 to -1; its range is 0 to 65535"),
        ("run.mcap", topic("mavros_msgs/msg/RCOut", {"channels[0]": np.nan}), "gets nan"),
        ("run.db3", topic(JOY, {"axis[0]": 1.0}), r"has no 'axis'; did you mean 'axes'"),
        ("run.bag", topic(JOY, {"axes[0]": 1.0, "channels[1]": 1.0}), "has no 'channels'"),
    ):  # fmt: skip
        with pytest.raises(SeatrialError, match=words):
            write_bag(tmp_path / "out" / name, topics)
        assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())
    with pytest.raises(SeatrialError, match="is a folder; give a file name"):
        (tmp_path / "run.bag").mkdir()
        write_bag(tmp_path / "run.bag", [])


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
