# SPDX-License-Identifier: MIT
"""Stamps that go back or astray, and poses of two robots under one name."""

import numpy as np
import pytest
from conftest import trials
from recording_tools import COMMANDS, kinds, poses

from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import rising
from seatrial.util.errors import RecordingError

# Stamps. #

EPOCH = 1_700_000_000 * 10**9  # [ns]


@pytest.mark.parametrize("where", [0, 1, 300, 598, 599])
@pytest.mark.parametrize("off", [-1.7e9, -1e8, -60.0, 1e8, 9e8], ids=lambda s: f"{s:g} s")
def test_a_stray_stamp_costs_one_pose(where, off):
    stamps, eta = poses()
    stamps += EPOCH
    stamps[where] += round(off * 1e9)
    record = make_recording("stray", stamps, eta, COMMANDS)
    if where < 2 and off == -60.0:  # it might have been the first pose, a minute before the others
        assert len(record.t) == 600 - where
        assert record.t[1] == pytest.approx(60.0, abs=0.1)
        return
    good = np.delete(np.arange(600), where)
    np.testing.assert_array_equal(record.stamps, stamps[good])
    np.testing.assert_array_equal(record.eta, eta[good])
    assert record.duration == pytest.approx(40.0, abs=0.15)
    (stray,) = [f for f in record.faults if f.kind is FaultKind.STAMP]
    assert stray.samples == 1
    assert record.usable == pytest.approx(599 / 600)


def test_a_clock_without_a_battery_costs_the_poses_before_it_was_set():
    """A single-board computer begins in 1970 until it hears the time."""
    stamps, eta = poses()
    stamps[150:] += EPOCH
    record = make_recording("1970", stamps, eta, COMMANDS)
    np.testing.assert_array_equal(record.stamps, stamps[150:])
    assert record.duration == pytest.approx(449 / 15, abs=1e-6)


@pytest.mark.parametrize("back", [0.5, 3.0])
def test_a_clock_set_back_in_the_middle_costs_the_time_that_comes_twice(back):
    stamps, eta = poses()
    stamps[400:] -= round(back * 1e9)
    most = max(k + np.sum(stamps[400:] > stamps[k - 1]) for k in range(1, 401))
    assert most == 600 - int(back * 15)
    record = make_recording("set back", stamps, eta, COMMANDS)
    assert len(record.stamps) == most
    assert np.all(np.diff(record.stamps) > 0)
    lost = [f for f in record.faults if f.kind is FaultKind.STAMP]
    assert sum(f.samples for f in lost) == 600 - most
    kept = np.isin(stamps, record.stamps)  # times that come twice may be of either pass
    assert kept[: 400 - round(back * 15)].all()
    assert kept[400 + round(back * 15) :].all()


# Two robots on one topic. #


@pytest.mark.parametrize("every", [2, 3, 4, 7])
@pytest.mark.parametrize("apart", [0.5, 3.0, 40.0])
@pytest.mark.parametrize("rate", [10.0, 60.0])
def test_two_robots_on_one_topic_are_refused(every, apart, rate):
    n = round(80 * rate)
    stamps, eta = poses(n, rate, noise=0.002)
    other = np.roll(poses(n, rate, noise=0.002, seed=1)[1], 500, axis=0)
    other += [apart, 0.0, 1.0]
    mixed = np.where((np.arange(n) % every == 0)[:, None], other, eta)
    with pytest.raises(RecordingError, match="are two robots, or two sources of poses") as refused:
        make_recording("two", stamps, mixed, COMMANDS)
    assert "two: " in str(refused.value)
    assert "Record them separately" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_two_robots_that_publish_when_they_like_are_refused():
    stamps, eta = poses(1200, noise=0.002)
    theirs = np.random.default_rng(6).random(1200) < 0.3
    mixed = np.where(theirs[:, None], np.add(eta[::-1], [2.0, 1.0, 0.0]), eta)
    with pytest.raises(RecordingError, match="leap by about"):
        make_recording("two", stamps, mixed, COMMANDS)


@pytest.mark.parametrize("rate", [1.0, 2.0, 5.0, 15.0])
@pytest.mark.parametrize("speed", [0.2, 1.0, 5.0])
@pytest.mark.parametrize("rest", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_a_fast_boat_that_rests_between_is_one_robot(rate, speed, rest, scale):
    """Also if it is recorded in mm, and read as m."""
    t = np.arange(round(300 * rate)) / rate
    way = np.cumsum((t % 20.0) >= 20.0 * rest) / rate * speed
    noise = np.random.default_rng(7).normal(0.0, 0.002, (len(t), 3))
    square = np.column_stack([np.abs(way % 40 - 20), np.abs((way + 10) % 40 - 20), way / 20])
    circle = np.column_stack([5 * np.cos(way / 5), 5 * np.sin(way / 5), way / 5])
    stamps = np.rint(t * 1e9).astype(np.int64)
    for eta in (square, circle):
        make_recording("fast", stamps, (eta + noise) * [scale, scale, 1.0], COMMANDS)


@pytest.fixture(scope="module")
def hard(mp):
    return trials("hard", mp)


@pytest.mark.parametrize("scale", [1.0, 1000.0])
@pytest.mark.parametrize("every", [1, 5, 15])
def test_noisy_trials_and_the_model_ship_are_one_robot(scale, every, hard, cse1):
    for trial in hard.values():
        part = slice(None, None, every)
        eta = trial.pose[part] * [scale, scale, 1.0]
        make_recording(trial.name, trial.pose_stamps[part], eta, trial.recording.commands)
    for record in cse1.values():
        eta = record.raw[::every] * [scale, scale, 1.0]
        make_recording(record.name, record.stamps[::every], eta, record.commands)


def test_stamps_that_go_back_are_left_out():
    stamps, eta = poses()
    stamps[100] = stamps[90]
    record = make_recording("back", stamps, eta, COMMANDS)
    assert FaultKind.STAMP in kinds(record)
    assert np.all(np.diff(record.stamps) > 0)
    assert len(record.stamps) == 599


def test_rising_keeps_the_last_of_equal_stamps_and_drops_late_ones():
    assert rising(np.array([1, 2, 2, 1, 3])).tolist() == [True, False, True, False, True]
