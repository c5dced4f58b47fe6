# SPDX-License-Identifier: MIT
"""theta* = B \\ a with a covariance that holds for correlated residuals, Eq. (13)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

SINGULAR = 1e6  # condition of the column-scaled regressor from which on it counts as singular
ROWS_PER_COEFFICIENT = 20  # fewer rows than this are no recording


@dataclass(frozen=True)
class Fit:
    """A solved least-squares step."""

    theta: Array  # (p,)
    covariance: Array  # (p, p)
    condition: float  # of B with columns scaled to unit norm
    explained: float  # R^2 of a
    inverse: Array  # (p, n) B's pseudo-inverse


def solve(
    B: Array,
    a: Array,
    names: Sequence[str],
    where: str,
    correlation: int,
    *,
    rows: Sequence[int] = (),
) -> Fit:
    """Least squares; refuses dead columns and singular regressors, saying which.

    B (n, p), a (n,). `correlation`: samples over which residuals are correlated; the covariance is
    Newey and West's (1987) with Bartlett weights over them. `rows`: how many of the n are of each
    recording, one after the other (none: all are of one); residuals of two are not correlated.
    """
    n, p = B.shape
    if n < ROWS_PER_COEFFICIENT * p:
        raise IdentificationError(
            f"{where}: {n} usable samples for {', '.join(names)}; at least "
            f"{ROWS_PER_COEFFICIENT * p} are needed: record longer, or look for drop-outs with inspect"
        )
    size = np.linalg.norm(B, axis=0)
    dead = [name for name, s in zip(names, size, strict=True) if not s > 1e-9 * np.sqrt(n)]
    if dead:
        raise IdentificationError(
            f"{where}: {', '.join(dead)} can't be found, what multiplies it is always 0: "
            "that axis is never excited here; drive pulses in it, or take the term out"
        )
    scaled = B / size
    _, singular, right = np.linalg.svd(scaled, full_matrices=False)
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0 else float("inf")
    if condition > SINGULAR:
        weights = np.abs(right[-1])
        tied = [n for n, w in zip(names, weights, strict=True) if w > 0.1 * weights.max()]
        raise IdentificationError(
            f"{where}: {', '.join(tied)} can't be told apart (condition number {condition:.1e}): "
            "vary speed and command independently, or take one term out"
        )
    inverse = np.linalg.pinv(scaled) / size[:, None]
    theta = inverse @ a
    residual = a - B @ theta
    spread = float(np.sum((a - a.mean()) ** 2))
    explained = 1.0 - float(residual @ residual) / spread if spread > 0 else 1.0
    covariance = _newey_west(inverse * residual, correlation, rows or (n,))
    return Fit(theta, covariance, condition, explained, inverse)


def _newey_west(score: Array, correlation: int, rows: Sequence[int]) -> Array:
    """Of scores (p, n), `rows` of them of each recording."""
    p, n = score.shape
    covariance = score @ score.T
    for own in np.split(score, np.cumsum(rows)[:-1], axis=1):
        for lag in range(1, min(correlation, own.shape[1] - 1) + 1):
            cross = own[:, lag:] @ own[:, :-lag].T
            covariance += (1.0 - lag / (correlation + 1)) * (cross + cross.T)
    return np.asarray(covariance * n / (n - p))
