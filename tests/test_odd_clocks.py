# SPDX-License-Identifier: MIT
"""Stamps as loggers write them: whole seconds, counters, days of spreadsheets, nights between two drives."""

from datetime import datetime, timedelta

import numpy as np
import pytest

import seatrial
from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.io.tables.stamps import unwrapped
from seatrial.recording.clocks import clock_verdicts
from seatrial.recording.excitation import excitation
from tests.logs import nanoseconds
from tests.odd_logs import RATE, columns, logged, moves_as_the_boat, read, refusal


@pytest.mark.parametrize("clock", ["%d.%m.%Y %H:%M:%S", "%s"])
def test_whole_seconds(tmp_path, clock):
    """Ten rows share a stamp: they are put on an even clock, poses and commands alike."""
    c = columns(10.0)
    begin = datetime(2026, 5, 11, 12, 0, 0)
    stamps = [(begin + timedelta(seconds=float(t))).strftime(clock) for t in c["t"]]
    path = logged(tmp_path, c | {"time": stamps}, "time east north heading left right")
    recording = read(path)[1]
    assert len(recording.t) == len(stamps)
    assert any("10 rows each" in r for r in recording.remarks)
    moves_as_the_boat(recording)


@pytest.mark.parametrize(
    ("name", "stamp", "text"),
    [
        ("sample", lambda t: np.rint(RATE * t), "sample counts rows and is no time: with a known rate"),
        ("timestamp", lambda t: np.full(len(t), 1.7785e9), "timestamp has 1 different values in 2398 rows: it was rounded"),
        ("t", lambda t: t[::-1], "t falls from row to row: sort the rows by it"),
        ("t", lambda t: np.roll(t.reshape(2, -1), 1, axis=0).T.ravel(), "t goes back in 50 % of the rows: sort them by it"),
        ("time", lambda t: ["a quarter past two"] * len(t), "time has 'a quarter past two', which is not in a known format"),
    ],
)  # fmt: skip
def test_stamps_that_are_none(tmp_path, name, stamp, text):
    """What is wrong with the column that could be the stamps."""
    c = columns()
    path = logged(tmp_path, c | {name: stamp(c["t"])}, f"{name} x y yaw left right")
    assert text in refusal(path)


def test_two_drives_and_a_night_between(tmp_path):
    """The hours without commands do not count: the axes are excited."""
    c = columns()
    later = {k: np.concatenate([v, v + (50_000.0 if k == "t" else 0.0)]) for k, v in c.items()}
    path = logged(tmp_path, later)
    vehicle, recording = read(path)
    once = seatrial.read(path, vehicle).cut(None, 119.0)
    found, expected = excitation(vehicle, recording), excitation(vehicle, once)
    np.testing.assert_allclose(found.rms[[0, 2]], expected.rms[[0, 2]], rtol=0.03)


CLOCKS = {  # name of the column and its stamps of a time t [s] from the start
    "Time": lambda t: 46153.5 + t / 86_400,  # days of Excel
    "datenum": lambda t: 740113.5 + t / 86_400,  # days of MATLAB
    "ms": lambda t: np.rint(1e3 * t + 20_000) % 2**16,
    "micros": lambda t: np.rint(1e6 * t + 2**32 - 40e6) % 2**32,
    "tow": lambda t: (604_790 + t) % 604_800,  # second of the GPS week
}


@pytest.mark.parametrize("name", CLOCKS)
def test_serial_days_and_counters_that_begin_again(tmp_path, name):
    """Days of spreadsheets; a counter of 16 or 32 bits, and the GPS week, go on where they begin again."""
    c = columns()
    stamps = [f"{v:.10f}" for v in CLOCKS[name](c["t"])]
    path = logged(tmp_path, c | {name: stamps}, f"{name} x y yaw left right")
    recording = read(path)[1]
    assert len(recording.t) == len(c["t"])
    moves_as_the_boat(recording)


def test_minutes_and_seconds_of_a_spreadsheet(tmp_path):
    """Excel writes 59:59.9 and then 00:00.0, to a tenth of a second, of rows at 20 Hz."""
    c = columns()
    tenths = np.floor((3540.0 + c["t"]) * 10 + 1e-6).astype(int)
    stamps = [f"{n // 600 % 60:02}:{n // 10 % 60:02}.{n % 10}" for n in tenths.tolist()]
    recording = read(logged(tmp_path, c | {"Time": stamps}, "Time x y yaw left right"))[1]
    assert recording.duration == pytest.approx(c["t"][-1], abs=0.1)
    moves_as_the_boat(recording)


def test_a_logger_that_was_started_again(tmp_path):
    """Both parts count, poses with the commands of their part."""
    c = columns()
    again = {
        k: np.concatenate([v[:1200], v[1200:] - (v[1200] if k == "t" else 0.0)])
        for k, v in c.items()
    }
    recording = read(logged(tmp_path, again))[1]
    np.testing.assert_allclose(recording.raw[:, 0], c["east"], atol=1e-5)
    np.testing.assert_allclose(recording.commands.values[:, 0], c["left"], atol=1e-5)
    np.testing.assert_array_equal(recording.commands.stamps, recording.stamps)
    assert recording.segment[1199] < recording.segment[1200]
    assert not clock_verdicts(recording.streams)


def test_a_clock_that_starts_again_is_no_counter(tmp_path):
    """A logger that was started again does not go on."""
    t = np.array([0.0, 1.0, 2.0, 0.0, 1.0, 2.0])
    assert unwrapped(t, 1.0) is t


def pose_bag(path, pose_stamps, speed=1.0):
    """A bag: poses with these headers' stamps [ns] of t (n,) [s], commands by their arrival, played at a speed."""
    c = columns()
    arrival = nanoseconds(c["t"] * speed)
    pose = {
        "pose.position.x": c["east"], "pose.position.y": c["north"],
        "pose.orientation.z": np.sin(c["psi"] / 2), "pose.orientation.w": np.cos(c["psi"] / 2),
    }  # fmt: skip
    commands = {"data[0]": c["left"], "data[1]": c["right"]}
    return write_bag(path, [
        BagTopic("/pose", "geometry_msgs/msg/PoseStamped", arrival, pose_stamps(c["t"]), pose),
        BagTopic("/thrust", "std_msgs/msg/Float64MultiArray", arrival, arrival, commands),
    ])  # fmt: skip


def from_zero(t):
    """Stamps [ns] of simulated time."""
    return np.rint(t * 1e9).astype(np.int64)


def test_simulated_time_beside_the_clock_on_the_wall(tmp_path):
    """Headers by use_sim_time, commands by arrival: arrivals of both, where the simulation kept up."""
    vehicle, recording = read(pose_bag(tmp_path / "run.bag", from_zero))
    assert (vehicle.file.pose.clock, vehicle.file.commands.clock) == ("bag", "bag")
    moves_as_the_boat(recording)
    text = refusal(pose_bag(tmp_path / "slow.bag", from_zero, speed=1.3))
    assert (
        "commands count from 1970, those of the poses from a start: simulated time (use_sim_time)"
        in text
    )


def test_a_clock_that_is_far_behind_is_named(tmp_path):
    """Poses stamped 40 s before they arrive: no command seems to move the boat."""
    path = pose_bag(tmp_path / "run.bag", lambda t: nanoseconds(t - 40.0))
    assert (
        "messages of /pose arrive 40 s or more after their stamps: if a clock is behind"
        in refusal(path)
    )
