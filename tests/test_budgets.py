# SPDX-License-Identifier: MIT
"""Files that are made to fill the memory, to run for ever, or to be taken for others: one line, soon."""

import bz2
import os
import sqlite3
import struct
import sys
from pathlib import Path

import pytest
import warm_program
from conftest import at_length

from seatrial.io.bags import bounded_rosbags, unpack
from seatrial.io.bags.opening import open_bag
from seatrial.io.bags.ros1 import Ros1Bag
from seatrial.io.bags.salvage_mcap import MAGIC
from seatrial.io.bags.unpack import zstd_decompressor
from seatrial.io.bags.wire import LONGEST_DEFINITION, MOST_FIELDS, Wire, parse_definition
from seatrial.io.bags.wire_walk import WireError
from seatrial.util import files
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.files import read_yaml

RULE = "\n" + "=" * 80 + "\n"
MEMORY = 1_500_000_000  # [bytes] of address space
SECONDS = 30  # [s] of CPU: some hundred times what it takes


def inspected(*arguments) -> tuple[int, str]:
    """Exit code and output, within limits of memory and CPU time."""
    code, out, err = warm_program.seatrial("inspect", *arguments, memory=MEMORY, seconds=SECONDS)
    assert "Traceback" not in err
    return code, out + err


def refused(*arguments) -> str:
    """The one line with which `inspect` refuses."""
    code, shown = inspected(*arguments)
    assert (code, shown.count("\n")) == (1, 1), shown
    return shown


def fan_out(levels: int, width: int, last: str) -> str:
    """A definition in which every level has `width` fields of the next one."""
    parts = [f"b/L1 a\nfloat64 z{''.join(f'{chr(10)}b/L1 f{i}' for i in range(width))}"]
    for level in range(1, levels):
        fields = "\n".join(f"b/L{level + 1} f{i}" for i in range(width))
        parts.append(f"MSG: b/L{level}\n{fields}")
    parts.append(f"MSG: b/L{levels}\n{last}")
    return RULE.join(parts)


@pytest.mark.parametrize("last", ["float64 x", "string x"])
def test_a_definition_that_fans_out_lists_some_fields_only(last):
    wire = Wire("b/msg/Top", parse_definition(fan_out(19, 8, last), "b/msg/Top"), cdr=True)
    found = wire.paths()
    assert len(found) <= MOST_FIELDS
    assert len(found) > 100 if last == "float64 x" else found == []
    with pytest.raises(RecordingError, match="has no 'q'"):
        wire.require("q", "here")


def test_fields_are_in_the_order_of_the_definition():
    text = "b/A first\nfloat64[3] then\nb/A[] many\nstring no" + RULE + "MSG: b/A\nint32 x\nint32 y"
    wire = Wire("b/msg/Top", parse_definition(text, "b/msg/Top"), cdr=True)
    assert wire.paths() == ["first.x", "first.y", "then[]", "many[].x", "many[].y"]


