# SPDX-License-Identifier: MIT
"""Sources of a session: the same events as the reader of logs finds, whatever arrives; hostile input ends none."""

import json
import os
import pty
import socket
import sqlite3
import struct
import subprocess
import sys
import threading
import time
import tty
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from pathlib import Path

import msgspec
import numpy as np
import pytest
from autopilot_logs import trial
from bag_tools import bag_records, joy_sent, poses_sent, ros1, ros2
from bag_tools import vehicle as bag_boat
from mavlink_logs import telemetry as write_telemetry
from mcap_writer import mcap
from test_init_logs import proposed
from waiting import PATIENCE, until

from seatrial.boat.vehicle import Vehicle, load_vehicle, vehicle_from
from seatrial.io.bags.growing.db3 import GrowingDb3
from seatrial.io.bags.growing.mcap import GrowingMcap
from seatrial.io.bags.growing.ros1 import GrowingRos1
from seatrial.io.reader import read
from seatrial.onboard.live.endpoints import LONGEST_LINE, Pipes
from seatrial.poolside.sources import open_source
from seatrial.poolside.sources.lines import LineSource, datagrams
from seatrial.poolside.sources.mavlink_stream import FrameStream
from seatrial.poolside.sources.telemetry import TelemetrySource, telemetry
from seatrial.util.errors import FileError, LiveError, RecordingError, SeatrialError
from seatrial.util.frames import Axes


@pytest.fixture(autouse=True)
def _no_silence(monkeypatch):
    """A machine that stands still is no recorder that has stopped."""
    monkeypatch.setattr("seatrial.poolside.sources.follow_bag.SILENT", float("inf"))


VEHICLE = {
    "seatrial": "vehicle 1",
    "name": "boat",
    "axes": "forward-left-up",
    "pose": {"stamp": "t", "x": "x", "y": "y", "psi": {"column": "psi", "unit": "deg"}},
    "commands": {"stamp": "t", "inputs": {"F_u": "F_u", "F_v": "F_v", "F_r": "F_r"}},
    "structure": "mallard",
}


def vehicle(**changed) -> Vehicle:
    return vehicle_from({**VEHICLE, **changed}, "vehicle.yaml")


@pytest.fixture
def sender():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        yield opened


def through_pipe(text: bytes, boat: Vehicle) -> tuple[list[object], tuple[str, ...]]:
    """The events of text on standard input, and what is said of it."""
    inlet, outlet = os.pipe()

    def write() -> None:
        with os.fdopen(outlet, "wb") as file:
            file.write(text)

    threading.Thread(target=write).start()
    with os.fdopen(inlet, "rb") as file:
        source = LineSource("-", boat, Pipes(file, sys.stdout.buffer))
        return list(source), source.problems


@contextmanager
def gathered(source):
    """A list that fills with the source's events; at the end it is closed."""
    found: list[object] = []
    thread = threading.Thread(target=lambda: found.extend(source))
    with source:
        thread.start()
        yield found
        source.close()
        thread.join(PATIENCE)
    assert not thread.is_alive()


# Lines #


def test_lines_are_events_in_forward_left_up():
    boat = vehicle(axes="forward-right-down")
    text = b"""# a comment
{"t": 1.5, "pose": [1, 2, 0.5]}

command,1.6,0.1,0.2,0.3
{"stamp": 1700000000123456789, "position": [1, 2]}
{"t": 3, "heading": 0.25}
"""
    before = time.time_ns()
    events, said = through_pipe(text, boat)
    assert said == ()
    assert [e.kind for e in events] == ["pose", "command", "position", "heading"]
    assert [e.stamp for e in events[:3]] == [1_500_000_000, 1_600_000_000, 1700000000123456789]
    np.testing.assert_array_equal(events[0].values, [1, -2, -0.5])
    np.testing.assert_array_equal(events[1].values, [0.1, -0.2, -0.3])
    np.testing.assert_array_equal(events[2].values, [1, -2])
    np.testing.assert_array_equal(events[3].values, [-0.25])
    assert all(before <= e.arrival <= time.time_ns() for e in events)


