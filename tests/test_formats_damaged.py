# SPDX-License-Identifier: MIT
"""Damaged logs of autopilots: what is lost is counted, noise is refused, the rest is read."""

import struct
import time

import numpy as np
import pytest
from autopilot_logs import ardupilot, binary_message, text_message, trial
from autopilot_runs import RUN, WRITERS, samples
from px4_logs import ULOG, px4, ulog_message

from seatrial.io.formats import open_log
from seatrial.io.formats.layout import READ
from seatrial.util.errors import RecordingError


@pytest.mark.parametrize("name", WRITERS)
def test_a_damaged_place_costs_what_it_covers(tmp_path, name):
    """Noise in the middle and a torn end: nearly all is still read, the loss is counted."""
    path = WRITERS[name](tmp_path / name, RUN)
    whole = open_log(path)
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 700] = np.random.default_rng(0).bytes(700)
    path.write_bytes(data[:-5])
    log = open_log(path)
    assert log.remarks
    assert any(char.isdigit() for char in log.remarks[0])
    kept = sum(t.messages for t in log.topics.values()) / sum(
        t.messages for t in whole.topics.values()
    )
    # ULog: what follows is lost up to the next sync message, one a second here
    assert (0.9 if name.endswith("ulg") else 0.97) < kept < 1.0
    topic = max(log.topics.values(), key=lambda t: t.messages)
    assert len(samples(log, topic.name, topic.fields[0]).stamps) >= 0.9 * topic.messages


