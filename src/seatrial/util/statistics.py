# SPDX-License-Identifier: MIT
"""Small statistics of prediction errors."""

import numpy as np
from numpy.typing import NDArray

from seatrial.util.frames import Array, Mask

NORMAL_95 = 1.959964  # two-sided 95 % quantile of the normal distribution
BLOCK = 10.0  # [s] blocks of errors that count as independent
# of a scaled information; a smaller one has no information (only a sum is known)
LEAST_EIGENVALUE = 1e-9
# of the largest eigenvalue: a direction with less has no information
UNSEEN_DIRECTION = 1e-9
UNSEEN_SHARE = 1e-2  # of such a direction: a parameter with less in it still has a standard error


def inverse_of(matrix: Array) -> Array:
    """Inverse (p, p) of an information or covariance matrix with entries of different scales.

    Directions without information get a large variance, never 0 or negative.
    """
    scale = 1.0 / np.sqrt(np.diag(matrix) + 1e-12)
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    root = vectors * scale[:, None] / np.sqrt(np.maximum(values, LEAST_EIGENVALUE))
    return np.asarray(root @ root.T)


def root_of(covariance: Array) -> Array:
    """A square root (p, p) of a covariance that may be singular: root @ root.T is the covariance.

    A negative eigenvalue, by rounding, counts as 0.
    """
    spectrum, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(spectrum, 0.0)))


def pseudo_inverse(information: Array) -> tuple[Array, Mask]:
    """Inverse (p, p) over directions with information, and which parameters (p,) they determine."""
    size = np.sqrt(np.diag(information))
    alive = size > 0
    out, known = np.zeros_like(information), np.zeros(len(size), dtype=bool)
    if not alive.any():
        return out, known
    scale = 1.0 / size[alive]
    spectrum, vectors = np.linalg.eigh(information[np.ix_(alive, alive)] * np.outer(scale, scale))
    seen = spectrum > UNSEEN_DIRECTION * spectrum[-1]
    inverse = (vectors[:, seen] / spectrum[seen]) @ vectors[:, seen].T
    out[np.ix_(alive, alive)] = inverse * np.outer(scale, scale)
    known[alive] = ~np.any(np.abs(vectors[:, ~seen]) > UNSEEN_SHARE, axis=1)
    return out, known


def kurtosis(errors: Array) -> float:
    """Fourth standardised moment: 3 for a normal distribution, more with heavy tails."""
    centred = errors - errors.mean()
    variance = float(np.mean(centred**2))
    return float(np.mean(centred**4)) / variance**2 if variance > 0 else float("nan")


def autocorrelation(errors: Array, index: NDArray[np.int64], lags: int) -> Array:
    """Normalised autocorrelation (lags + 1,) of errors (m,) that stand at samples `index` (m,).

    For errors (m, q) it is (lags + 1, q). Pairs are formed only between samples exactly one lag
    apart, so gaps drop out.
    """
    n = int(index.max() - index.min()) + 1
    series, there = np.zeros((n, *errors.shape[1:])), np.zeros(n)
    series[index - index.min()] = errors - errors.mean(axis=0)
    there[index - index.min()] = 1.0
    f, g = _spectrum(series, lags), _spectrum(there, lags)
    sums, pairs = _sums(f, f)[: lags + 1], _sums(g, g)[: lags + 1]
    mean = (sums.T / np.maximum(pairs, 1.0) * (pairs > 0.5)).T
    rho = np.divide(mean, mean[0], out=np.zeros_like(mean), where=mean[0] > 0)
    rho[0] = 1.0
    return np.asarray(rho)


def cross_correlation(x: Array, y: Array, lags: int) -> Array:
    """Correlation (2 lags + 1, p, q) of x[i] with y[i - lag], lag from -lags to lags.

    x (n, p), y (n, q) on one even grid; a row with NaN is no sample. At positive lags x follows y.
    """
    (a, has_a), (b, has_b) = _centred(x), _centred(y)
    sums = _sums(_spectrum(b, lags)[:, None, :], _spectrum(a, lags)[:, :, None])
    pairs = _sums(_spectrum(has_b, lags), _spectrum(has_a, lags))
    order = np.arange(lags, -lags - 1, -1)  # a negative index is a lag the other way
    scale = np.sqrt(
        np.outer(np.sum(a**2, axis=0) / has_a.sum(), np.sum(b**2, axis=0) / has_b.sum())
    )
    mean = sums[order] / np.maximum(pairs[order], 1.0)[:, None, None]
    return np.divide(mean, scale, out=np.zeros_like(mean), where=scale > 0)


def bartlett_band(rho_x: Array, rho_y: Array, samples: int) -> Array:
    """95 % band (p, q) of the cross-correlation of independent signals.

    rho_x (m, p), rho_y (m, q): autocorrelations from lag 0 on. Bartlett's
    formula: the variance is the sum of rho_x(j) rho_y(j) over all j, over the samples. Not less than
    for white signals.
    """
    spread = 1.0 + 2.0 * rho_x[1:].T @ rho_y[1:]
    return np.asarray(NORMAL_95 * np.sqrt(np.maximum(spread, 1.0) / samples))


def _centred(x: Array) -> tuple[Array, Array]:
    """Values minus their mean, 0 without a sample; and a mask (n,), 1 with a sample."""
    good: Mask = np.asarray(np.isfinite(x).all(axis=1))
    centred: Array = np.where(good[:, None], x - x[good].mean(axis=0), 0.0)
    return centred, good.astype(np.float64)


def _spectrum(x: Array, lags: int) -> NDArray[np.complex128]:
    return np.fft.rfft(x, 1 << int(len(x) + lags).bit_length(), axis=0)


def _sums(f: NDArray[np.complex128], g: NDArray[np.complex128]) -> Array:
    """Sums over i of f's x[i + lag] g's y[i], lags from 0; negative ones from the end."""
    return np.fft.irfft(f * np.conj(g), axis=0)


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
