# SPDX-License-Identifier: MIT
"""Interval of one parameter by profile likelihood: the values up to which the likelihood, maximised over all
other parameters, does not fall significantly.

It need not be symmetric and may be open, unlike one from a standard error (Venzon and Moolgavkar, Applied
Statistics 37, 1988). The likelihood assumes independent innovations; it is scaled by the ratio of the sandwich's
variance to its own (Chandler and Bate, Biometrika 94, 2007).
"""

from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.noise_parameters import present
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.optimiser import at_bounds, converged, search
from seatrial.identification.solution import Fit
from seatrial.identification.uncertainty.covariance import sandwich_covariance
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array
from seatrial.util.parallel import spread
from seatrial.util.statistics import NORMAL_95, inverse_of

END_TOLERANCE = 0.02  # [standard deviations] of the rise at an end of the interval
OPEN_DISTANCE = 300.0  # [standard errors] an interval that reaches so far is open


@dataclass(frozen=True)
class Profile:
    """95 % interval of one parameter; an infinite end: open to that side."""

    name: str
    value: float
    error: float  # standard error, for comparison
    low: float
    high: float


def profile(fit: Fit, name: str) -> Profile:
    """The interval of an estimated parameter, all others and the noise being fitted again.

    Raises IdentificationError where no parameter of that name was estimated.
    """
    if name not in fit.names:
        raise IdentificationError(
            f"--profile {name}: not an estimated parameter; estimated are {', '.join(fit.names)}"
        )
    k = fit.names.index(name)
    scale = _scale(fit, k)
    low, high = spread(lambda side: _end(fit, k, scale, side), (-1.0, 1.0))
    value = float(fit.theta[fit.problem.free[k]])
    return Profile(name, value, float(np.sqrt(fit.covariance[k, k])), low, high)


@dataclass(frozen=True)
class _Scale:
    """The direction of the profile, and the scale of the likelihood."""

    along: Array  # (p,) change of all free parameters for one standard error of the one
    error: float  # standard error; of one at its bound, as if there were no bound
    excess: float  # sandwich's variance over that of independent errors


def _scale(fit: Fit, k: int) -> _Scale:
    """Other parameters at a bound stay there in both variances."""
    at = fit.point
    inside = ~at_bounds(at)
    inside[k] = True
    covariance = sandwich_covariance(at, inside)
    own = inverse_of(fit.runs.information[np.ix_(inside, inside)])
    error = float(np.sqrt(covariance[k, k]))
    place = int(np.sum(inside[:k]))
    return _Scale(covariance[:, k] / error, error, float(error**2 / own[place, place]))


def _end(fit: Fit, k: int, scale: _Scale, side: float) -> float:
    """Where the scaled rise of -2 log likelihood is 1.96^2: the end of a 95 % interval."""
    place, error = fit.problem.free[k], scale.error
    lowest, highest = (float(bound[k]) for bound in fit.problem.bounds)
    best = float(fit.theta[place])
    room = (highest - best if side > 0 else best - lowest) / error
    near, far = (0.0, 0.0), (np.inf, np.inf)  # distance and rise, each in standard deviations
    distance = NORMAL_95
    for look in range(16):  # maximisations at most
        # the rise here: at the end, before it, or beyond it
        distance = min(distance, room, OPEN_DISTANCE)
        rise = _rise(fit, k, scale, side * distance)
        if abs(rise - NORMAL_95) < END_TOLERANCE:
            return best + side * distance * error
        if rise < NORMAL_95:
            if distance == room:
                return best + side * room * error
            if distance == OPEN_DISTANCE:
                return side * np.inf
            near = (distance, rise)
        else:
            far = (distance, rise)
        # the next distance: secant, bisection, or a leap
        if np.isfinite(far[1]):
            share = np.clip((NORMAL_95 - near[1]) / (far[1] - near[1]), 0.05, 0.95)
            distance = near[0] + float(share) * (far[0] - near[0])
        elif np.isfinite(far[0]):
            distance = 0.5 * (near[0] + far[0])
        else:
            least = 1.05 if look < 2 else 2.0  # then the likelihood flattens
            distance = near[0] * float(np.clip(NORMAL_95 / max(near[1], 1e-6), least, 3.0))
    return best + side * distance * error


def _rise(fit: Fit, k: int, scale: _Scale, distance: float) -> float:
    """Root of the scaled rise of -2 log likelihood, the parameter held so many standard errors away."""
    place, free = fit.problem.free[k], list(fit.problem.free)
    theta = fit.theta.copy()
    theta[free] += distance * scale.along
    held = theta[place]
    problem = replace(fit.problem, free=tuple(i for i in free if i != place))
    theta = problem.clipped(theta)
    theta[place] = held
    try:
        # with the noise sources of the solution only: further ones would reduce the rise
        found = converged(
            search(
                problem, theta, fit.noise,
                least=noise_floor(problem, fit.horizon), free=present(fit.noise),
            )
        )  # fmt: skip
    except IdentificationError:
        return np.inf
    return float(np.sqrt(max(0.0, found.runs.cost - fit.runs.cost) / scale.excess))
