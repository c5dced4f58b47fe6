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
    series = np.full(int(index.max() - index.min()) + 1, np.nan)
    series[index - index.min()] = errors - errors.mean()
    variance = float(np.nanmean(series**2))
    rho = np.zeros(lags + 1)
    rho[0] = 1.0
    for lag in range(1, min(lags + 1, len(series))):
        product = series[lag:] * series[:-lag]
        good = np.isfinite(product)
        rho[lag] = float(product[good].mean()) / variance if variance > 0 and good.any() else 0.0
    return rho


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
