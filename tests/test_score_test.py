# SPDX-License-Identifier: MIT
"""Score tests: which are likely, and factors that change over blocks, beside a regression written out."""

import numpy as np
import pytest
from scipy import stats

from seatrial.identification.selection.score_information import ScoreInformation
from seatrial.identification.selection.score_test import (
    LARGE_GAIN,
    LIKELY_DEVIATIONS,
    SIGNIFICANT_DEVIATIONS,
    ScoreTest,
    score_test,
    score_test_after_step,
)

BLOCKS, ROWS = 40, 30


def with_statistic(statistic, gain, freedom=1):
    return ScoreTest(statistic, freedom, gain, np.zeros(freedom))


def test_a_small_gain_needs_a_clearer_statistic():
    few, many = (
        1.0 + deviations * np.sqrt(2.0)
        for deviations in (LIKELY_DEVIATIONS, SIGNIFICANT_DEVIATIONS)
    )
    assert not with_statistic(few + 0.1, LARGE_GAIN).likely
    assert with_statistic(few + 0.1, LARGE_GAIN + 1.0).likely
    assert with_statistic(many + 0.1, 1.0).likely
    assert not with_statistic(many + 0.1, 1.0, freedom=4).likely


@pytest.fixture
def regression():
    """Rows (blocks, rows, 3) of a regression with unit noise, and their residuals at the best coefficients."""
    rng = np.random.default_rng(5)
    rows = rng.normal(size=(BLOCKS, ROWS, 3))
    theta = np.array([2.0, -1.0, 0.5])
    y = rows @ theta + rng.normal(size=(BLOCKS, ROWS))
    flat = rows.reshape(-1, 3)
    best = np.linalg.lstsq(flat, y.ravel(), rcond=None)[0]
    return rows, best, y - rows @ best


def information_of(rows, best, residuals):
    shares = np.einsum("bri,brj->bij", rows, rows)
    scores = np.einsum("bri,br->bi", rows, residuals)
    owner = np.repeat([0, 1], BLOCKS // 2)
    of_recordings = np.array([shares[owner == g].sum(axis=0) for g in (0, 1)])
    gradient = np.array([scores[owner == g].sum(axis=0) for g in (0, 1)])
    names = tuple("abcdefgh"[: rows.shape[2]])
    bounds = np.full(len(names), -np.inf), np.full(len(names), np.inf)
    return ScoreInformation(names, best, bounds, of_recordings, gradient, scores, shares, owner)


def test_a_factor_with_a_course_is_a_further_regressor(regression):
    rows, best, residuals = regression
    weights = np.array([best[0], 0.0, best[2]])  # a factor on two of three coefficients
    courses = np.column_stack([np.arange(BLOCKS) < 20, np.linspace(-1.0, 1.0, BLOCKS)]).astype(
        float
    )
    further = (rows @ weights)[:, :, None] * courses[:, None, :]
    want = information_of(
        np.concatenate([rows, further], axis=2), np.append(best, [0.0, 0.0]), residuals
    )
    got = information_of(rows, best, residuals).with_courses(weights, courses)
    for field in ("of_recordings", "gradient", "scores", "shares", "values", "information"):
        np.testing.assert_allclose(getattr(got, field), getattr(want, field), rtol=1e-9, atol=1e-9)
    assert len(got.names) == 5 and np.isinf(got.bounds[1][3:]).all()


def test_gain_and_step_are_those_of_the_regression_with_it(regression):
    rows, best, residuals = regression
    courses = np.linspace(-1.0, 1.0, BLOCKS)[:, None]
    residuals = residuals + 0.2 * courses * (rows @ best)  # it drifts
    known = information_of(rows, best, residuals)
    flat = rows.reshape(-1, 3)
    move = np.linalg.lstsq(flat, residuals.ravel(), rcond=None)[0]  # to the best without it
    residuals = residuals - rows @ move
    known = information_of(rows, best, residuals).with_courses(best, courses)
    whole = np.concatenate([rows, (courses * (rows @ best))[:, :, None]], axis=2).reshape(-1, 4)
    step, (left,) = np.linalg.lstsq(whole, residuals.ravel(), rcond=None)[:2]
    for found in (score_test(known, [3]), score_test_after_step(known, 3)):
        assert found.step[0] == pytest.approx(step[3])
        assert found.step[0] == pytest.approx(0.2, abs=0.1)
        assert found.gain == pytest.approx(float(np.sum(residuals**2) - left))
        assert found.freedom == 1


def test_a_plain_effect_that_few_blocks_have_is_no_scatter_after_its_step(regression):
    """As a boat's current, whose score is large only where the boat is fast and turns."""
    rows, best, _ = regression
    rng = np.random.default_rng(8)
    sizes = np.full(BLOCKS, 0.1)
    sizes[::10] = 3.0
    lacking = rng.normal(size=(BLOCKS, ROWS)) * sizes[:, None]
    y = rows @ best + 2.0 * lacking + rng.normal(size=(BLOCKS, ROWS))
    flat = rows.reshape(-1, 3)
    without = np.linalg.lstsq(flat, y.ravel(), rcond=None)[0]
    whole = np.concatenate([rows, lacking[:, :, None]], axis=2)
    known = information_of(whole, np.append(without, 0.0), y - rows @ without)
    plain, after = (score_test(known, [3], after_step=option) for option in (False, True))
    assert (after.gain, after.step[0]) == pytest.approx((plain.gain, plain.step[0]))
    assert not plain.likely
    assert after.likely
    # the scatter is that of the residuals of the regression with it
    every = whole.reshape(-1, 4)
    theta = np.linalg.lstsq(every, y.ravel(), rcond=None)[0]
    along = lacking - rows @ np.linalg.lstsq(flat, lacking.ravel(), rcond=None)[0]
    left = np.sum(along * (y - whole @ theta), axis=1)
    total = float(np.sum(along * (y - rows @ without)))
    expected = (BLOCKS - 1.5) * np.log1p(total**2 / float(left @ left) / BLOCKS)
    assert after.statistic == pytest.approx(expected)


def test_all_statistics_are_chi_square_where_nothing_is_missing():
    """Of 400 regressions with 80 blocks; beyond the 5 % quantile are 5 %."""
    rng = np.random.default_rng(3)
    course = np.linspace(-1.0, 1.0, 80)[:, None]
    beyond = np.zeros(3)
    for _ in range(400):
        rows, noise = rng.normal(size=(80, 4, 1)), rng.normal(size=(80, 4))
        best = float(np.sum(rows[:, :, 0] * noise) / np.sum(rows**2))
        scores = np.sum(rows[:, :, 0] * (noise - rows[:, :, 0] * best), axis=1)[:, None]
        shares = np.sum(rows**2, axis=1)[:, :, None]
        free = np.full(1, np.inf)
        known = ScoreInformation(
            ("a",), np.ones(1), (-free, free), shares.sum(axis=0)[None], scores.sum(axis=0)[None], scores, shares,
            np.zeros(80, dtype=int),
        ).with_courses(np.ones(1), course)  # fmt: skip
        tests = (
            score_test(known, [1]),
            score_test(known, [1], after_step=True),
            score_test_after_step(known, 1),
        )
        for i, found in enumerate(tests):
            beyond[i] += found.statistic > stats.chi2.isf(0.05, 1)
    assert (np.abs(beyond / 400 - 0.05) < 0.03).all()
