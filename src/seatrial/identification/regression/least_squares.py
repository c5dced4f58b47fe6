# SPDX-License-Identifier: MIT
"""theta* = B \\ a with a covariance that holds for correlated residuals, Eq. (13)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

SINGULAR_CONDITION = 1e6  # of the column-scaled regressor: from here on it counts as singular
ROWS_PER_COEFFICIENT = 20  # at the least: fewer usable samples leave the residuals no freedom
ZERO_COLUMN_RMS = 1e-9  # of a regressor: below it the axis is not excited


@dataclass(frozen=True)
class LeastSquares:
    """A solved least-squares step."""

    theta: Array  # (p,)
    covariance: Array  # (p, p)
    condition: float  # of B with columns scaled to unit norm
    explained: float  # R^2 of a
    inverse: Array  # (p, n) B's pseudo-inverse


def solve_least_squares(
    B: Array,
    a: Array,
    names: Sequence[str],
    where: str,
    correlation: int,
    *,
    rows: Sequence[int] = (),
) -> LeastSquares:
    """Least squares; refuses zero columns and singular regressors, and names the coefficients.

    B (n, p), a (n,). `correlation`: samples over which residuals are correlated; the covariance is
    Newey and West's (1987) with Bartlett weights over them. `rows`: how many of the n are of each
    recording, one after the other (none: all are of one); residuals of two are not correlated.
    """
    n = len(B)
    size = np.linalg.norm(B, axis=0)
    _refuse_too_few(B, names, where)
    _refuse_zero_columns(size, n, names, where)
    scaled = B / size
    condition = _condition(scaled, names, where)
    inverse = np.linalg.pinv(scaled) / size[:, None]
    theta = inverse @ a
    residual = a - B @ theta
    spread = float(np.sum((a - a.mean()) ** 2))
    explained = 1.0 - float(residual @ residual) / spread if spread > 0 else 1.0
    covariance = _newey_west(inverse * residual, correlation, rows or (n,))
    return LeastSquares(theta, covariance, condition, explained, inverse)


def _refuse_too_few(B: Array, names: Sequence[str], where: str) -> None:
    n, p = B.shape
    if n < ROWS_PER_COEFFICIENT * p:
        raise IdentificationError(
            f"{where}: {n} usable samples for {', '.join(names)}; at least "
            f"{ROWS_PER_COEFFICIENT * p} are needed: record longer, or look for drop-outs with inspect"
        )


def _refuse_zero_columns(size: Array, n: int, names: Sequence[str], where: str) -> None:
    zero = [
        name for name, s in zip(names, size, strict=True) if not s > ZERO_COLUMN_RMS * np.sqrt(n)
    ]
    if zero:
        raise IdentificationError(
            f"{where}: {', '.join(zero)} can't be found, what multiplies it is always 0: "
            "that axis is never excited here; drive pulses in it, or take the term out"
        )


def _condition(scaled: Array, names: Sequence[str], where: str) -> float:
    """Condition number of a regressor with unit columns. Raises IdentificationError where it is singular."""
    _, singular, right = np.linalg.svd(scaled, full_matrices=False)
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0 else float("inf")
    if condition > SINGULAR_CONDITION:
        weights = np.abs(right[-1])
        tied = [n for n, w in zip(names, weights, strict=True) if w > 0.1 * weights.max()]
        raise IdentificationError(
            f"{where}: {', '.join(tied)} can't be told apart (condition number {condition:.1e}): "
            "vary speed and command independently, or take one term out"
        )
    return condition


def _newey_west(score: Array, correlation: int, rows: Sequence[int]) -> Array:
    """Covariance (p, p) from scores (p, n), `rows` of them of each recording."""
    p, n = score.shape
    covariance = score @ score.T
    for own in np.split(score, np.cumsum(rows)[:-1], axis=1):
        for lag in range(1, min(correlation, own.shape[1] - 1) + 1):
            cross = own[:, lag:] @ own[:, :-lag].T
            covariance += (1.0 - lag / (correlation + 1)) * (cross + cross.T)
    return np.asarray(covariance * n / (n - p))
