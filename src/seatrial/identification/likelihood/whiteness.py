# SPDX-License-Identifier: MIT
"""Whiteness of the innovations: those of a right model with right noise are uncorrelated."""

import numpy as np

from seatrial.boat.noise_parameters import NOISE_LEAST, OUTLIER, PROCESS
from seatrial.identification.likelihood.linearised import Point

AUTOCORRELATION_LAGS = 10  # [poses] at most
# from here on innovations count as correlated; right models have half of it
LEAST_AUTOCORRELATION = 0.06
# of 1 / sqrt(n): the largest of 30 autocorrelations exceeds it by chance in 3 %
CHANCE_DEVIATIONS = 3.3
AT_LEAST = 1.01  # times the least process noise: up to here it counts as none


def is_white(at: Point) -> bool:
    """Whether the innovations are uncorrelated: model and noise explain the poses."""
    return autocorrelation_ratio(at) < 1.0


def autocorrelation_ratio(at: Point) -> float:
    """The largest autocorrelation of the innovations, over the limit of whiteness.

    Autocorrelations of n white innovations are normal with deviation 1 / sqrt(n) (Box, Jenkins, Reinsel
    and Ljung, Time Series Analysis, 5th ed., section 2.1.6): of few poses they are large by chance. Infinite where
    the filter diverged. A position between two headings has no innovation of the heading.
    """
    sums, used = np.zeros((AUTOCORRELATION_LAGS + 1, 3)), np.zeros(3)
    for each in at.runs.by_recording:
        with np.errstate(invalid="ignore"):
            spread = np.sqrt(np.asarray(each.spread)[:, [0, 3, 5]])
        error = np.clip(np.asarray(each.innovation) / spread, -OUTLIER, OUTLIER)
        known = np.repeat((np.asarray(each.weight) > 0.0)[:, None], 3, axis=1)
        known[:, 2] &= ~np.isnan(np.asarray(each.innovation)[:, 2])
        error = np.where(known, error, 0.0)
        for lag in range(min(AUTOCORRELATION_LAGS + 1, len(error))):
            sums[lag] += np.sum(error[lag:] * error[: len(error) - lag], axis=0)
        used += known.sum(axis=0)
    if not np.isfinite(sums).all():
        return np.inf
    sums, used = sums[:, used > 0], used[used > 0]
    if not (sums[0] > 0.0).all():  # an axis without errors
        return 0.0
    limits = np.maximum(LEAST_AUTOCORRELATION, CHANCE_DEVIATIONS / np.sqrt(used))
    return float((np.abs(sums[1:] / sums[0]) / limits).max(initial=0.0))


def without_process_noise(at: Point) -> bool:
    """Whether process noise is as good as absent: the model explains all motion."""
    return bool((at.noise[PROCESS] <= AT_LEAST * NOISE_LEAST[PROCESS]).all())
