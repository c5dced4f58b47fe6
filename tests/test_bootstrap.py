# SPDX-License-Identifier: MIT
"""Intervals of RMS values against known truths, on errors that are correlated as real ones do."""

import numpy as np
import pytest
from conftest import at_length
from scipy.signal import lfilter

from seatrial.util.block_bootstrap import block_length, block_sums, correlation_time, ratio_interval

N = 3000


def lasting(rng, n, tau):
    """Autoregressive, standard deviation 1, correlated over tau samples."""
    phi = np.exp(-1 / tau)
    return lfilter([np.sqrt(1 - phi**2)], [1, -phi], rng.normal(size=n + int(10 * tau)))[-n:]


def overlapping(rng, n, k):
    """As of k-step predictions from every sample."""
    return np.convolve(rng.normal(size=n + k - 1), np.ones(k) / np.sqrt(k), "valid")


def interval(errors, steps, length=None):
    squares, index = errors[:, None] ** 2, np.arange(len(errors))
    length = block_length(squares, index, steps) if length is None else length
    sums = block_sums(np.column_stack([squares, np.ones(len(errors))]), index, length)
    return np.sqrt(ratio_interval(sums[:, :1], sums[:, 1:]))[0]


@pytest.mark.system
@pytest.mark.parametrize(
    ("make", "steps"),
    [
        pytest.param(lambda r: overlapping(r, N, 15), 15, id="1 s ahead"),
        at_length(lambda r: overlapping(r, N, 75), 75, id="5 s ahead"),
        at_length(lambda r: lasting(r, N, 30), 15, id="what a model leaves out"),
    ],
)  # fmt: skip
def test_nineteen_of_twenty_intervals_hold_the_true_rms(make, steps):
    rng = np.random.default_rng(0)
    hits, naive = [], []
    for _ in range(250):
        errors = make(rng)
        low, high = interval(errors, steps)
        hits.append(low <= 1.0 <= high)
        low, high = interval(errors, steps, length=1)
        naive.append(low <= 1.0 <= high)
    assert 0.9 <= np.mean(hits) <= 0.98
    assert np.mean(naive) < 0.75  # single samples are not independent


def test_the_interval_of_white_errors_has_the_width_of_theory():
    """The logarithm of the RMS of n normal errors has a standard deviation of 1 / sqrt(2 n)."""
    rng = np.random.default_rng(1)
    widths = [np.diff(np.log(interval(rng.normal(size=N), 1)))[0] for _ in range(50)]
    assert np.mean(widths) == pytest.approx(2 * 1.96 / np.sqrt(2 * N), rel=0.1)


def test_two_models_with_the_same_errors_do_not_differ_and_others_do():
    """Errors share most of what makes them: a paired comparison sees a twentieth."""
    rng = np.random.default_rng(2)
    false, true = [], []
    for _ in range(200):
        common = lasting(rng, N, 10)
        a, b = (common + 0.3 * lasting(rng, N, 10) for _ in range(2))
        squares = np.column_stack([a**2, b**2, (0.92 * a) ** 2])
        index = np.arange(N)
        sums = block_sums(squares, index, block_length(squares, index, 15))
        pairs = ratio_interval(sums[:, [0, 2]], sums[:, [1, 1]])
        false.append(not pairs[0, 0] <= 1 <= pairs[0, 1])
        true.append(pairs[1, 1] < 1)
    assert np.mean(false) == pytest.approx(0.05, abs=0.04)
    assert np.mean(true) > 0.7


def test_the_correlation_time_is_that_of_the_closed_form():
    rng = np.random.default_rng(3)
    x = lasting(rng, 400_000, 20)
    rho = np.exp(-2 / 20)  # of the squares
    found = correlation_time(x[:, None] ** 2, np.arange(len(x)))
    assert found == pytest.approx((1 + rho) / (1 - rho), rel=0.1)


def test_gaps_make_no_blocks_and_too_few_blocks_no_interval():
    index = np.concatenate([np.arange(500), np.arange(500) + 5000])
    sums = block_sums(np.ones((1000, 1)), index, 100)
    assert sums[:, 0].tolist() == [100.0] * 10
    assert block_sums(np.ones((500, 1)), np.arange(500), 100) is None


def test_the_same_data_give_the_same_interval():
    errors = lasting(np.random.default_rng(4), N, 10)
    assert interval(errors, 15).tolist() == interval(errors.copy(), 15).tolist()