def test_a_definition_without_end_is_refused():
    with pytest.raises(WireError, match="characters"):
        parse_definition("float64 x\n" * (LONGEST_DEFINITION // 10 + 1), "b/msg/Top")


def zstd_compress(data: bytes) -> bytes:
    module = sys.modules[type(zstd_decompressor()).__module__]
    try:
        return module.compress(data)
    except AttributeError:
        from backports import zstd

        return zstd.compress(data)


def zeros(how: str, size: int) -> bytes:
    if how == "lz4":
        import lz4.frame

        return lz4.frame.compress(bytes(size))
    return zstd_compress(bytes(size)) if how == "zstd" else bytes(size)


def record(op: int, body: bytes) -> bytes:
    return struct.pack("<BQ", op, len(body)) + body


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def mcap(
    path: Path, how: str, size: int, stated: int, copies: int = 1, *, again: bool = False, keep: str = "index",
) -> Path:  # fmt: skip
    """An .mcap whose chunks are `size` zeros each, compressed, and state another size.

    `keep` of what is behind the chunks: their index, only statistics, only statistics without schemas, or nothing.
    """
    packed = zeros(how, size)
    body = (
        struct.pack("<QQQI", 1, 2, stated, 0) + text(how) + struct.pack("<Q", len(packed)) + packed
    )
    chunk, head = record(6, body), MAGIC + record(1, text("ros2") + text("test"))
    schema = record(
        3, struct.pack("<H", 1) + text("std_msgs/msg/Empty") + text("ros2msg") + text("")
    )
    channel = record(4, struct.pack("<HH", 1, 1) + text("/a") + text("cdr") + text(""))
    places = [len(head) + (0 if again else i * len(chunk)) for i in range(copies)]
    index = b"".join(
        record(8, struct.pack("<QQQQ", 1, 2, at, len(chunk)) + struct.pack("<I", 10) + struct.pack("<HQ", 1, at)
               + struct.pack("<Q", 0) + text(how) + struct.pack("<QQ", len(packed), stated))
        for at in places
    )  # fmt: skip
    counts = struct.pack("<I", 10) + struct.pack("<HQ", 1, copies)
    if keep != "index":
        index = b""
    if keep == "no schemas":
        schema = channel = b""
    index += record(11, struct.pack("<QHIIIIQQ", copies, 1, 1, 0, 0, copies, 1, 2) + counts)
    data = head + chunk * (1 if again else copies)
    summary = len(data) + len(record(15, struct.pack("<I", 0)))
    footer = record(2, struct.pack("<QQI", 0 if keep == "nothing" else summary, 0, 0))
    path.write_bytes(
        data + record(15, struct.pack("<I", 0)) + schema + channel + index + footer + MAGIC
    )
    return path


@pytest.mark.parametrize("how", ["zstd", "lz4"])
@pytest.mark.parametrize("stated", [1 << 29, 1000])
def test_a_chunk_that_inflates_is_refused(tmp_path, how, stated):
    """What it states is too much, or it states little and is much."""
    path = mcap(tmp_path / "bomb.mcap", how, 1 << 29 if how == "zstd" else 1 << 27, stated)
    assert path.stat().st_size < 2_000_000
    refused(path)
    refused(path, "--salvage")


def test_many_chunks_that_inflate_are_refused(tmp_path):
    path = mcap(tmp_path / "bomb.mcap", "zstd", 1 << 25, 1 << 25, 40)
    assert path.stat().st_size < 1_000_000
    assert "would become 1342 MB" in refused(path)


@pytest.mark.parametrize(
    "keep", ["index", at_length("statistics"), at_length("no schemas"), "nothing"]
)
@pytest.mark.parametrize("more", [(), ("--salvage",)])
def test_many_chunks_that_inflate_are_refused_without_their_index_too(tmp_path, keep, more):
    """It would take seconds for each pass: none of them is unpacked, with salvage those within the limit."""
    path = mcap(tmp_path / "bomb.mcap", "zstd", 1 << 25, 1 << 25, 40, keep=keep)
    assert f"its {path.stat().st_size} bytes would become" in refused(path, *more)


def test_a_chunk_that_is_listed_twice_is_refused(tmp_path):
    assert "lists a chunk twice" in refused(
        mcap(tmp_path / "bomb.mcap", "zstd", 1000, 1000, 3, again=True)
    )


@pytest.mark.parametrize(
    ("packed", "most"), [(100, 1 << 26), (50_000_000, 1 << 30), (1_000_000, 256_000_000)]
)
def test_the_limits_leave_room_for_real_chunks(packed, most):
    assert unpack.chunk_limit(packed) == most
    assert unpack.file_limit(packed) >= 1 << 30
    unpack.check_chunks(
        Path("a"), [(i, 50_000_000, 200_000_000) for i in range(100)], 5_000_000_000
    )
    unpack.check_chunks(Path("a"), [(i, 10_000, 1 << 20) for i in range(500)], 5_000_000)


def field(name: str, value: bytes) -> bytes:
    return struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value


def ros1(path: Path, size: int, stated: int, copies: int = 1) -> Path:
    def one(fields: dict[str, bytes], data: bytes) -> bytes:
        head = b"".join(field(name, value) for name, value in fields.items())
        return struct.pack("<I", len(head)) + head + struct.pack("<I", len(data)) + data

    u32, u64 = struct.Struct("<I").pack, struct.Struct("<Q").pack
    chunk = one(
        {"op": b"\5", "compression": b"bz2", "size": u32(stated)}, bz2.compress(bytes(size))
    )
    begin = b"#ROSBAG V2.0\n"

    def head(at: int) -> bytes:
        return one(
            {"op": b"\3", "index_pos": u64(at), "conn_count": u32(1), "chunk_count": u32(copies)},
            b"",
        )

    place = len(begin) + len(head(0))
    kind = (
        field("topic", b"/a")
        + field("type", b"std_msgs/Empty")
        + field("md5sum", b"*")
        + field("message_definition", b"")
    )
    connection = one({"op": b"\7", "conn": u32(0), "topic": b"/a"}, kind)
    info = one({"op": b"\6", "ver": u32(1), "chunk_pos": u64(place), "start_time": u64(1), "end_time": u64(2), "count": u32(1)},
               u32(0) + u32(1))  # fmt: skip
    path.write_bytes(begin + head(place + len(chunk)) + chunk + connection + info * copies)
    return path


@pytest.mark.system
def test_a_chunk_of_ros1_that_inflates_is_refused(tmp_path):
    path = ros1(tmp_path / "bomb.bag", 1 << 28, 1 << 29)
    assert path.stat().st_size < 10_000
    for more in ((), ("--salvage",)):
        refused(path, *more)


def test_a_chunk_of_ros1_is_unpacked_to_its_stated_size_only(tmp_path):
    """1000 of its 67 million zeros, which are no message."""
    code, shown = inspected(ros1(tmp_path / "bomb.bag", 1 << 26, 1000))
    assert code == 0
    assert "/a" in shown


def test_a_chunk_of_ros1_that_is_listed_twice_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="a chunk is in the index twice"):
        Ros1Bag(ros1(tmp_path / "bomb.bag", 1000, 1000, 2))


def test_a_compressed_file_that_inflates_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "bomb.mcap.zstd"
    path.write_bytes(zstd_compress(bytes(1 << 24)) * 5)  # 84 MB
    assert path.stat().st_size < 10_000
    monkeypatch.setattr(unpack, "ALWAYS_FILE", 1 << 26)  # of 1 GB, as above
    monkeypatch.setattr(unpack.tempfile, "tempdir", str(tmp_path))
    with pytest.raises(RecordingError, match="become more than 67 MB"):
        open_bag(path)
    assert [p.name for p in tmp_path.iterdir()] == ["bomb.mcap.zstd"]


def bag(path: Path) -> Path:
    """A .db3 of one topic, plain."""
    path.unlink(missing_ok=True)
    base = sqlite3.connect(path)
    base.executescript(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, offered_qos_profiles TEXT);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);"
        f"INSERT INTO topics VALUES(1, '/{path.stem.encode().hex()}', 'std_msgs/msg/Empty', 'cdr', '');"
        "INSERT INTO messages VALUES(1, 1, 5, x'00010000');"
    )
    base.close()
    return path


