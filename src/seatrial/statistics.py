# SPDX-License-Identifier: MIT
"""Small statistics of prediction errors."""

import numpy as np
from numpy.typing import NDArray

from seatrial.frames import Array

NORMAL_95 = 1.959964  # two-sided 95 % quantile of the normal distribution


def kurtosis(errors: Array) -> float:
    """Fourth standardised moment: 3 for a normal distribution, more with heavy tails."""
    centred = errors - errors.mean()
    variance = float(np.mean(centred**2))
    return float(np.mean(centred**4)) / variance**2 if variance > 0 else float("nan")


def autocorrelation(errors: Array, index: NDArray[np.int64], lags: int) -> Array:
    """Normalised autocorrelation (lags + 1,) of errors (m,) that stand at samples `index` (m,).

    Pairs are formed only between samples that are exactly the lag apart, so that gaps drop out.
    """
    series, there = _on_grid(errors - errors.mean(), index)
    sums, pairs = _lagged(series, series, lags)[0], _lagged(there, there, lags)[0]
    rho = np.zeros(lags + 1)
    if sums[0] > 0:
        rho = np.where(pairs > 0.5, sums / np.maximum(pairs, 1.0), 0.0) * pairs[0] / sums[0]
    rho[0] = 1.0
    return rho


def cross_correlation(x: Array, y: Array, lags: int) -> tuple[Array, float]:
    """Correlation (2 lags + 1,) of x[i] with y[i - lag], lag from -lags to lags; its 95 % band.

    x (n,), y (n,) on one even grid; NaN where there is no sample. At positive lags x follows y.
    The band holds for two signals that have nothing to do with each other, however each of them is
    correlated with itself: var = sum of rho_x(j) rho_y(j) over all j, / n (Bartlett).
    """
    good = np.isfinite(x), np.isfinite(y)
    grid = np.arange(len(x))
    (a, has_a), (b, has_b) = (
        _on_grid(s[g] - s[g].mean(), grid[g], len(x)) for s, g in zip((x, y), good, strict=True)
    )
    before, after = _lagged(a, b, lags)
    pairs = _lagged(has_a, has_b, lags)
    scale = np.sqrt(np.sum(a**2) / good[0].sum() * np.sum(b**2) / good[1].sum())
    if not scale > 0:
        return np.zeros(2 * lags + 1), float("nan")
    sums = np.concatenate([before[:0:-1], after])
    counts = np.concatenate([pairs[0][:0:-1], pairs[1]])
    reach = len(x) // 4
    rho = [autocorrelation(s[g], grid[g], reach) for s, g in zip((x, y), good, strict=True)]
    spread = 1.0 + 2.0 * float(np.sum(rho[0][1:] * rho[1][1:]))
    both = max(float(pairs[1][0]), 1.0)
    return sums / np.maximum(counts, 1.0) / scale, NORMAL_95 * float(
        np.sqrt(max(spread, 1.0) / both)
    )


def _on_grid(
    values: Array, index: NDArray[np.int64], size: int | None = None
) -> tuple[Array, Array]:
    """Values at their samples, 0 where there is none; and 1 where there is one."""
    first = int(index.min()) if size is None else 0
    n = int(index.max()) - first + 1 if size is None else size
    series, there = np.zeros(n), np.zeros(n)
    series[index - first] = values
    there[index - first] = 1.0
    return series, there


def _lagged(x: Array, y: Array, lags: int) -> tuple[Array, Array]:
    """Sums of x[i] y[i + lag] and of x[i] y[i - lag] for lags 0 to `lags`, by way of spectra."""
    size = 1 << int(len(x) + lags).bit_length()
    both = np.fft.irfft(np.fft.rfft(x, size) * np.conj(np.fft.rfft(y, size)), size)
    return np.append(both[0], both[: -lags - 1 : -1]), both[: lags + 1]


def white_band(samples: int) -> float:
    """95 % band of the autocorrelation of white errors."""
    return NORMAL_95 / float(np.sqrt(samples))


def moving_average_band(rho: Array, steps: int, samples: int) -> Array:
    """95 % band (lags + 1,) for errors of overlapping k-step predictions (Bartlett's formula).

    Even a perfect model's are a moving average of order k - 1: they are correlated below lag k.
    Up to there the band is that of a moving average of the order reached so far.
    """
    squares = np.concatenate([[0.0], np.cumsum(rho[1:] ** 2)])
    order = np.minimum(np.maximum(np.arange(len(rho)) - 1, 0), max(steps - 1, 0))
    return np.asarray(NORMAL_95 * np.sqrt((1.0 + 2.0 * squares[order]) / samples))
