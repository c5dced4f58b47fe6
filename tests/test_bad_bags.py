# SPDX-License-Identifier: MIT
"""Bags that are not what was asked for are refused in a line that says what to do."""

import itertools
import struct
import tracemalloc

import numpy as np
import pytest
import yaml
from bad_bag_tools import LENGTH, both, made, messages, refused
from bag_shapes import WRITERS
from bag_tools import (
    SECOND,
    START,
    Sent,
    header,
    joy_sent,
    old_db3,
    pose,
    poses_sent,
    raw,
    ros1,
    ros2,
    split2,
    store,
    vehicle,
)
from mcap_writer import mcap
from rosbags.rosbag2 import StoragePlugin, Writer

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.recording.faults.pose_faults import FaultKind

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


# Not a bag, or not one we read #


@pytest.mark.parametrize(
    "name", ["run.bag", "run.bag.active", "run.mcap", "run.db3", "run.db3.zstd"]
)
def test_empty_files_and_other_files_are_told(tmp_path, name):
    path = tmp_path / name
    for content in (b"", b"\x89PNG\r\n\x1a\n" + bytes(200), b"PK\x03\x04" + b"x" * 5000, b"\n" * 9):
        path.write_bytes(content)
        for salvage in (False, True):
            line = refused(path, ".", salvage=salvage)
            assert str(path) in line
            if not content and not name.endswith("zstd"):
                assert "is empty; was anything recorded?" in line


def test_other_formats_and_versions_are_named(tmp_path, sent):
    path = tmp_path / "old.bag"
    path.write_bytes(b"#ROSBAG V1.2\n" + bytes(100))
    refused(path, "a bag of format 1.2; convert it with rosbag migrate")
    foreign = mcap(tmp_path / "foreign.mcap", sent)
    foreign.write_bytes(foreign.read_bytes().replace(b"\x04\0\0\0ros2", b"\x04\0\0\0ros1", 1))
    refused(foreign, "is an MCAP file, but not one of ROS 2; convert it")


def test_an_encrypted_bag_says_so(tmp_path, sent):
    content = made(tmp_path, "bag", sent).read_bytes()
    (head,) = struct.unpack_from("<I", content, 13)
    extra = struct.pack("<I", 19) + b"encryptor=rosbag/Ae"
    locked = content[:13] + struct.pack("<I", head + len(extra)) + content[17 : 17 + head] + extra
    path = tmp_path / "locked.bag"
    path.write_bytes(locked + content[17 + head :])
    refused(path, "is encrypted; decrypt it with rosbag decrypt")


def test_a_folder_with_metadata_only_and_a_missing_part_are_told(tmp_path, sent):
    folder = ros2(tmp_path / "run", sent)
    (folder / "run.mcap").unlink()
    refused(folder, r"the bag is damaged \(Some database files are missing")
    refused(folder, r"metadata.yaml exists, but no .mcap or .db3 next to it", salvage=True)
    split = split2(tmp_path / "split", sent, "mcap")
    (split / "split_5.mcap").unlink()
    refused(split, "missing")
    assert "/joy" in {m[0] for m in messages(split, salvage=True)}


def test_metadata_that_do_not_describe_the_files_are_left_out_and_named(tmp_path, sent):
    folder = ros2(tmp_path / "run", sent)
    for text in (
        "",
        "[]",
        "x: 1",
        "\t",
        "rosbag2_bagfile_information: {version: 99}",
        "\0",
        "a: *b",
    ):
        (folder / "metadata.yaml").write_text(text)
        assert len(messages(folder)) == len(sent)
        assert any("metadata.yaml" in r for r in seatrial.read(folder, vehicle()).remarks)


def test_stale_metadata_are_left_out_and_named(tmp_path, sent):
    folder = ros2(tmp_path / "run", sent)
    content = yaml.safe_load((folder / "metadata.yaml").read_text())
    own = content["rosbag2_bagfile_information"]
    for change, words in (
        ({"message_count": 0, "topics_with_message_count": []}, "counts no message"),
        ({"relative_file_paths": ["other.mcap"]}, "does not list run.mcap"),
    ):
        stale = {"rosbag2_bagfile_information": {**own, **change}}
        (folder / "metadata.yaml").write_text(yaml.safe_dump(stale))
        found = seatrial.read(folder, vehicle())
        assert any(f"metadata.yaml {words}: 1 file is read without it" in r for r in found.remarks)
        assert len(found.commands.stamps) == 300


def test_a_bag_with_fewer_messages_than_it_says_is_not_whole(tmp_path, sent):
    folder = ros2(tmp_path / "run", sent)
    content = yaml.safe_load((folder / "metadata.yaml").read_text())
    for topic in content["rosbag2_bagfile_information"]["topics_with_message_count"]:
        topic["message_count"] += 5
    (folder / "metadata.yaml").write_text(yaml.safe_dump(content))
    refused(
        folder,
        "the bag is damaged: 45 of 50 messages on /slam/pose are there; --salvage reads what",
    )
    assert len(seatrial.read(folder, vehicle(), salvage=True).commands.stamps) == 300