ENDLESS = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT max(x) AS"


@pytest.mark.parametrize(
    "statement",
    [
        f"CREATE VIEW schema AS {ENDLESS} schema_version FROM c",
        f"DROP TABLE topics; CREATE VIEW topics AS {ENDLESS} id FROM c",
        f"DROP TABLE messages; CREATE VIEW messages AS {ENDLESS} id FROM c",
        f"CREATE VIEW message_definitions AS {ENDLESS} id FROM c",
        "CREATE TRIGGER t AFTER INSERT ON topics BEGIN SELECT 1; END",
    ],
)
@pytest.mark.parametrize("salvage", [(), ("--salvage",)])
def test_a_database_with_views_is_not_read(tmp_path, statement, salvage):
    path = bag(tmp_path / "endless.db3")
    base = sqlite3.connect(path)
    base.executescript(statement)
    base.close()
    assert "which no recording has" in refused(path, *salvage)


@pytest.mark.parametrize(
    "name", ["a#1.db3", "a?mode=rw.db3", "a%31.db3", "a%00.db3", "a b+c.db3", "ä#.db3"]
)
def test_a_file_is_read_by_its_own_name(tmp_path, name):
    folder = tmp_path / "100%25 #1?"
    folder.mkdir()
    bag(folder / "a")  # what `a#1.db3` is as a URI
    bag(folder / "a1.db3")
    path = bag(folder / name)
    for salvage in (False, True):
        with open_bag(path, salvage=salvage) as opened:
            assert [*opened.topics] == [f"/{path.stem.encode().hex()}"]
            assert len(list(opened.messages(opened.topics))) == 1


@pytest.mark.parametrize(
    "text", ["[" * 30_000, "{a: " * 30_000, "- " * 30_000, "? " * 5_000, "a: " + "[" * 51]
)
def test_deep_yaml_is_refused(tmp_path, text):
    """In a process of its own, as it ended in a segmentation fault."""
    (tmp_path / "deep.yaml").write_text(text)
    assert "is more than 50 lists or mappings deep" in refused(
        tmp_path, "--vehicle", tmp_path / "deep.yaml"
    )


def test_the_metadata_of_a_bag_may_not_be_deep_either(tmp_path):
    bag(tmp_path / "a.db3")
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: " + "[" * 30_000)
    code, shown = inspected(tmp_path)
    assert code == 0 and "metadata.yaml" in shown


def test_a_yaml_file_without_end_is_refused(monkeypatch):
    assert files.MOST_BYTES == 64_000_000
    monkeypatch.setattr(files, "MOST_BYTES", 2_000_000)
    with pytest.raises(FileError, match="below 2 MB"):
        read_yaml(Path("/dev/zero"))


def test_a_bag_of_large_chunks_is_read(tmp_path):
    """One chunk of 50 MB, compressed ten times: what an honest recorder of images may write."""
    size = 50_000_000
    packed_part = os.urandom(size // 10) + bytes(size - size // 10)
    packed = zstd_compress(packed_part)
    found = bounded_rosbags._whole(zstd_decompressor(), packed)
    assert found == packed_part