def test_a_line_without_a_time_is_stamped_when_it_arrives():
    ((event,), _) = through_pipe(b'{"pose": [1, 2, 3]}\n', vehicle())
    assert event.stamp == event.arrival


BAD = [
    b"\xff\xfe\x00", b"nonsense", b"[" * 50_000, b'{"t": 1, "pose": [1, 2]}', b'{"t": 1, "pose": [1, 2, 1e300]}',
    b"pose,1,nan,2,3", b"pose,1,inf,2,3", b'{"t": 1e99, "pose": [1,2,3]}', b'{"stamp": 1e30, "pose": [1,2,3]}',
    b'{"t": 1, "command": [1]}', b'{"at": 3}', b'{"reload": true}', b'{"adapt": true}', b"x" * (LONGEST_LINE + 10),
    b'{"t": 1, "scale": [1]}', b"command,2,,,", b"\0" * 100,
]  # fmt: skip


def test_bad_lines_are_counted_and_end_nothing():
    good = b'{"t": 9, "pose": [1, 2, 3]}\n'
    events, (text,) = through_pipe(b"\n".join([*BAD, good]), vehicle())
    assert [e.stamp for e in events] == [9_000_000_000]
    number = int(text.split()[0])
    assert number >= len(BAD)  # the long line is several
    assert "lines could not be used; the last: line" in text
    assert len(text) < 400


def test_udp_is_on_loopback_unless_an_address_is_given(sender):
    source = datagrams("udp:0", vehicle())
    port = source._endpoint.port
    assert source._endpoint._socket.getsockname()[0] == "127.0.0.1"
    with gathered(source) as found:
        sender.sendto(
            b'{"t": 1, "pose": [1, 2, 3]}\n{"t": 1, "command": [0, 0, 0]}', ("127.0.0.1", port)
        )
        sender.sendto(b"junk", ("127.0.0.1", port))
        until(lambda: len(found) >= 2 and source.problems)
    assert [e.kind for e in found] == ["pose", "command"]
    again = datagrams(f"udp:127.0.0.1:{port}", vehicle())  # the port is free again
    again.close()


def test_lines_that_had_arrived_are_used_when_it_is_closed(sender):
    with datagrams("udp:0", vehicle()) as source:
        events = iter(source)
        place = ("127.0.0.1", source._endpoint.port)
        sender.sendto(b"pose,1,1,2,3", place)
        first = next(events)
        assert source.behind < PATIENCE
        for i in range(2, 102):
            sender.sendto(b"pose,%d,1,2,3" % i, place)
        source.close()  # loopback hands over at once what is sent
        assert [e.stamp for e in (first, *events)] == [i * 1_000_000_000 for i in range(1, 102)]
        assert source.behind == 0.0


def test_a_line_that_waits_shows_how_far_its_user_is_behind(sender):
    with datagrams("udp:0", vehicle()) as source:
        sender.sendto(b"pose,1,1,2,3\npose,2,1,2,3", ("127.0.0.1", source._endpoint.port))
        events = iter(source)
        next(events)
        behind = source.behind
        until(lambda: source.behind > behind + 0.1)


def test_an_empty_datagram_ends_nothing(sender):
    with datagrams("udp:0", vehicle()) as source:
        events = iter(source)
        place = ("127.0.0.1", source._endpoint.port)
        for text in (b"pose,1,1,2,3", b"", b"pose,2,1,2,3"):
            sender.sendto(text, place)
        assert [next(events).stamp for _ in range(2)] == [1_000_000_000, 2_000_000_000]


def test_options_of_a_replay_are_refused_for_a_stream(tmp_path):
    for text in ("-", "udp:0", "follow:here"):
        with pytest.raises(LiveError, match=r"--speed 2: .* is for a replay"):
            open_source(text, vehicle(), 2.0)
        with pytest.raises(LiveError, match=r"--salvage: .* is for a replay"):
            open_source(text, vehicle(), salvage=True)