@pytest.mark.parametrize("name", ["run.BIN", "run.ulg", "run.tlog"])
def test_a_long_hole_is_one_place(tmp_path, name):
    """Longer than the blocks that are read at once."""
    path = WRITERS[name](tmp_path / name, trial(seconds=120.0))
    whole, data = open_log(path), path.read_bytes()
    hole = b"\x01\x02\x00" * (READ // 2)
    middle = len(data) // 2
    path.write_bytes(data[:middle] + hole + data[middle:])
    if name == "run.ulg":
        log = open_log(path)
        assert "in 1 places" in log.remarks[0]
        kept = sum(t.messages for t in log.topics.values())
        assert kept > 0.95 * sum(t.messages for t in whole.topics.values())
    else:
        with pytest.raises(RecordingError, match="badly damaged"):
            open_log(path)


def test_padding_between_blocks_is_no_loss(tmp_path):
    """Flash chips are written in pages."""
    path = ardupilot(tmp_path / "run.BIN", RUN)
    data = path.read_bytes()
    at = data.index(b"\xa3\x95\x07", len(data) // 2)
    path.write_bytes(data[:at] + b"\xff" * 200 + data[at:] + bytes(300))
    log = open_log(path)
    assert log.remarks == ()
    assert log.topics["ATT"].messages == 400


def test_a_redefined_message_is_read_by_its_definition(tmp_path):
    """Two logs joined, the second with another ATT."""
    path = ardupilot(tmp_path / "run.BIN", RUN)
    second = b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", 7, 15, b"ATT", b"Qf", b"TimeUS,Yaw")
    more = b"".join(b"\xa3\x95\x07" + struct.pack("<Qf", 10**8 + i, 45.5) for i in range(10))
    path.write_bytes(path.read_bytes() + second + more)
    log = open_log(path)
    found = samples(log, "ATT", "Yaw", "Roll")
    assert log.topics["ATT"].messages == len(found.stamps) == 410
    assert found.values[-1, 0] == 45.5
    assert np.isnan(found.values[-10:, 1]).all()
    assert np.isfinite(found.values[:-10]).all()


def test_formats_in_formats_do_not_fan_out(tmp_path):
    """1000 bytes that would be 10^12 fields."""
    path = px4(tmp_path / "run.ulg", RUN)
    formats = [ulog_message("F", b"f0:uint64_t timestamp;")]
    formats += [ulog_message("F", f"f{i}:f{i - 1}[9999] a;".encode()) for i in range(1, 6)]
    formats.append(ulog_message("F", b"loop:uint64_t timestamp;loop a;"))
    formats += [
        ulog_message("A", b"\0" + struct.pack("<H", 90 + i) + n)
        for i, n in enumerate((b"f5", b"loop"))
    ]
    data = path.read_bytes()
    at = data.index(ulog_message("F", b"sensor_gps")[2:]) - 2
    path.write_bytes(data[:at] + b"".join(formats) + data[at:])
    log = open_log(path)
    assert "f5" not in log.topics
    assert "loop" in " ".join(log.remarks)
    assert log.topics["sensor_gps"].messages == 100


def test_data_appended_behind_a_torn_message(tmp_path):
    """ULog: the crash dump of a log is appended, at an offset of its flags."""
    path = px4(tmp_path / "run.ulg", RUN)
    data = bytearray(path.read_bytes())
    torn = bytes(data[:-40])
    sync = ulog_message("S", bytes.fromhex("2f731320250cbb12"))
    flags = bytearray(40)
    flags[8] = 1
    flags[16:24] = len(torn).to_bytes(8, "little")
    content = torn.replace(ulog_message("B", bytes(40)), ulog_message("B", bytes(flags)))
    stamp = struct.pack("<Q", 10**9)
    numbers = {n: i for i, n in enumerate(ULOG)}
    late = ulog_message(
        "D", struct.pack("<H", numbers["battery_status"]) + stamp + struct.pack("<ff", 9.5, 0)
    )
    path.write_bytes(content + sync + late)
    found = samples(open_log(path), "battery_status", "voltage_v")
    assert found.values[-1, 0] == 9.5


def test_an_unknown_flag_of_a_ulog_is_refused(tmp_path):
    path = px4(tmp_path / "run.ulg", RUN)
    flags = bytearray(40)
    flags[8] = 4
    path.write_bytes(
        path.read_bytes().replace(ulog_message("B", bytes(40)), ulog_message("B", bytes(flags)))
    )
    with pytest.raises(RecordingError, match="incompatible flags"):
        open_log(path)


def test_impossible_stamps_are_dropped_and_counted(tmp_path):
    path = ardupilot(tmp_path / "run.BIN", RUN)
    bad = binary_message("BAT", (2**64 - 1, 0, 1.0, 1.0))
    path.write_bytes(path.read_bytes() + bad)
    found = samples(open_log(path), "BAT", "Volt")
    assert found.dropped == 1
    assert len(found.stamps) == 20


def test_lines_of_text_that_are_no_message_are_counted(tmp_path):
    path = ardupilot(tmp_path / "run.log", RUN, text=True)
    path.write_bytes(path.read_bytes() + b"what\nATT, 1\n" + text_message("BAT", (1, 0, 12.0, 1.0)))
    log = open_log(path)
    assert log.remarks == ("2 lines are no message",)
    assert samples(log, "BAT", "Volt").values[-1] == 12.0


def test_nothing_is_printed(tmp_path, capfd):
    for name, write in WRITERS.items():
        path = write(tmp_path / name, RUN)
        data = bytearray(path.read_bytes())
        data[len(data) // 3 : len(data) // 3 + 90] = bytes(90)
        path.write_bytes(data)
        open_log(path)
    assert capfd.readouterr() == ("", "")


def test_definitions_without_end_are_not_followed(tmp_path):
    """A log of 100 000 definitions, each another one of the same message, in time."""
    path = ardupilot(tmp_path / "run.BIN", RUN)
    more = b"".join(
        b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", 7, 15, b"ATT", b"Qf", b"TimeUS,Y%d" % i)
        for i in range(100_000)
    )
    path.write_bytes(path.read_bytes() + more)
    begin = time.process_time()
    assert open_log(path).topics["GPS"].messages == 100
    assert time.process_time() - begin < 10.0


@pytest.mark.parametrize("name", ["run.BIN", "run.log", "run.tlog"])
def test_a_log_that_is_mostly_noise_is_refused(tmp_path, name):
    """A ULog is not: it says where its messages begin again."""
    path = WRITERS[name](tmp_path / name, RUN)
    noise = b"\n" * 300_000 if name == "run.log" else b"\xa3\x95" * 2_000_000
    path.write_bytes(path.read_bytes() + noise)
    with pytest.raises(RecordingError, match="badly damaged one: of its first"):
        open_log(path)
