# SPDX-License-Identifier: MIT
"""Whether the filter's errors follow a pattern, which right models and right noise leave them without."""

import numpy as np

from seatrial.boat.noise_parameters import NOISE_LEAST, OUTLIER, PROCESS
from seatrial.identification.likelihood.optimiser import Point

LAGS = 10  # poses over which the filter's errors are looked at
PATTERN = 0.06  # autocorrelation from which on they follow one; right models' are half of it
CHANCE = 3.3  # times 1 / sqrt(n), its deviation: the largest of thirty is beyond in 3 % of cases


def white(at: Point) -> bool:
    """Whether the filter's errors follow no pattern: the noise that was found explains them."""
    return pattern(at) < 1.0


def pattern(at: Point) -> float:
    """The largest autocorrelation of the filter's errors, over what is no pattern.

    Of n errors that follow none, autocorrelations are normal with deviation 1 / sqrt(n) (Box, Jenkins, Reinsel
    and Ljung, Time Series Analysis, 5th ed., section 2.1.6): few poses show a pattern by chance.
    """
    sums, used = np.zeros((LAGS + 1, 3)), 0
    for each in at.passes.each:
        spread = np.sqrt(np.asarray(each.spread)[:, [0, 3, 5]])
        error = np.clip(np.asarray(each.innovation) / spread, -OUTLIER, OUTLIER)
        error = np.where((np.asarray(each.weight) > 0.0)[:, None], error, 0.0)
        for lag in range(min(LAGS + 1, len(error))):
            sums[lag] += np.sum(error[lag:] * error[: len(error) - lag], axis=0)
        used += int(np.sum(np.asarray(each.weight) > 0.0))
    if not (sums[0] > 0.0).all():  # an axis without errors has no pattern either
        return 0.0
    return float(np.abs(sums[1:] / sums[0]).max() / max(PATTERN, CHANCE / np.sqrt(used)))


def explained(at: Point) -> bool:
    """Whether nothing is left that the model does not say."""
    return bool((at.noise[PROCESS] <= 1.01 * NOISE_LEAST[PROCESS]).all())
