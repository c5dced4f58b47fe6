# SPDX-License-Identifier: MIT
"""What is no bag, or no whole one, is refused in a line that says what to do; odd numbers and clocks are faults."""

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
    poses_sent,
    raw,
    ros1,
    ros2,
    split2,
    vehicle,
)
from mcap_writer import mcap

import seatrial
from seatrial.recording.faults.pose_faults import FaultKind

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
