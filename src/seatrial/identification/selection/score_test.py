# SPDX-License-Identifier: MIT
"""Score test of parameters that are held at a neutral value: do the data ask for another one?

One filter run with sensitivities to them, at the solution without them. The part of their scores that the free
parameters do not explain is compared with its scatter over blocks, which holds for correlated innovations
(White, Econometrica 50, 1982, sections 3 and 4).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.identification.likelihood.filter_runs import FilterRuns
from seatrial.identification.selection.score_information import ScoreInformation
from seatrial.util.frames import Array

# Standard deviations of chi-square above its mean; its tails are much longer than a normal distribution's.
SIGNIFICANT_DEVIATIONS = 10.0
# where the likelihood gains very much: the scatter of few blocks is uncertain
LIKELY_DEVIATIONS = 5.0
LARGE_GAIN = 100.0  # fall of -2 log likelihood that is very much
REPORTED_GAIN = 20.0  # the same: with less an effect or a change is not reported


@dataclass(frozen=True)
class ScoreTest:
    """The test of parameters against their neutral values."""

    statistic: float  # chi-square with `freedom` degrees under the null hypothesis
    freedom: int
    gain: float  # expected fall of -2 log likelihood if they are free
    step: Array  # (k,) Gauss-Newton step that they would take

    @property
    def likely(self) -> bool:
        """Beyond chance: about 1 in 10 000 for one parameter, 1 in 200 where the likelihood gains very much."""
        deviations = LIKELY_DEVIATIONS if self.gain > LARGE_GAIN else SIGNIFICANT_DEVIATIONS
        return beyond_chance(self.statistic, self.freedom, deviations)

    @property
    def reported(self) -> bool:
        """Whether it is worth a sentence: beyond chance, and the likelihood gains enough."""
        return self.likely and self.gain >= REPORTED_GAIN


def beyond_chance(statistic: float, freedom: int, deviations: float = LIKELY_DEVIATIONS) -> bool:
    """Whether a chi-square statistic is so many standard deviations above its mean under the null hypothesis."""
    return bool(statistic > freedom + deviations * math.sqrt(2.0 * freedom))


def score_test(
    runs: FilterRuns | ScoreInformation,
    tested: list[int],
    together: list[int] | None = None,
    neutral: Sequence[int] = (),
    *,
    after_step: bool = False,
) -> ScoreTest:
    """The test of the free parameters with indices `tested`, the others being at the likelihood's maximum.

    `together`: parameters that had one common value; the first stands for it, the others, which are among those
    tested, for their differences from it. `neutral`: parameters that are neither free nor tested. `after_step`:
    the scatter is that after the step, as a plain effect's scores differ by the information in the blocks.
    """
    # differences from a common value as parameters of their own
    p = len(runs.information)
    change = np.eye(p)
    if together:
        change[together, together[0]] = 1.0
    information = change.T @ runs.information @ change
    # efficient scores: what the free parameters can not explain
    rest = [i for i in range(p) if i not in tested and i not in neutral]
    held = np.linalg.pinv(information[np.ix_(rest, rest)], hermitian=True)
    through = information[np.ix_(tested, rest)] @ held
    sums = runs.scores @ change
    efficient = sums[:, tested] - sums[:, rest] @ through.T
    total = efficient.sum(axis=0)
    left = information[np.ix_(tested, tested)] - through @ information[np.ix_(rest, tested)]
    inverse = np.linalg.pinv(left, hermitian=True)
    # chi-square by the scatter over blocks; gain and step by the information
    step = inverse @ total
    if after_step:
        direction = np.zeros((p, len(tested)))  # the free parameters follow
        direction[tested], direction[rest] = np.eye(len(tested)), -through.T
        direction = change @ direction
        efficient = efficient - (runs.shares @ (direction @ step)) @ direction
    scatter = efficient.T @ efficient
    raw = float(total @ np.linalg.pinv(scatter, hermitian=True) @ total)
    if after_step:  # without the mean of the scores
        raw /= 1.0 + raw / len(sums)
    statistic = _as_chi_square(raw, len(sums), len(tested))
    return ScoreTest(statistic, len(tested), float(total @ step), step)


def score_test_after_step(runs: ScoreInformation, tested: int) -> ScoreTest:
    """The test of one parameter, by the scatter of the scores after its step, which removes their mean.

    As many blocks as there are parameters carry no information on the scatter.
    """
    information = runs.information
    rest = [i for i in range(len(information)) if i != tested]
    held = np.linalg.pinv(information[np.ix_(rest, rest)], hermitian=True)
    direction = np.zeros(len(information))  # the others follow
    direction[rest], direction[tested] = -held @ information[rest, tested], 1.0
    total = float(runs.scores.sum(axis=0) @ direction)
    step = total / float(direction @ information @ direction)
    after = runs.scores_after(step * direction) @ direction
    n = len(after)
    statistic = total**2 / float(after @ after) * max(n - len(rest) - 1, 0) / n
    return ScoreTest(statistic, 1, total * step, np.array([step]))


def _as_chi_square(raw: float, blocks: int, freedom: int) -> float:
    """The statistic corrected for few blocks, whose raw value is at most their number.

    raw / blocks is a squared multiple correlation, of 1 with the scores (Bartlett, J. R. Stat. Soc.
    Suppl. 9, 1947). 0 where there are too few blocks for a test.
    """
    if blocks <= freedom + 1:
        return 0.0
    left = max(1.0 - raw / blocks, np.finfo(float).eps)
    return float(-(blocks - 0.5 * freedom - 1.0) * np.log(left))
