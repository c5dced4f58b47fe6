# SPDX-License-Identifier: MIT
"""Telemetry of an autopilot as the source of a session: the same events as the log of it has."""

import os
import pty
import socket
import struct
import time
import tty
from dataclasses import replace
from itertools import islice

import msgspec
import numpy as np
import pytest
from autopilot_logs import trial
from mavlink_logs import telemetry as write_telemetry
from poolside_sources import gathered, vehicle
from test_init_logs import proposed
from waiting import until

from seatrial.poolside.sources import open_source
from seatrial.poolside.sources.mavlink_stream import FrameStream
from seatrial.poolside.sources.telemetry import TelemetrySource, telemetry
from seatrial.util.errors import RecordingError


@pytest.fixture
def sender():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        yield opened


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    folder = tmp_path_factory.mktemp("log")
    path = write_telemetry(folder / "run.tlog", trial())
    return path, proposed(path)[1]


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
    frames = [frame for _, frame in islice(records(path), 600)]

    def taken(source, send):
        with gathered(source) as found:
            for i, frame in enumerate(frames):
                send(frame)
                if i % 10 == 0:
                    time.sleep(0.015)
            until(lambda: len(found) >= 120)

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
