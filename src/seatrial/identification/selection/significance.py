# SPDX-License-Identifier: MIT
"""Wald test of a coefficient, and homogeneity of its estimates over the repeats."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.identification.selection.score_information import ScoreInformation, solve_scaled
from seatrial.recording.recording import Recording
from seatrial.util.distributions import chi2_sf, student_two_sided
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array
from seatrial.util.statistics import BLOCK


@dataclass(frozen=True)
class Estimate:
    """A coefficient, its standard error, and its p-value under the hypothesis that it is 0."""

    value: float
    error: float
    p: float

    @property
    def z(self) -> float:
        """Value in standard errors."""
        return self.value / self.error if self.error > 0 else 0.0


@dataclass(frozen=True)
class Repeats:
    """A coefficient estimated from each fold, all others being common."""

    values: Array  # (folds,)
    errors: Array  # (folds,)
    p: float  # p-value of the spread if the boat is the same
    between: float  # standard deviation between folds, beyond that of their errors
    ratio: float  # spread over its expectation: about 1 where repeats agree


class TooShortError(IdentificationError):
    """Recordings that are too short to test terms."""


def least_length(recordings: Sequence[Recording], fitted: int) -> float:
    """Seconds of recordings that tests with so many fitted parameters need, where these are too short."""
    return 2.0 * BLOCK * max(fitted, blocks_of(recordings) // 2 + 1)


def enough_blocks(recordings: Sequence[Recording], fitted: int) -> bool:
    """Whether recordings have the blocks of `BLOCK` [s] that a test with so many fitted parameters needs."""
    return blocks_of(recordings) >= 2 * fitted


def usable_time(recordings: Sequence[Recording]) -> float:
    """Seconds of recordings, without blocks of `BLOCK` [s] in which no pose is usable."""
    blocks = sum(len(np.unique(r.t[r.valid] // BLOCK)) for r in recordings)
    return min(sum(r.duration for r in recordings), BLOCK * blocks)


def blocks_of(recordings: Sequence[Recording]) -> int:
    """Number of blocks of `BLOCK` [s] with usable poses."""
    return math.ceil(usable_time(recordings) / BLOCK)


def freedom(blocks: int, fitted: int) -> int:
    """Degrees of freedom of blocks of `BLOCK` [s]. Raises where there are too few."""
    left = blocks - fitted
    if left < fitted:
        raise TooShortError(
            f"{blocks * BLOCK:.0f} s in all, in blocks of {BLOCK:.0f} s, are too short to test terms of "
            f"{fitted} parameters or more; give recordings of {2 * fitted * BLOCK:.0f} s or more together"
        )
    return left


def estimate(information: ScoreInformation, name: str) -> Estimate:
    """One coefficient after a Gauss-Newton step of all parameters.

    Its error is the larger of Fisher's and the sandwich's over blocks: the first assumes the noise model, the
    second many blocks.
    """
    j, p = information.place(name), len(information.names)
    unit = np.zeros(p)
    unit[j] = 1.0
    row = solve_scaled(information.information, unit)
    step = solve_scaled(information.information, information.gradient.sum(axis=0))
    value = information.values[j] + step[j]
    left = freedom(information.blocks, p - 1)
    influence = information.scores_after(step) @ row
    sandwich = float(np.sum(influence**2)) * information.blocks / left
    error = float(np.sqrt(max(sandwich, row[j])))
    return Estimate(float(value), error, student_two_sided(value / error, left))


def repeats(information: ScoreInformation, name: str, folds: Sequence[Sequence[int]]) -> Repeats:
    """One coefficient from each fold (indices of its recordings), the others from all together."""
    j, k = information.place(name), len(folds)
    rest = [i for i in range(len(information.names)) if i != j]
    n = len(rest)
    matrix, right = np.zeros((n + k, n + k)), np.zeros(n + k)
    matrix[:n, :n] = information.information[np.ix_(rest, rest)]
    right[:n] = information.gradient.sum(axis=0)[rest]
    for f, members in enumerate(folds):
        at = list(members)
        cross = information.of_recordings[at].sum(axis=0)[j]
        matrix[n + f, :n] = matrix[:n, n + f] = cross[rest]
        matrix[n + f, n + f] = cross[j]
        right[n + f] = information.gradient[at, j].sum()
    step = solve_scaled(matrix, right)
    rows = solve_scaled(matrix, np.vstack([np.zeros((n, k)), np.eye(k)]))  # (n + k, k)
    influence = np.zeros((information.blocks, k))
    for f, members in enumerate(folds):
        own = np.insert(step[:n], j, step[n + f])
        mine = np.isin(information.recording, list(members))
        influence[mine] = (
            information.scores_after(own) @ np.insert(rows[:n], j, rows[n + f], axis=0)
        )[mine]
    sandwich = influence.T @ influence * information.blocks / freedom(information.blocks, n + 1)
    return _spread(information.values[j] + step[n:], _larger(sandwich, rows[n:]))


def _larger(sandwich: Array, fisher: Array) -> Array:
    """Correlations of the sandwich with the larger of both errors."""
    errors = np.sqrt(np.maximum(np.diag(sandwich), np.diag(fisher)))
    own = np.sqrt(np.diag(sandwich)) + np.finfo(float).tiny
    return np.asarray(sandwich * np.outer(errors / own, errors / own))


def _spread(values: Array, covariance: Array) -> Repeats:
    """Cochran's Q over contrasts with the first fold; spread as DerSimonian and Laird (1986)."""
    k = len(values)
    contrast = np.hstack([-np.ones((k - 1, 1)), np.eye(k - 1)])
    apart = contrast @ values
    q = float(apart @ np.linalg.solve(contrast @ covariance @ contrast.T, apart))
    errors = np.sqrt(np.diag(covariance))
    weight = 1.0 / errors**2
    scale = weight.sum() - (weight**2).sum() / weight.sum()
    excess = max(0.0, q - (k - 1))
    # a fold without information about it leaves no scale
    between = float(np.sqrt(excess / scale)) if excess > 0.0 and scale > 0.0 else 0.0
    return Repeats(values, errors, chi2_sf(q, k - 1), between, float(np.sqrt(q / (k - 1))))
