# SPDX-License-Identifier: MIT
"""A bag that is followed while it is written: the same events as its reader finds in the end."""

import sqlite3
import struct
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from bag_tools import bag_records, joy_sent, poses_sent, ros1, ros2
from bag_tools import vehicle as bag_boat
from mcap_writer import mcap
from poolside_sources import gathered, no_silence  # noqa: F401  a fixture
from waiting import until

from seatrial.io.bags.growing.db3 import GrowingDb3
from seatrial.io.bags.growing.mcap import GrowingMcap
from seatrial.io.bags.growing.ros1 import GrowingRos1
from seatrial.poolside.sources import open_source
from seatrial.util.errors import FileError, RecordingError

pytestmark = pytest.mark.usefixtures("no_silence")


def grown(path, boat, content, cuts):
    """Events of a bag that is written up to each cut [bytes], and then to its end."""

    def write():
        for begin, end in zip([0, *cuts], [*cuts, len(content)], strict=True):
            with path.open("ab") as file:
                file.write(content[begin:end])
            time.sleep(0.1)

    path.write_bytes(b"")
    return followed(path, boat, write)


def followed(path, boat, write):
    """Events of a bag while `write` writes it, and what is said of it."""
    source = open_source(f"follow:{path}", boat)
    with gathered(source) as found:
        write()
    return found, source.problems


def is_all_of(found, whole, boat):
    """Whether these are the events of a whole bag, once both topics had a message."""
    expected = list(open_source(str(whole), boat, 0.0))
    for kind in ("pose", "command"):
        own, other = ([e for e in some if e.kind == kind] for some in (found, expected))
        missing = len(other) - len(own)
        assert 0 <= missing < 5
        assert [e.stamp for e in own] == [e.stamp for e in other][missing:]
        np.testing.assert_array_equal([e.values for e in own], [e.values for e in other][missing:])


@pytest.mark.parametrize(
    ("name", "written"),
    [
        *(("run.mcap", partial(mcap, compression=c, chunk=n)) for c, n in (("zstd", 50), ("lz4", 7), ("", 0))),
        *(("run.bag.active", partial(ros1, compression=c)) for c in ("none", "bz2", "lz4")),
    ],
)  # fmt: skip
def test_a_bag_that_grows_gives_what_it_reads_in_the_end(tmp_path, name, written):
    whole = written(tmp_path / f"whole{Path(name.removesuffix('.active')).suffix}", poses_sent(6.0) + joy_sent(6.0))  # fmt: skip
    content = whole.read_bytes()
    cuts = np.linspace(0, len(content), 9)[1:-1].astype(int).tolist()
    found, said = grown(tmp_path / name, bag_boat(), content, cuts)
    assert said == ()
    is_all_of(found, whole, bag_boat())


def looks_at(source, monkeypatch):
    """A function that waits until the source has looked at its bag, and used what it found, since it was called."""
    looks, plain = [0], source._bag.grow

    def grow():
        looks[0] += 1
        return plain()

    monkeypatch.setattr(source._bag, "grow", grow)

    def settled(_):
        before = looks[0]
        until(lambda: looks[0] > before + 2)

    return settled


