# SPDX-License-Identifier: MIT
"""Whether parameters that are held deserve to be free: the score test.

One pass with their slopes, at the solution without them. What of their scores the free parameters
could not take up as well is compared with its own scatter over blocks, which holds for errors that
are correlated (White, Econometrica 50, 1982, sections 3 and 4).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from seatrial.util.frames import Array

MANIFEST = 10.0  # standard deviations of chi-square, which has far more than normal tails
LIKELY = 5.0  # the same where the likelihood promises very much: of few blocks no scatter is sharp
MUCH = 100.0  # fall of -2 log likelihood that is very much


@dataclass(frozen=True)
class ScoreTest:
    """What the data say of parameters at their neutral values."""

    statistic: float  # chi-square with `freedom` degrees where they are neutral
    freedom: int
    gain: float  # fall of -2 log likelihood that freeing them promises
    step: Array  # (k,) that they would take

    @property
    def manifest(self) -> bool:
        """Beyond chance: of one parameter about 1 in 10 000, of more less."""
        return self._beyond(MANIFEST)

    @property
    def likely(self) -> bool:
        """The same, or about 1 in 200 where the likelihood promises very much, too."""
        return self._beyond(LIKELY if self.gain > MUCH else MANIFEST)

    def _beyond(self, times: float) -> bool:
        return bool(self.statistic > self.freedom + times * np.sqrt(2.0 * self.freedom))


class Scored(Protocol):
    """Passes, or what is as good as they."""

    @property
    def information(self) -> Array:
        """Fisher's (p, p)."""

    @property
    def scores(self) -> Array:
        """Terms (blocks, p) of the log likelihood's gradient."""


def score_test(
    passes: Scored,
    tested: list[int],
    together: list[int] | None = None,
    neutral: Sequence[int] = (),
) -> ScoreTest:
    """Of the free parameters at places `tested`; the others' own scores must have been solved for.

    `together`: parameters that were one, of which the first stands for all and the others, among
    those tested, for their differences from it. `neutral`: parameters that stay where they are.
    """
    p = len(passes.information)
    change = np.eye(p)
    if together:
        change[together, together[0]] = 1.0
    information = change.T @ passes.information @ change
    rest = [i for i in range(p) if i not in tested and i not in neutral]
    held = np.linalg.pinv(information[np.ix_(rest, rest)], hermitian=True)
    through = information[np.ix_(tested, rest)] @ held
    sums = passes.scores @ change
    efficient = sums[:, tested] - sums[:, rest] @ through.T
    total = efficient.sum(axis=0)
    left = information[np.ix_(tested, tested)] - through @ information[np.ix_(rest, tested)]
    inverse = np.linalg.pinv(left, hermitian=True)
    scatter = efficient.T @ efficient
    raw = float(total @ np.linalg.pinv(scatter, hermitian=True) @ total)
    statistic = _as_chi_square(raw, len(sums), len(tested))
    return ScoreTest(statistic, len(tested), float(total @ inverse @ total), inverse @ total)


def _as_chi_square(raw: float, blocks: int, freedom: int) -> float:
    """The statistic of so many blocks as that of many: of few it can't exceed their number.

    Over it, it is a squared multiple correlation, of 1 with the scores (Bartlett, J. R. Stat. Soc.
    Suppl. 9, 1947). 0 where there are too few blocks to tell.
    """
    if blocks <= freedom + 1:
        return 0.0
    left = max(1.0 - raw / blocks, np.finfo(float).eps)
    return float(-(blocks - 0.5 * freedom - 1.0) * np.log(left))