# Numbers and clocks #


@both
def test_poses_that_are_no_numbers_are_left_out_and_commands_hide_the_poses(tmp_path, kind):
    poses = poses_sent(LENGTH)
    odd = {5: float("nan"), 6: float("inf"), 7: -float("inf"), 8: 1e300}
    for i, value in odd.items():
        poses[i].fields["pose"]["position"]["x"] = value
    poses[20].fields["pose"]["orientation"] = dict.fromkeys("xyzw", 0.0)
    joy = joy_sent(LENGTH)
    for i in range(150, 160):
        joy[i].fields["axes"][1] = float("nan") if i % 2 else float("inf")
    record = seatrial.read(made(tmp_path, kind, poses + joy), vehicle())
    bad = np.flatnonzero(~record.valid).tolist()
    assert set(bad) >= {5, 6, 7, 8, 20, 23}
    assert set(bad) <= {5, 6, 7, 8, 20, 22, 23, 24}  # 1.50 s to 1.60 s
    kinds = [f.kind for f in record.faults]
    assert kinds.count(FaultKind.NOT_FINITE) == 2
    assert kinds.count(FaultKind.NO_NUMBER) == 1
    assert np.isfinite(record.commands.values).all()


@both
@pytest.mark.parametrize("jump", [-1.0, 3600.0])
def test_a_clock_that_is_set_while_recording_is_a_fault_not_a_tear(tmp_path, kind, jump):
    """The header's clock jumps, for poses and commands alike; the bag's does not."""
    later = [
        m._replace(fields={**m.fields, "header": header(
            m.fields["header"]["stamp"]["sec"] * SECOND + m.fields["header"]["stamp"]["nanosec"]
            + (round(jump * 1e9) if m.time >= START + 1.5e9 else 0), "map")})
        for m in poses_sent(LENGTH) + joy_sent(LENGTH)
    ]  # fmt: skip
    record = seatrial.read(made(tmp_path, kind, later), vehicle())
    assert np.all(np.diff(record.stamps) > 0)
    assert np.all(np.diff(record.commands.stamps) > 0)
    kinds = {f.kind for f in record.faults}
    assert kinds & {FaultKind.STAMP, FaultKind.GAP}
    assert record.streams[0].delay.step == pytest.approx(-jump, abs=0.01)
    arrivals = seatrial.read(
        tmp_path / f"run.{kind}", vehicle(pose={"clock": "bag"}, commands={"clock": "bag"})
    )
    assert arrivals.faults == ()


def test_stamps_that_no_clock_shows_are_damage(tmp_path, sent):
    path = mcap(tmp_path / "run.mcap", sent, "", crc=False)
    content = path.read_bytes()
    stamp = struct.pack("<Q", sent[60].time)
    path.write_bytes(content.replace(stamp, struct.pack("<Q", 1 << 63)))
    refused(path, "damaged.*--salvage")
    assert len(messages(path, salvage=True)) == len(sent) - 1


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


# Large #


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_a_bag_full_of_images_is_read_in_the_memory_of_what_is_wanted(tmp_path, kind):
    """48 MB of images; benchmarks/bags.py does the same with 2 GB."""
    image = {"format": "jpeg", "data": np.random.default_rng(0).bytes(1 << 20)}
    image["data"] = list(image["data"])
    sent = poses_sent(LENGTH) + joy_sent(LENGTH)
    photo = Sent("/camera", "sensor_msgs/msg/CompressedImage", START, image)
    packed = {ros1_: raw(photo, ros1=ros1_) for ros1_ in (True, False)}
    import bag_tools

    good = bag_tools.raw
    sent += [photo._replace(time=START + i * SECOND // 16, fields={}) for i in range(48)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            bag_tools, "raw",
            lambda s, *, ros1: packed[ros1] if s.topic == "/camera" else good(s, ros1=ros1),
        )  # fmt: skip
        path = (
            WRITERS["db3 file"](tmp_path, sent)
            if kind == "db3"
            else ros1(tmp_path / "run.bag", sent)
            if kind == "bag"
            else mcap(tmp_path / "run.mcap", sent, "", chunk=8)
        )
    assert path.stat().st_size > 48 << 20
    seatrial.read(path, vehicle())  # imports and definitions
    tracemalloc.start()
    record = seatrial.read(path, vehicle())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(record.stamps) == 45
    assert peak < 24 << 20  # a chunk of eight messages, and copies of it


@pytest.mark.parametrize("value", [1 << 63, (1 << 64) - 1, 10**6, 14])
def test_an_index_that_points_astray_is_damage(tmp_path, sent, value):
    path = ros1(tmp_path / "run.bag", sent)
    whole, content = messages(path), bytearray(path.read_bytes())
    struct.pack_into("<Q", content, content.index(b"chunk_pos=") + 10, value)
    path.write_bytes(content)
    refused(path, "--salvage reads what is left")
    assert messages(path, salvage=True) == whole
