# SPDX-License-Identifier: MIT
"""How uncertain lags are: by their squares.

A lag delays thrust as a latency does; what sets the two apart is how much it is spread in time, and that
goes with the square of the lag. So it is the square that is known as well everywhere: the likelihood of the
lag itself is the flatter the shorter it is, and by its curvature at the best any lag would seem sharp.
"""

import numpy as np

from seatrial.identification.likelihood.optimiser import Point
from seatrial.util.frames import Array
from seatrial.util.statistics import NORMAL_95

LAG = "lag"
MOSTLY = 0.5  # of what is known of it


def by_squares(at: Point, covariance: Array) -> Array:
    """The covariance (p, p) with lags as uncertain as `lag_error` has it, and what is correlated with them.

    Not where it is the prior that knows the lag: that is of the lag itself.
    """
    out, problem = covariance, at.passes.problem
    for k, i in enumerate(problem.free):
        variance = float(out[k, k])
        before = 0.0 if problem.prior is None else variance * float(problem.prior.precision[i, i])
        if problem.names[i].partition(".")[0] == LAG and variance > 0.0 and before < MOSTLY:
            wider = lag_error(float(at.theta[i]), float(np.sqrt(variance))) ** 2
            out = out + (wider / variance - 1.0) / variance * np.outer(out[k], out[k])
    return out


def lag_error(lag: float, error: float) -> float:
    """Of a lag whose square has the 95 % interval that its `error` by curvature says; that may reach to no lag.

    1.96 of it reach to the farther end of that interval where it reaches to none, and to the root mean square of
    both ends' distances where it is far from there: so between 94 and 97.5 % hold, whatever the lag
    (`tests/test_short_lag.py`). All in seconds.
    """
    square, reach = lag**2, NORMAL_95 * 2.0 * lag * error
    low, high = np.sqrt(max(square - reach, 0.0)), np.sqrt(square + reach)
    farther, both = max(lag - low, high - lag), np.hypot(lag - low, high - lag) / np.sqrt(2.0)
    long = low / lag if lag > 0.0 else 0.0
    return float((long * both + (1.0 - long) * farther) / NORMAL_95)
