# SPDX-License-Identifier: MIT
"""How signals arrived: rates, gaps, order, and what their clocks say of each other."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from logs import EPOCH, nanoseconds

from seatrial.recording.timing import Clock, describe, longest_rising, only_changes, regular_period


def header(stamps, arrival, role="commands"):
    """A stream by its header stamps."""
    return describe(
        role,
        "/t",
        "T",
        clock=Clock.HEADER,
        stamps=nanoseconds(stamps),
        arrival=nanoseconds(arrival),
    )


def column(stamps):
    return describe("poses", "t.csv", "table", clock=Clock.COLUMN, stamps=nanoseconds(stamps))


# Rates, gaps and order. #


def test_rate_and_longest_step_of_a_rhythm_with_a_hole():
    t = np.arange(300) / 15.0
    stream = column(np.delete(t, np.arange(100, 130)))
    assert stream.count == 270
    assert stream.rate == pytest.approx(15.0)
    assert stream.longest == pytest.approx(31 / 15)
    assert stream.jitter == pytest.approx(0.0, abs=1e-8)
    assert (stream.duplicated, stream.backward, stream.on_change) == (0, 0, False)


@pytest.mark.parametrize("rate", [0.5, 15.0, 400.0])
def test_jitter_of_steps_is_that_of_stamps_times_root_two(rate):
    """Independent errors of two stamps make a step; a hole is not jitter."""
    sigma = 0.03 / rate
    t = np.arange(20_000) / rate + np.random.default_rng(1).normal(0.0, sigma, 20_000)
    stream = column(np.delete(np.sort(t), np.arange(500, 700)))
    assert stream.jitter == pytest.approx(np.sqrt(2) * sigma, rel=0.03)
    assert stream.rate == pytest.approx(rate, rel=0.005)


@given(
    equal=st.lists(st.integers(1, 299), unique=True, max_size=20),
    early=st.lists(st.integers(1, 149), unique=True, max_size=20),
)
def test_duplicated_and_backward_stamps_are_counted(equal, early):
    """Every second stamp may be set back, so that two faults never touch."""
    t = np.arange(300) * 0.1
    back = sorted({2 * k for k in early} - {k + d for k in equal for d in (-1, 0, 1)})
    t[back] -= 0.15
    same = sorted(k for k in equal if not {k - 1, k + 1} & set(equal))
    same = [k for k in same if not {k - 1, k, k + 1} & set(back)]
    t[same] = t[[k - 1 for k in same]]
    stream = column(t)
    assert stream.duplicated == len(same)
    assert stream.backward == len(back)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_hardly_any_messages_have_no_rate_but_no_error_either(count):
    stamps = np.arange(count) * 2.0
    stream = header(stamps, stamps + 0.01)
    assert stream.count == count
    assert stream.rate == (0.5 if count == 2 else 0.0)
    assert stream.longest == (2.0 if count == 2 else 0.0)
    assert (stream.delay is None) == (count == 0)


def test_a_joypad_that_writes_only_changes_is_told_from_one_that_writes_all_the_time():
    rng = np.random.default_rng(2)
    t = np.arange(3000) * 0.01
    moving = (t // 2.0) % 2 == 0
    assert not column(t).on_change
    assert column(np.sort(rng.choice(t[moving], 250, replace=False))).on_change
    assert regular_period(np.diff(t[:15])) is None  # too few
    assert not column(np.delete(t, np.arange(1000, 1500))).on_change  # a hole is no habit
    assert column(t * rng.uniform(0.97, 1.0)).on_change is False


# The order of stamps. #


def most_rising(stamps, strict):
    """The length of the longest rising choice, by trying all."""
    for size in range(len(stamps), 0, -1):
        for choice in combinations(stamps, size):
            steps = np.diff(choice)
            if np.all(steps > 0 if strict else steps >= 0):
                return size
    return 0


@given(st.lists(st.integers(-4, 8), min_size=1, max_size=9), st.booleans())
def test_the_longest_rising_choice_is_the_longest_there_is(stamps, strict):
    keep = longest_rising(np.array(stamps, dtype=np.int64), strict=strict)
    kept = np.array(stamps)[keep]
    assert np.all(np.diff(kept) > 0 if strict else np.diff(kept) >= 0)
    assert len(kept) == most_rising(stamps, strict)


@given(st.integers(20, 400), st.data())
def test_stray_stamps_cost_as_many_poses_as_they_are(n, data):
    stamps = nanoseconds(np.arange(n) * 0.05)
    stray = data.draw(st.lists(st.integers(0, n - 1), unique=True, max_size=n // 5))
    for k in stray:
        stamps[k] += data.draw(st.sampled_from([-1, 1])) * data.draw(
            st.integers(n * 10**8, 10**18)
        )  # further than the recording is long
    keep = longest_rising(stamps)
    good = np.setdiff1d(np.arange(n), stray)
    assert keep.sum() >= len(good)
    assert keep[good].sum() >= len(good) - len(stray)


@given(st.integers(10, 60), st.data(), st.floats(0.3, 1.9), st.sampled_from([-1, 1]), st.booleans())
def test_of_two_stamps_that_may_stay_the_one_in_rhythm_does(n, data, off, way, equal):
    """A little late or early, or sent twice: it is itself left out, not its neighbour."""
    stamps = nanoseconds(np.arange(n) * 0.05)
    odd = data.draw(st.integers(2, n - 4))
    odd_stamp = stamps[odd - 1] if equal else stamps[odd] + round(way * (1.0 + off) * 5e7)
    if not equal:  # between others, so that either could stay
        odd_stamp = stamps[odd] + way * round((1.0 + 0.4 * off) * 5e7)
    stamps[odd] = odd_stamp
    expected = np.ones(n, dtype=bool)
    expected[odd] = False
    np.testing.assert_array_equal(longest_rising(stamps), expected)


# What silence means. #


def test_bursts_at_even_times_are_a_rhythm():
    """Four thrusters, a topic each, sent one right after the other at 10 Hz."""
    t = np.sort(np.concatenate([np.arange(0, 60, 0.1) + 0.001 * k for k in range(4)]))
    assert regular_period(np.diff(t)) == pytest.approx(0.097)
    t = t[(t < 20) | (t > 25)]
    assert not only_changes(t, np.sin(t)[:, None])
    chance = np.cumsum(np.random.default_rng(5).exponential(0.1, 500))
    assert regular_period(np.diff(chance)) is None


def pulses(t, rng, rest):
    """Sticks that are pushed and let go, with some rest between."""
    sticks = np.zeros((len(t), 2))
    for axis in range(2):
        at = 0.0
        while at < t[-1]:
            length = rng.uniform(0.5, 3.0)
            inside = (t >= at) & (t < at + length)
            size = rng.choice([-1, 1]) * rng.uniform(0.3, 1.0)
            sticks[inside, axis] = size * np.sin(np.pi * (t[inside] - at) / length)
            at += length + rng.uniform(0.0, 2.0 * rest)
    return sticks


@given(
    seed=st.integers(0, 10**6),
    rest=st.sampled_from([2.0, 5.0]),
    step=st.sampled_from([0.0, 1 / 127]),
)
def test_a_joypad_that_speaks_when_it_is_moved_is_told_by_what_it_says(seed, rest, step):
    """While it is moved it keeps time, so the steps alone do not tell."""
    t = np.arange(0.0, 120.0, 0.02)
    values = pulses(t, np.random.default_rng(seed), rest)
    values = np.round(values / step) * step if step else values
    kept = np.concatenate([[True], np.any(np.diff(values, axis=0) != 0, axis=1)])
    assert only_changes(t[kept], values[kept]) or np.diff(t[kept]).max() < 0.5
    holes = np.zeros(len(t), dtype=bool)
    for begin in np.random.default_rng(seed).uniform(0.0, 117.0, 3):
        holes |= (t >= begin) & (t < begin + 2.0)
    assert not only_changes(t[~holes], values[~holes])


# Arrival against stamp. #


def sent(n=3000, rate=15.0, *, spread=0.002, seed=0):
    """Times of sending (n,) and of arrival: 3 ms of transport and something exponential."""
    t = np.arange(n) / rate
    return t, t + 0.003 + np.random.default_rng(seed).exponential(spread, n)


def test_least_median_and_most_are_those_of_the_numbers():
    t, arrival = sent()
    delay = header(t, arrival).delay
    late = arrival - t
    assert delay.least == pytest.approx(late.min(), abs=1e-8)
    assert delay.median == pytest.approx(np.median(late), abs=1e-8)
    assert delay.most == pytest.approx(late.max(), abs=1e-8)
    assert (delay.drift, delay.step) == (0.0, 0.0)


@pytest.mark.parametrize("ahead", [-5.0, -0.1, 0.02, 0.1, 3600.0])
def test_a_clock_that_is_off_moves_all_delays_alike(ahead):
    t, arrival = sent()
    right, off = header(t, arrival).delay, header(t + ahead, arrival).delay
    for name in ("least", "median", "most"):
        assert getattr(off, name) == pytest.approx(getattr(right, name) - ahead, abs=1e-7)
    assert (off.drift, off.step) == (0.0, 0.0)


@given(
    spread=st.floats(1e-4, 0.5),
    n=st.integers(2, 3000),
    rate=st.sampled_from([1.0, 15.0, 100.0]),
    seed=st.integers(0, 10**6),
    shape=st.sampled_from(["normal", "exponential", "uniform", "two"]),
)
def test_transport_alone_is_never_a_step_of_the_clock(spread, n, rate, seed, shape):
    rng = np.random.default_rng(seed)
    late = {
        "normal": rng.normal(0.0, spread, n),
        "exponential": rng.exponential(spread, n),
        "uniform": rng.uniform(0.0, spread, n),
        "two": spread * (rng.random(n) < 0.3),  # sometimes by another way
    }[shape]
    t = np.arange(n) / rate
    assert header(t, t + late).delay.step == 0.0


@given(
    stall=st.floats(0.3, 30.0),  # of 200 s
    begin=st.floats(0.0, 199.0),
    seed=st.integers(0, 10**6),
)
def test_a_queue_that_empties_late_is_no_step_of_the_clock(stall, begin, seed):
    t, arrival = sent(seed=seed)
    held = (arrival > begin) & (arrival < begin + stall)
    arrival[held] = begin + stall + 1e-4 * np.arange(held.sum())
    assert header(t, arrival).delay.step == 0.0


@given(
    size=st.sampled_from([-3600.0, -2.0, -0.3, -0.08, 0.08, 0.3, 2.0, 3600.0]),
    at=st.integers(60, 2900),  # the message, of 3000
    drift=st.sampled_from([-0.05, 0.0, 0.05]),
    seed=st.integers(0, 10**6),
)
def test_a_clock_that_is_set_is_found_with_its_time_and_size(size, at, drift, seed):
    t, arrival = sent(seed=seed)
    stamps = t + drift * t / t[-1]
    stamps[at:] += size
    delay = header(stamps, arrival).delay
    assert delay.step == pytest.approx(-size, abs=0.004)
    assert delay.step_at == pytest.approx(arrival[at] - arrival[0], abs=0.2)
    assert (delay.step_stamp - EPOCH) * 1e-9 == pytest.approx(stamps[at - 1], abs=0.2)
    assert delay.drift == pytest.approx(-0.9 * drift, abs=0.01)


@pytest.mark.parametrize("jump", [-2.0, 0.2, 2.0])
def test_a_recorder_that_is_set_changes_the_delay_the_other_way(jump):
    t, arrival = sent()
    arrival[1800:] += jump
    delay = header(t, arrival).delay
    assert delay.step == pytest.approx(jump, abs=0.004)
    assert (delay.step_stamp - EPOCH) * 1e-9 == pytest.approx(t[1799], abs=0.2)


@pytest.mark.parametrize("drift", [-30.0, -0.5, -0.02, 0.02, 0.5, 30.0])
def test_a_clock_that_drifts_does_not_step(drift):
    """Between the middles of the first and the last tenth lie nine tenths of the recording."""
    t, arrival = sent()
    delay = header(t + drift * t / t[-1], arrival).delay
    assert delay.step == 0.0
    assert delay.drift == pytest.approx(-0.9 * drift, rel=0.02, abs=0.001)


def test_a_busy_network_is_no_drift():
    """The more other traffic, the later most messages; the quickest come as before."""
    t, arrival = sent(20_000, 100.0)
    busy = np.random.default_rng(3).exponential(0.02, len(t)) * (t / t[-1])
    assert np.median((arrival + busy - t)[-2000:]) > np.median((arrival - t)[:2000]) + 0.01
    assert abs(header(t, arrival + busy).delay.drift) < 0.005


@pytest.mark.parametrize("off", [-1.7e9, -100.0, 100.0, 3e8])
def test_one_stray_stamp_says_nothing_of_the_clock(off):
    t, arrival = sent()
    right = header(t, arrival).delay
    t[1234] += off
    delay = header(t, arrival).delay
    assert (delay.least, delay.most) == pytest.approx((right.least, right.most), abs=1e-6)
    assert (delay.step, delay.drift) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (0.001, 0.0042, "1 to 4 ms before arrival"),
        (0.0, 0.0, "0 ms before arrival"),
        (-0.0182, -0.018, "18 ms after arrival"),
        (-0.03, -0.01, "10 to 30 ms after arrival"),
        (-0.03, 0.01, "30 ms after to 10 ms before arrival"),
        (12.0, 13.5, "12 to 13.5 s before arrival"),
        (-15.0, -0.5, "500 ms to 15 s after arrival"),
    ],
)
def test_a_delay_in_words(low, high, words):
    t = np.arange(30) * 0.1
    assert str(header(t, t + np.linspace(low, high, 30)).delay) == words
