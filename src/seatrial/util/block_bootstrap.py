# SPDX-License-Identifier: MIT
"""Intervals for the RMS of correlated errors: a bootstrap over blocks of time.

Errors of overlapping predictions are correlated over the horizon, and model mismatch over longer
times. Blocks longer than both are nearly independent, so blocks are drawn, not samples (Künsch). A
resample needs only the sums of the blocks: all of them are one product of matrices.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from seatrial.util.frames import Array, frozen_array
from seatrial.util.statistics import autocorrelation

RESAMPLES = 1000
SEED = 1
FEWEST_BLOCKS = 6  # blocks for an interval
PREFERRED_BLOCKS = 10  # blocks; to have as many, blocks are shortened to the least length
MOST_BLOCKS = 40  # blocks; longer blocks lose less of the correlation
SOKAL_WINDOW = 5.0  # autocorrelation times over which the autocorrelation is summed
# in a block: leaves a few per cent of correlation between blocks
OVERLAPS, CORRELATION_TIMES = 2.0, 6.0
WIDEST_T = 6.0  # standard deviations, limit of a studentised value: few blocks may hold all errors
LEAST_VARIANCE = 1e-12  # of the logarithm of a ratio


def correlation_time(squares: Array, index: NDArray[np.int64]) -> float:
    """Integrated autocorrelation time, in samples, of squared errors (m, q) at samples `index` (m,).

    The sum of the autocorrelation, up to five times itself (Sokal's window); the longest of the q.
    """
    lags = max(1, (int(index.max()) - int(index.min())) // 4)
    total = 1.0 + 2.0 * np.cumsum(autocorrelation(squares, index, lags)[1:], axis=0)
    closed = np.arange(1, lags + 1)[:, None] >= SOKAL_WINDOW * total
    first = np.argmax(closed, axis=0)
    times = np.where(
        closed.any(axis=0), np.take_along_axis(total, first[None], 0)[0], total.max(axis=0)
    )
    return max(1.0, float(times.max()))


def block_length(squares: Array, index: NDArray[np.int64], overlap: int) -> int:
    """Samples in a block, for squared errors (m, q) of predictions over `overlap` samples.

    Twice the overlap and six times the correlation time leave a few per cent of the
    correlation between blocks; where that makes too few blocks they are shorter, but never as short as
    overlap and correlation time.
    """
    span = int(index.max()) - int(index.min()) + 1
    time = correlation_time(squares, index)
    least = max(float(overlap), time) + 1.0
    best = max(OVERLAPS * overlap, CORRELATION_TIMES * time, span / MOST_BLOCKS)
    return int(np.ceil(max(least, min(best, span / PREFERRED_BLOCKS))))


def block_sums(values: Array, index: NDArray[np.int64], length: int) -> Array | None:
    """Sums (b, q) of values (m, q) at rising samples `index` (m,), block by block.

    None where there are fewer than `FEWEST_BLOCKS` blocks.
    """
    _, first = np.unique((index - index[0]) // length, return_index=True)
    return np.add.reduceat(values, first, axis=0) if len(first) >= FEWEST_BLOCKS else None


def ratio_interval(over: Array, under: Array) -> Array:
    """95 % intervals (p, 2) of sum(over) / sum(under), each block by block (b, p).

    With `under` the number of samples it is that of a mean. Studentised on the scale of the
    logarithm (Davison, Hinkley, section 5.2): percentiles alone are too short at their upper end,
    as few blocks hold the large errors. The same data give the same draws.
    """
    drawn = block_draws(len(over))
    centre = np.log(over.sum(axis=0) / under.sum(axis=0))
    spread = _deviation(np.ones((1, len(over))), over, under)[0]
    found = np.log((drawn @ over) / (drawn @ under))
    student = (found - centre) / _deviation(drawn, over, under)
    student = np.clip(student, -WIDEST_T, WIDEST_T)
    least, most = np.quantile(student, [0.025, 0.975], axis=0)
    return np.asarray(np.exp(np.stack([centre - most * spread, centre - least * spread], axis=-1)))


def _deviation(drawn: Array, over: Array, under: Array) -> Array:
    """Standard deviation (R, p) of the logarithm of the ratio, from the blocks drawn (R, b)."""
    top, bottom = drawn @ over, drawn @ under
    variance = drawn @ over**2 / top**2 + drawn @ under**2 / bottom**2
    variance -= 2.0 * (drawn @ (over * under)) / (top * bottom)
    return np.asarray(np.sqrt(np.maximum(variance, LEAST_VARIANCE)))


@lru_cache(maxsize=64)
def block_draws(blocks: int) -> Array:
    """Number of times that each block is drawn: (RESAMPLES, blocks)."""
    rng = np.random.default_rng(SEED)
    return frozen_array(rng.multinomial(blocks, np.full(blocks, 1.0 / blocks), RESAMPLES))
