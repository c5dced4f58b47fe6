# SPDX-License-Identifier: MIT
"""Uncertainty of lags by that of their squares.

A lag delays thrust as a latency does; they differ in how far the lag spreads thrust in time, which is its
square. So the square has about the same error everywhere: near 0 the likelihood of the lag itself is flat,
and its curvature at the maximum makes any lag look certain.
"""

import numpy as np

from seatrial.identification.likelihood.linearised import Point
from seatrial.util.frames import Array
from seatrial.util.statistics import NORMAL_95

LAG_KIND = "lag"
PRIOR_SHARE = 0.5  # of a lag's information: with more from the prior, its error is the prior's


def with_lag_by_square(at: Point, covariance: Array) -> Array:
    """The covariance (p, p) with the errors of lags by `lag_error`, and those correlated with them.

    Unchanged where most information about the lag is the prior's: that is about the lag itself.
    """
    out, problem = covariance, at.runs.problem
    for k, i in enumerate(problem.free):
        variance = float(out[k, k])
        before = 0.0 if problem.prior is None else variance * float(problem.prior.precision[i, i])
        if (
            problem.names[i].partition(".")[0] == LAG_KIND
            and variance > 0.0
            and before < PRIOR_SHARE
        ):
            wider = lag_error(float(at.theta[i]), float(np.sqrt(variance))) ** 2
            out = out + (wider / variance - 1.0) / variance * np.outer(out[k], out[k])
    return out


def lag_error(lag: float, error: float) -> float:
    """Standard error [s] of a lag, whose `error` by curvature gives a 95 % interval of its square.

    Where that interval includes 0, 1.96 of it reach the farther end; far from 0, the root mean square of both
    ends' distances. So between 94 and 97.5 % of the intervals hold, whatever the lag
    (`tests/test_uncertainty_lag.py`).
    """
    square, reach = lag**2, NORMAL_95 * 2.0 * lag * error
    low, high = np.sqrt(max(square - reach, 0.0)), np.sqrt(square + reach)
    farther, both = max(lag - low, high - lag), np.hypot(lag - low, high - lag) / np.sqrt(2.0)
    long = low / lag if lag > 0.0 else 0.0
    return float((long * both + (1.0 - long) * farther) / NORMAL_95)