def test_messages_of_a_chunk_that_rosbag_has_not_finished(tmp_path, monkeypatch):
    # rosbag writes lengths of 0, then the messages, then the lengths, and gives the bag its name
    boat, path = bag_boat(), tmp_path / "run.bag.active"
    whole = ros1(tmp_path / "whole.bag", poses_sent(6.0) + joy_sent(6.0), "none", chunk=1 << 22)
    content = bytearray(whole.read_bytes())
    ((_, at, end),) = [one for one in bag_records(content) if one[0] == 5]
    (head,) = struct.unpack_from("<I", content, at)
    begin = at + 8 + head
    lengths = [begin - 4, content.index(b"size=", at) + 5]
    known = [bytes(content[place : place + 4]) for place in lengths]
    for place in lengths:
        content[place : place + 4] = bytes(4)
    seen: list[int] = []
    path.write_bytes(b"")

    def write():
        with path.open("r+b", buffering=0) as bag:
            for cut in (begin, begin + (end - begin) // 3, begin + (end - begin) // 2, end):
                bag.write(content[bag.tell() : cut])
                settled(found)
                seen.append(len(found))
            for place, value in zip(lengths, known, strict=True):
                bag.seek(place)
                bag.write(value)
                settled(found)  # with one of them, too
            bag.seek(end)
            bag.write(content[end:])
        path.rename(tmp_path / "run.bag")

    source = open_source(f"follow:{path}", boat)
    settled = looks_at(source, monkeypatch)
    with gathered(source) as found:
        write()
    assert source.problems == ()
    first, third, half, all_of_it = seen
    assert first == 0 < third < half < all_of_it == len(found)
    is_all_of(found, whole, boat)


def begun(path):
    """A recording without a message yet."""
    if path.suffix == ".db3":
        base = sqlite3.connect(path)
        base.execute("PRAGMA journal_mode=WAL")
        base.execute(
            "CREATE TABLE metadata (id INTEGER PRIMARY KEY)"
        )  # the tables of messages come later
        base.close()
    else:
        path.write_bytes({".bag": b"#ROSBAG V2.0\n", ".mcap": b"\x89MCAP0\r\n"}[path.suffix])


@pytest.mark.parametrize("kind", [GrowingRos1, GrowingMcap, GrowingDb3])
def test_a_bag_that_is_deleted_while_it_is_followed_is_one_line(tmp_path, kind):
    path = tmp_path / f"run{kind.suffix}"
    begun(path)
    bag = kind(path)
    assert bag.grow() == set()
    for file in tmp_path.iterdir():
        file.unlink()
    with pytest.raises(FileError, match=r"run\..*: can't be read \(No such file or directory\)$"):
        bag.grow()


@pytest.mark.parametrize("mode", ["NONE", "MESSAGE"])
def test_a_db3_that_grows_gives_what_it_reads_in_the_end(tmp_path, mode):
    folder = ros2(tmp_path / "whole", poses_sent(6.0) + joy_sent(6.0), "sqlite3", mode)
    (whole,) = folder.glob("*.db3")
    path, boat = tmp_path / "run.db3", bag_boat()
    base = sqlite3.connect(path)
    base.execute("PRAGMA journal_mode = WAL")

    def write():
        base.execute("ATTACH ? AS whole", (str(whole),))
        for (text,) in base.execute(
            "SELECT sql FROM whole.sqlite_master WHERE type = 'table'"
        ).fetchall():
            base.execute(text)
        for name in ("topics", "message_definitions"):
            base.execute(f"INSERT INTO {name} SELECT * FROM whole.{name}")
        base.commit()
        rows = base.execute("SELECT max(id) FROM whole.messages").fetchone()[0]
        for k in range(8):
            time.sleep(0.1)
            query = "INSERT INTO messages SELECT * FROM whole.messages WHERE id * 8 / ? = ?"
            base.execute(query, (rows + 1, k))
            base.commit()
        base.close()
        time.sleep(0.2)

    found, said = followed(path, boat, write)
    assert said == ()
    is_all_of(found, folder, boat)
    # nothing of it is left beside the recorder's file
    kept = {"run.db3-wal", "run.db3-shm"}  # the recorder's, where it ended first
    assert sorted({p.name for p in tmp_path.iterdir()} - kept) == ["run.db3", "whole"]


def test_a_growing_bag_that_can_not_be_followed_is_one_line(tmp_path):
    sqlite3.connect(tmp_path / "run.db3").executescript("CREATE TABLE messages(id INTEGER)")
    (tmp_path / "odd.bag").write_bytes(b"no bag at all")
    whole = ros1(tmp_path / "whole.bag", poses_sent(2.0) + joy_sent(2.0)).read_bytes()
    (tmp_path / "run.bag").write_bytes(whole[:5000] + bytes(100) + whole[5000:])
    for name, said in {
        "run.db3": "no write-ahead log, .* --storage-preset-profile resilient",
        "odd.bag": "does not begin like a ROS 1 bag",
        "run.bag": r"is damaged at byte \d+",
    }.items():
        with pytest.raises(RecordingError, match=said):
            list(open_source(f"follow:{tmp_path / name}", bag_boat()))
    whole = mcap(tmp_path / "whole.mcap", poses_sent(2.0) + joy_sent(2.0), "").read_bytes()
    (tmp_path / "odd.mcap").write_bytes(b"no bag at all")
    with pytest.raises(RecordingError, match=r"does not begin like an \.mcap"):
        next(iter(open_source(f"follow:{tmp_path / 'odd.mcap'}", bag_boat())))
    damaged = whole[:2000] + bytes(100) + whole[2000:]
    (tmp_path / "run.mcap").write_bytes(damaged)
    with pytest.raises(RecordingError, match="is damaged at byte"):
        list(open_source(f"follow:{tmp_path / 'run.mcap'}", bag_boat()))


def test_a_growing_bag_without_a_topic_waits_for_it(tmp_path):
    mcap(tmp_path / "run.mcap", poses_sent(2.0))
    source = open_source(f"follow:{tmp_path / 'run.mcap'}", bag_boat())
    with gathered(source):
        until(lambda: source.problems)
        assert "waiting: " in source.problems[0] and "no topic /joy" in source.problems[0]