@pytest.mark.parametrize(
    "text",
    ["udp:", "udp:x", "udp:99999", "udp:-1", "udp:1.2.3.4:", "udp:\u0663", "udp:300.1.1.1:9000", "mavlink:", "mavlink:x",
     "mavlink:/dev/none:57600", "mavlink:/dev/null:x", "mavlink:udp:x", "follow:/nowhere/at/all.csv", "follow:log.bin",
     "nothing.csv", ""],
)  # fmt: skip
def test_a_source_that_is_none_is_one_error(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    boat = vehicle(
        pose={"topic": "GPS_RAW_INT", "latitude": "lat", "longitude": "lon", "psi": {"topic": "ATTITUDE", "field": "yaw"}},
        commands={"topic": "SERVO_OUTPUT_RAW", "inputs": {"F_u": "servo1_raw", "F_v": "servo2_raw", "F_r": "servo3_raw"}},
    )  # fmt: skip
    with pytest.raises(SeatrialError):
        open_source(text, boat)


# Replays #


def poses_of(events):
    return [e for e in events if e.kind == "pose"]


def table(path, rows=200, begin=0):
    t = begin + np.arange(rows) * 0.05
    cells = np.column_stack(
        [t, np.sin(t), np.cos(t), np.degrees(0.3 * t), np.sign(np.sin(3 * t)), 0.1 * t, 0 * t]
    )
    lines = [",".join(map(repr, row)) for row in cells.tolist()]
    path.write_text("t,x,y,psi,F_u,F_v,F_r\n" + "\n".join(lines) + "\n")
    return lines


def test_a_replay_is_the_recording(tmp_path):
    table(tmp_path / "run.csv")
    boat = vehicle()
    source = open_source(str(tmp_path / "run.csv"), boat, 0.0)
    events = list(source)
    recording = read(tmp_path / "run.csv", boat)
    poses = poses_of(events)
    assert [e.stamp for e in poses] == recording.stamps.tolist()
    np.testing.assert_allclose([e.values for e in poses], recording.eta, atol=1e-12)
    commands = [e for e in events if e.kind == "command"]
    np.testing.assert_array_equal([e.values for e in commands], recording.commands.values)
    arrivals = [e.arrival for e in events]
    assert arrivals == sorted(arrivals)
    assert source.now() == arrivals[-1]
    assert source.recorded


def test_a_replay_gives_the_measured_point_not_the_origin(tmp_path):
    table(tmp_path / "run.csv")
    plain, levered = vehicle(), vehicle(pose={**VEHICLE["pose"], "lever": [0.5, -0.2]})
    both = [poses_of(open_source(str(tmp_path / "run.csv"), b, 0.0)) for b in (plain, levered)]
    np.testing.assert_array_equal(*[[e.values for e in events] for events in both])


def test_a_replay_keeps_rows_that_are_out_of_order(tmp_path):
    lines = table(tmp_path / "run.csv")
    lines[50], lines[60] = lines[60], lines[50]
    (tmp_path / "run.csv").write_text("t,x,y,psi,F_u,F_v,F_r\n" + "\n".join(lines) + "\n")
    events = list(open_source(str(tmp_path / "run.csv"), vehicle(), 0.0))
    stamps = [e.stamp for e in poses_of(events)]
    assert sorted(stamps) != stamps
    assert len(stamps) == 200
    arrivals = [e.arrival for e in events]
    assert arrivals == sorted(arrivals)


class Clock:
    """A clock that goes on only while somebody waits, as a source's `Event` waits."""

    def __init__(self, closed_at: float = np.inf) -> None:
        self.now, self.closed_at = 100.0, 100.0 + closed_at

    def monotonic(self) -> float:
        return self.now

    def wait(self, seconds: float) -> None:
        self.now += seconds

    def is_set(self) -> bool:
        return self.now >= self.closed_at


def test_a_replay_at_speed_takes_its_share_of_the_time(tmp_path, monkeypatch):
    table(tmp_path / "run.csv", 41)

    def replayed(speed, closed_at=np.inf):
        source, clock = open_source(str(tmp_path / "run.csv"), vehicle(), speed), Clock(closed_at)
        monkeypatch.setattr("seatrial.poolside.sources.replay.time", clock)
        source._closed = clock
        return [(clock.now - 100.0, event) for event in source]

    events = replayed(4.0)
    begin = events[0][1].arrival
    for at, event in events:
        assert at == pytest.approx((event.arrival - begin) * 1e-9 / 4.0)
    assert events[-1][0] == pytest.approx(0.5)  # 2 s of recording
    assert [event.stamp for _, event in replayed(4.0, 0.25)] == [
        event.stamp for at, event in events if at < 0.25
    ]
    source = open_source(str(tmp_path / "run.csv"), vehicle(), 0.01)
    monkeypatch.undo()
    threading.Timer(0.3, source.close).start()
    assert len(list(source)) < 10  # a wait ends where it is closed
    with pytest.raises(LiveError):
        open_source(str(tmp_path / "run.csv"), vehicle(), float("nan"))


# Growing bags #


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


@pytest.mark.parametrize(("compression", "chunk"), [("zstd", 50), ("lz4", 7), ("", 0)])
def test_an_mcap_that_grows_gives_what_it_reads_in_the_end(tmp_path, compression, chunk):
    sent = poses_sent(6.0) + joy_sent(6.0)
    whole = mcap(tmp_path / "whole.mcap", sent, compression, chunk=chunk)
    content, boat = whole.read_bytes(), bag_boat()
    cuts = np.linspace(0, len(content), 9)[1:-1].astype(int).tolist()
    found, said = grown(tmp_path / "run.mcap", boat, content, cuts)
    assert said == ()
    is_all_of(found, whole, boat)


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_a_ros1_bag_that_grows_gives_what_it_reads_in_the_end(tmp_path, compression):
    whole = ros1(tmp_path / "whole.bag", poses_sent(6.0) + joy_sent(6.0), compression)
    content, path = whole.read_bytes(), tmp_path / "run.bag"
    cuts = np.linspace(0, len(content), 9)[1:-1].astype(int).tolist()
    found, said = grown(path.with_name("run.bag.active"), bag_boat(), content, cuts)
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


def test_a_folder_of_ros1_bags_is_followed_from_one_to_the_next(tmp_path):
    sent = sorted(poses_sent(6.0) + joy_sent(6.0), key=lambda s: s.time)
    folder = tmp_path / "run"
    folder.mkdir()
    first = ros1(folder / "run_0.bag", sent[:300]).rename(folder / "run_0.bag.active")
    source = open_source(f"follow:{folder}", bag_boat())
    with gathered(source) as found:
        until(lambda: found)
        first.rename(folder / "run_0.bag")
        ros1(tmp_path / "run_1.bag", sent[300:]).rename(folder / "run_1.bag.active")
    assert source.problems == ()
    assert len(sent) - 5 < len(found) <= len(sent)


def test_a_file_of_a_split_recording_without_a_message_is_passed(tmp_path):
    """As rosbag writes it where it is split before the first message: the header of a bag and nothing else."""
    folder, sent = tmp_path / "run", poses_sent(2.0)
    folder.mkdir()
    header = ros1(tmp_path / "whole.bag", sent).read_bytes()[:4117]
    (folder / "run_0.bag").write_bytes(header)
    bag = GrowingRos1(folder)
    assert bag.grow() == bag.grow() == set()
    ros1(folder / "run_1.bag", sent)
    (folder / "run_2.bag").write_bytes(header)
    ros1(folder / "run_3.bag", sent)
    for _ in range(12):
        bag.grow()
    (topic,) = bag.topics.values()
    assert topic.messages == 2 * len(sent)


@pytest.mark.parametrize("step", ["glob", "exists", "open"])
def test_no_message_is_lost_when_a_bag_gets_its_last_name(tmp_path, monkeypatch, step):
    """The recorder renames at any moment: here before each step of the search in turn."""
    folder = tmp_path / "run"
    folder.mkdir()
    active = ros1(tmp_path / "run_0.bag", poses_sent(1.0)).rename(folder / "run_0.bag.active")
    plain, calls = getattr(Path, step), []

    def renamed_before(self, *arguments, **named):
        if tmp_path in self.parents:
            calls.append(self)
            if len(calls) == nth:
                monkeypatch.setattr(Path, step, plain)
                active.rename(folder / "run_0.bag")
        found = plain(self, *arguments, **named)
        return iter(list(found)) if step == "glob" else found

    bag, nth = GrowingRos1(folder), 2 if step == "glob" else 1
    monkeypatch.setattr(Path, step, renamed_before)
    bag.grow()
    (topic,) = bag.topics.values()
    assert topic.messages == len(poses_sent(1.0))
    assert (folder / "run_0.bag").exists()


def test_a_folder_of_mcap_files_is_followed_from_one_to_the_next(tmp_path):
    sent = sorted(poses_sent(6.0) + joy_sent(6.0), key=lambda s: s.time)
    folder = tmp_path / "run"
    folder.mkdir()
    mcap(folder / "run_0.mcap", sent[:300])
    with gathered(open_source(f"follow:{folder}", bag_boat())) as found:
        until(lambda: len(found) > 200)
        mcap(folder / "run_1.mcap", sent[300:])
        until(lambda: len(found) > len(sent) - 5)
    assert len(sent) - 5 < len(found) <= len(sent)
    assert [e.kind for e in found].count("pose") == len(poses_sent(6.0))


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


# Telemetry #


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    folder = tmp_path_factory.mktemp("log")
    path = write_telemetry(folder / "run.tlog", trial())
    return path, proposed(path, folder)[1]


def records(path):
    """Arrivals [us] and frames of a log."""
    data, at = path.read_bytes(), 0
    while at < len(data):
        (arrival,) = struct.unpack_from(">Q", data, at)
        size = 12 + data[at + 9] if data[at + 8] == 0xFD else 8 + data[at + 9]
        yield arrival, data[at + 8 : at + 8 + size]
        at += 8 + size


class Script:
    """Bytes with their times of arrival."""

    def __init__(self, monkeypatch, blocks):
        self.blocks = iter(blocks)
        self.now = 0
        self.over = False
        monkeypatch.setattr("seatrial.poolside.sources.telemetry.time.time_ns", lambda: self.now)

    def read(self):
        try:
            self.now, block = next(self.blocks)
        except StopIteration:
            raise OSError("unplugged") from None
        return block

    def close(self):
        pass


def test_a_bag_that_is_cut_off_is_replayed_by_wish(tmp_path):
    bag = mcap(tmp_path / "run.mcap", poses_sent(2.0) + joy_sent(2.0), compression="")
    bag.write_bytes(bag.read_bytes()[:-200])
    with pytest.raises(RecordingError, match="--salvage reads what is left"):
        open_source(str(bag), bag_boat())
    kinds = [event.kind for event in open_source(str(bag), bag_boat(), 0.0, salvage=True)]
    assert {"pose", "command"} == set(kinds) and len(kinds) > 20


def test_telemetry_is_what_the_log_of_it_reads(log, monkeypatch):
    """Two minutes: positions, headings, and commands are those of the .tlog, stamps but for one offset."""
    path, boat = log
    blocks = [(usec * 1000, frame) for usec, frame in records(path)]
    source = TelemetrySource("mavlink", boat, Script(monkeypatch, blocks))
    events = list(source)
    assert any("unplugged" in text for text in source.problems)
    recorded = list(open_source(str(path), boat, 0.0))
    for kind in ("position", "heading", "command"):
        live, later = ([e for e in several if e.kind == kind] for several in (events, recorded))
        assert len(live) == len(later) > 500
        live.sort(key=lambda e: e.stamp)
        later.sort(key=lambda e: e.stamp)
        offsets = np.array([a.stamp - b.stamp for a, b in zip(live, later, strict=True)])
        assert np.ptp(offsets) < 1000  # [ns]
        assert 0 <= offsets[0] < 30_000_000  # the least delay of a second, of two minutes
        np.testing.assert_allclose([e.values for e in live], [e.values for e in later], atol=1e-9)


def test_frames_in_blocks_of_any_size_between_noise(log):
    path, _ = log
    frames = [frame for _, frame in islice(records(path), 400)]
    whole = [h.record for frame in frames for h in FrameStream().feed(frame)]
    rng = np.random.default_rng(3)
    noisy = b"".join(
        frame + (rng.bytes(int(rng.integers(1, 40))) if i % 5 == 0 else b"")
        for i, frame in enumerate(frames)
    )
    stream, found, at = FrameStream(), [], 0
    while at < len(noisy):
        size = int(rng.integers(1, 200))
        found += [h.record for h in stream.feed(noisy[at : at + size])]
        at += size
    found += [h.record for h in stream.feed(bytes(600))]
    assert found == whole
    assert stream.lost > 500


def test_bytes_that_are_no_frames_stay_bounded():
    stream = FrameStream()
    rng = np.random.default_rng(4)
    for _ in range(200):
        assert list(stream.feed(rng.bytes(1000))) == []
        assert len(stream._rest) < 400
    assert list(stream.feed(b"\xfd" * 100_000)) == []
    assert len(stream._rest) < 400


def test_an_autopilot_that_starts_again_gets_a_new_offset(log, monkeypatch):
    path, boat = log
    first = [(usec * 1000, frame) for usec, frame in records(path)][:2500]
    shift = first[-1][0] - first[0][0] + 10_000_000_000
    again = [(at + shift, frame) for at, frame in first]
    events = list(TelemetrySource("mavlink", boat, Script(monkeypatch, first + again)))
    late = np.array([(e.arrival - e.stamp) * 1e-9 for e in events if e.kind == "position"])
    assert np.all(np.abs(late) < 1.0)


def test_telemetry_over_udp_and_over_a_serial_line(log, sender):
    path, boat = log
    frames = [frame for _, frame in islice(records(path), 1500)]

    def taken(source, send):
        with gathered(source) as found:
            for i, frame in enumerate(frames):
                send(frame)
                if i % 10 == 0:
                    time.sleep(0.015)
            until(lambda: len(found) >= 300)

    source = telemetry("mavlink:udp:0", boat)
    port = source._transport.port
    taken(source, lambda frame: sender.sendto(frame, ("127.0.0.1", port)))
    master, slave = pty.openpty()
    tty.setraw(slave)
    serial = telemetry(f"mavlink:{os.ttyname(slave)}:115200", boat)
    taken(serial, lambda frame: os.write(master, frame))
    os.close(master)
    os.close(slave)


def test_a_message_that_mavlink_has_not_is_named(log):
    _, boat = log
    commands = msgspec.structs.replace(boat.file.commands, topic="SERVO_OUTPUT")
    wrong = replace(boat, file=msgspec.structs.replace(boat.file, commands=commands))
    with pytest.raises(RecordingError, match="did you mean SERVO_OUTPUT_RAW"):
        telemetry("mavlink:udp:0", wrong)
    with pytest.raises(RecordingError, match=r"init LOG\.tlog"):
        telemetry("mavlink:udp:0", vehicle())


# Tables that grow #


def test_a_table_that_grows_gives_what_it_reads_in_the_end(tmp_path):
    lines = table(tmp_path / "whole.csv")
    boat, path = vehicle(), tmp_path / "run.csv"
    source = open_source(f"follow:{path}", boat)
    with gathered(source) as events:
        until(lambda: source.problems)
        assert source.problems[0].startswith("waiting:")
        with path.open("w") as file:
            for text in ("t,x,y,psi,F_u", ",F_v,F_r\n", lines[0][:7]):
                file.write(text)
                file.flush()
                time.sleep(0.1)
            file.write(lines[0][7:] + "\n")
            for k in range(1, 200, 20):
                text = "\n".join(lines[k : k + 20]) + "\n"
                file.write(text[:33])
                file.flush()
                time.sleep(0.06)
                file.write(text[33:])
                file.flush()
        until(lambda: len(events) >= 400)
    recorded = list(open_source(str(tmp_path / "whole.csv"), boat, 0.0))
    assert [(e.kind, e.stamp) for e in poses_of(events)] == [
        (e.kind, e.stamp) for e in poses_of(recorded)
    ]
    for kind in ("pose", "command"):
        np.testing.assert_array_equal(
            *[[e.values for e in several if e.kind == kind] for several in (events, recorded)]
        )
    assert source.problems == ()


def test_a_large_table_that_was_begun_just_before_the_end_is_used_to_its_last_row(tmp_path):
    """A busy machine looks late: what was written before it is closed is used, of more blocks than one."""
    source = open_source(f"follow:{tmp_path / 'run.csv'}", vehicle())
    lines = table(tmp_path / "run.csv", 20_000)
    assert (tmp_path / "run.csv").stat().st_size > 1 << 20
    source.close()
    poses = poses_of(source)
    assert len(poses) == len(lines)
    assert source.problems == ()


def test_bags_that_were_written_before_the_end_are_all_used(tmp_path):
    """Of a folder: the first was being read when the others were written, and the source closed."""
    sent = sorted(poses_sent(6.0) + joy_sent(6.0), key=lambda s: s.time)
    mcap(tmp_path / "run_0.mcap", sent[:300])
    with open_source(f"follow:{tmp_path}", bag_boat()) as source:
        events = iter(source)
        found = [next(events)]
        mcap(tmp_path / "run_1.mcap", sent[300:400])
        mcap(tmp_path / "run_2.mcap", sent[400:])
        source.close()
        found += events
    assert len(sent) - 5 < len(found) <= len(sent)


def test_a_bad_row_of_a_growing_table_is_counted(tmp_path):
    lines = table(tmp_path / "run.csv")
    with (tmp_path / "run.csv").open("a") as file:
        file.write("11,1,2\nx,y,z,1,2,3,4\n,,,,,,\n" + "a" * 100 + "\n" + lines[-1] + "\n")
    source = open_source(f"follow:{tmp_path / 'run.csv'}", vehicle())
    with gathered(source) as found:
        until(lambda: len(found) >= 402)
    assert len(found) == 402
    (text,) = source.problems
    assert "run.csv" in text
    assert "could not be used" in text
    assert "/tmp" not in text


def test_a_folder_that_grows(tmp_path):
    boat = vehicle(
        pose={**VEHICLE["pose"], "file": "poses.csv"},
        commands={**VEHICLE["commands"], "file": "commands.csv"},
    )
    with gathered(open_source(f"follow:{tmp_path}", boat)) as events:
        for name in ("poses.csv", "commands.csv"):
            time.sleep(0.1)
            table(tmp_path / name, 100)
        until(lambda: len(events) >= 200)
        assert len(poses_of(events)) == 100


def test_a_growing_table_without_a_column_or_that_shrinks_ends_with_an_error(tmp_path):
    path = tmp_path / "run.csv"
    table(path, 20)
    path.write_text(path.read_text().replace("psi", "phi"))
    with pytest.raises(RecordingError, match="no column 'psi'"):
        list(open_source(f"follow:{path}", vehicle()))
    table(path, 20)
    events = iter(open_source(f"follow:{path}", vehicle()))
    for _ in range(40):
        next(events)
    table(path, 5)
    with pytest.raises(FileError, match="became shorter"):
        next(events)


def test_standard_input_by_a_real_pipe(tmp_path):
    (tmp_path / "vehicle.yaml").write_text(json.dumps(VEHICLE))
    code = (
        "import sys\nfrom seatrial.boat.vehicle import load_vehicle\n"
        "from seatrial.poolside.sources import open_source\n"
        "s = open_source('-', load_vehicle(sys.argv[1]))\n"
        "print([(e.kind, e.stamp) for e in s], s.problems)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "vehicle.yaml")], input="pose,1,1,2,3\nbad\n",
        capture_output=True, text=True, check=True, timeout=PATIENCE,
    )  # fmt: skip
    assert done.stdout.startswith("[('pose', 1000000000)] ('1 of 2 lines could not be used")
    assert load_vehicle(tmp_path / "vehicle.yaml").inputs == ("F_u", "F_v", "F_r")
    assert np.all(Axes.FRD.signs == [1, -1, -1])
