# SPDX-License-Identifier: MIT
"""Interval of one parameter by profile likelihood: how far it may go if all others follow.

It need not be symmetric, and it may be open, where a standard error knows nothing of either
(Venzon and Moolgavkar, Applied Statistics 37, 1988). The likelihood takes the filter's errors for
independent; as far as they are not, it is scaled by the ratio of the sandwich's variance to its own
(Chandler and Bate, Biometrika 94, 2007).
"""

from dataclasses import dataclass, replace

import numpy as np

from seatrial.identification.likelihood.fit_horizon import least_noise
from seatrial.identification.likelihood.optimiser import Point, search
from seatrial.identification.solution import Fit
from seatrial.identification.uncertainty.covariance import at_bounds, sandwich
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array
from seatrial.util.parallel import spread
from seatrial.util.statistics import NORMAL_95, inverse_of

CLOSE = 0.02  # of a standard deviation: the end is found
LOOKS = 16  # at most, to either side
FARTHEST = 300.0  # [standard errors] an interval that reaches so far is open


@dataclass(frozen=True)
class Profile:
    """95 % interval of one parameter; an infinite end: open to that side."""

    name: str
    value: float
    error: float  # standard error, for comparison
    low: float
    high: float


def profile(fit: Fit, name: str) -> Profile:
    """The interval of a parameter that was sought, with all others and the noise fitted anew.

    Raises IdentificationError where no parameter of that name was sought.
    """
    if name not in fit.names:
        raise IdentificationError(f"--profile {name}: sought were {', '.join(fit.names)}")
    k = fit.names.index(name)
    scale = _scale(fit, k)
    low, high = spread(lambda side: _end(fit, k, scale, side), (-1.0, 1.0))
    value = float(fit.theta[fit.problem.free[k]])
    return Profile(name, value, float(np.sqrt(fit.covariance[k, k])), low, high)


@dataclass(frozen=True)
class _Scale:
    """How far one parameter and those that follow it go, and what the cost's rise is worth."""

    along: Array  # (p,) of all free parameters, while the one goes a standard error
    error: float  # standard error; of one that ended at its bound, as if it might pass it
    excess: float  # sandwich's variance over that of independent errors


def _scale(fit: Fit, k: int) -> _Scale:
    """What ended at a bound stays there in both variances, but for the parameter itself."""
    at = Point(fit.theta, fit.noise, fit.passes)
    inside = ~at_bounds(at)
    inside[k] = True
    covariance = sandwich(at, inside)
    own = inverse_of(fit.passes.information[np.ix_(inside, inside)])
    error = float(np.sqrt(covariance[k, k]))
    place = int(np.sum(inside[:k]))
    return _Scale(covariance[:, k] / error, error, float(error**2 / own[place, place]))


def _end(fit: Fit, k: int, scale: _Scale, side: float) -> float:
    """Where the cost has risen as far as at 1.96 standard errors of a normal likelihood."""
    place, error = fit.problem.free[k], scale.error
    lowest, highest = (float(bound[k]) for bound in fit.problem.bounds)
    best = float(fit.theta[place])
    room = (highest - best if side > 0 else best - lowest) / error
    near, far = (0.0, 0.0), (np.inf, np.inf)  # distance and rise, each in standard deviations
    distance = NORMAL_95
    for look in range(LOOKS):
        distance = min(distance, room, FARTHEST)
        rise = _rise(fit, k, scale, side * distance)
        if abs(rise - NORMAL_95) < CLOSE:
            return best + side * distance * error
        if rise < NORMAL_95:
            if distance == room:
                return best + side * room * error
            if distance == FARTHEST:
                return side * np.inf
            near = (distance, rise)
        else:
            far = (distance, rise)
        if np.isfinite(far[1]):
            share = np.clip((NORMAL_95 - near[1]) / (far[1] - near[1]), 0.05, 0.95)
            distance = near[0] + float(share) * (far[0] - near[0])
        elif np.isfinite(far[0]):
            distance = 0.5 * (near[0] + far[0])
        else:
            least = 1.05 if look < 2 else 2.0  # it flattens: in leaps
            distance = near[0] * float(np.clip(NORMAL_95 / max(near[1], 1e-6), least, 3.0))
    return best + side * distance * error


def _rise(fit: Fit, k: int, scale: _Scale, distance: float) -> float:
    """Root of the cost's rise, scaled, with the parameter held so many standard errors away."""
    place, free = fit.problem.free[k], list(fit.problem.free)
    theta = fit.theta.copy()
    theta[free] += distance * scale.along
    held = theta[place]
    problem = replace(fit.problem, free=tuple(i for i in free if i != place))
    theta = problem.bounded(theta)
    theta[place] = held
    try:
        found = search(problem, theta, fit.noise, least=least_noise(problem, fit.share))
    except IdentificationError:
        return np.inf
    return float(np.sqrt(max(0.0, found.passes.cost - fit.passes.cost) / scale.excess))
