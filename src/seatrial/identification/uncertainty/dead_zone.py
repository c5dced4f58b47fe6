# SPDX-License-Identifier: MIT
"""Uncertainty of dead-zone edges by profile likelihood, instead of the curvature at the maximum.

A command within the dead zone holds no information about the edge, one beyond it does: the curvature jumps with
the edge. Opposite thrusters of equal edges pass both at once, so that data near equality say little about the
difference, and more away from it. The likelihood may then have two maxima.
"""

from collections.abc import Iterator
from itertools import chain

import numpy as np

from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.uncertainty.profile_line import ProfileLine
from seatrial.util.frames import Array
from seatrial.util.parallel import spread
from seatrial.util.statistics import inverse_of

DEAD_ZONE_KINDS = ("edge_forward", "edge_reverse", "pair_dead_zone", "steer_dead_zone")
UNPROBED_EDGE = 1e-3  # from the maximum to the first point: hardly any command is between the two
PROFILE_STEP = 1.5  # [standard errors] between points of the profile
PROFILE_POINTS = 10  # at most, to either side
# of the errors at the first points and at the maximum: up to it the likelihood is a parabola
PARABOLA_RATIO = 1.15
NEGLIGIBLE_RISE = 9.0  # of scaled -2 log likelihood: exp(-4.5), the profile ends
BOUND_REACHED = 0.1  # of a step that is left when a bound stops it
LEAST_RISE = 1e-9  # of scaled -2 log likelihood, against a division by 0
INTEGRAL_POINTS = 400
SIDES = (-1.0, 1.0)  # of the maximum
# distance [of the combination], rise of scaled -2 log likelihood
ProfilePoint = tuple[float, float]
MAXIMUM: ProfilePoint = (0.0, 0.0)


def with_dead_zone_profile(at: Point, covariance: Array) -> Array:
    """The covariance (p, p) with the variance of edges from their profile likelihood.

    For each group of actuators along the combination of its edges that is known least; all others follow by their
    correlation with it.
    """
    out = covariance
    for edges in _groups(at.runs.problem):
        values, vectors = np.linalg.eigh(out[np.ix_(edges, edges)])
        if PROFILE_STEP * np.sqrt(max(values[-1], 0.0)) < UNPROBED_EDGE:
            continue
        along = np.zeros(len(out))
        along[edges] = vectors[:, -1]
        error = float(np.sqrt(values[-1]))
        factor = (_error(_line(at, out, along), error) / error) ** 2
        shift = out @ along / error
        out = out + (factor - 1.0) * np.outer(shift, shift)  # after the groups before
    return out


def _groups(problem: Problem) -> Iterator[list[int]]:
    """Indices among the free parameters of the edges of each group of actuators."""
    names = [problem.names[i].partition(".") for i in problem.free]
    for group in dict.fromkeys(suffix for kind, _, suffix in names if kind in DEAD_ZONE_KINDS):
        yield [
            k
            for k, (kind, _, suffix) in enumerate(names)
            if kind in DEAD_ZONE_KINDS and suffix == group
        ]


def _line(at: Point, covariance: Array, along: Array) -> ProfileLine:
    """The line along a combination; all that is not at a bound follows by the covariance (p, p)."""
    variance = float(along @ covariance @ along)
    inside = np.diag(covariance) > 0.0
    own = inverse_of(at.runs.information[np.ix_(inside, inside)])
    independent = float(along[inside] @ own @ along[inside])
    return ProfileLine(at, along, covariance @ along / variance, inside, independent / variance)


def _error(line: ProfileLine, error: float) -> float:
    """Standard error of a combination: root mean square distance from the maximum, by the likelihood."""
    sides = [_profile(line, side * PROFILE_STEP * error) for side in SIDES]
    # a parabola: the error from the rise at either side
    near = spread(lambda points: next(points, MAXIMUM), sides)
    errors = [abs(distance) / np.sqrt(max(rise, LEAST_RISE)) for distance, rise in near]
    if all(1.0 / PARABOLA_RATIO < own / error < PARABOLA_RATIO for own in errors):
        return float(np.mean(errors))
    # else: the second moment of the profile likelihood
    points = sorted({MAXIMUM, *near, *chain(*spread(list, sides))})
    if len(points) == 1:  # the bounds are near, or the model diverges
        return error
    distance, rise = np.array(points).T
    fine = np.linspace(distance[0], distance[-1], INTEGRAL_POINTS)
    # the root of a parabola's rise is a line
    weight = np.exp(-0.5 * np.interp(fine, distance, np.sign(distance) * np.sqrt(rise)) ** 2)
    return float(np.sqrt(np.sum(weight * fine**2) / np.sum(weight)))


def _profile(line: ProfileLine, step: float) -> Iterator[ProfilePoint]:
    """Points of the profile that are reached to one side, until the likelihood is negligible."""
    free, theta, reached = list(line.at.runs.problem.free), line.at.theta, 0.0
    for _ in range(PROFILE_POINTS):
        there, here = line.moved(theta, step)
        found = None if abs(here - reached) < BOUND_REACHED * abs(step) else line.look(there)
        if found is None:  # a bound, or divergence
            return
        there[free] += found[1]
        theta, reached = there, here
        rise = max(0.0, found[0])
        yield here, rise
        if rise > NEGLIGIBLE_RISE:
            return
