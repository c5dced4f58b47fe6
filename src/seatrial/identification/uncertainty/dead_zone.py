# SPDX-License-Identifier: MIT
"""Uncertainty of dead-zone edges by profile likelihood, instead of the curvature at the maximum.

A command within the dead zone holds no information about the edge, one beyond it does: the curvature jumps with
the edge. Opposite thrusters of equal edges pass both at once, so that data near equality say little about the
difference, and more away from it. The likelihood may then have two maxima.
"""

from collections.abc import Iterator

import numpy as np

from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.uncertainty.profile_line import ProfileLine
from seatrial.util.frames import Array
from seatrial.util.parallel import spread
from seatrial.util.statistics import inverse_of

DEAD_ZONE_KINDS = ("edge_forward", "edge_reverse", "pair_dead_zone", "steer_dead_zone")
UNPROBED_EDGE = 1e-3  # twice the standard error of an edge: hardly any command comes so near to it
# [standard errors] from the maximum, where the likelihood is compared with a parabola
PARABOLA_PROBE = 2.0
# of the errors there and at the maximum: up to it the likelihood is a parabola
PARABOLA_RATIO = 1.15
PROFILE_STEP = 1.5  # [standard errors] between points of the profile, else
PROFILE_POINTS = 10  # at most, to either side
NEGLIGIBLE_RISE = 9.0  # of scaled -2 log likelihood: exp(-4.5), the profile ends
BOUND_REACHED = 0.1  # of a step that is left when a bound stops it
LEAST_RISE = 1e-9  # of scaled -2 log likelihood, against a division by 0
INTEGRAL_POINTS = 400
SIDES = (-1.0, 1.0)  # of the maximum
# distances [of the combination], rises of scaled -2 log likelihood
ProfileRises = tuple[Array, Array]


def with_dead_zone_profile(at: Point, covariance: Array) -> Array:
    """The covariance (p, p) with the variance of edges from their profile likelihood.

    For each group of actuators along the combination of its edges that is known least; all others follow by their
    correlation with it.
    """
    out = covariance
    for edges in _groups(at.runs.problem):
        values, vectors = np.linalg.eigh(out[np.ix_(edges, edges)])
        if PARABOLA_PROBE * np.sqrt(max(values[-1], 0.0)) < UNPROBED_EDGE:
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
    # a parabola: the error from the rise at either side
    near = spread(lambda side: _rises(line, [side * PARABOLA_PROBE * error]), SIDES)
    roots = [np.sqrt(max(float(r), LEAST_RISE)) for _, rise in near for r in rise]
    if len(roots) == len(near) and all(
        1.0 / PARABOLA_RATIO < PARABOLA_PROBE / r < PARABOLA_RATIO for r in roots
    ):
        return error * PARABOLA_PROBE * float(np.mean(1.0 / np.array(roots)))
    # else: the second moment of the profile likelihood
    steps = PROFILE_STEP * error * np.arange(1, PROFILE_POINTS + 1)
    low, high = spread(lambda side: _rises(line, (side * steps).tolist()), SIDES)
    distance = np.concatenate([low[0][::-1], [0.0], high[0]])
    rise = np.concatenate([low[1][::-1], [0.0], high[1]])
    if len(distance) == 1:  # the bounds are near, or the model diverges
        return error
    fine = np.linspace(distance[0], distance[-1], INTEGRAL_POINTS)
    weight = np.exp(-0.5 * np.interp(fine, distance, rise))
    return float(np.sqrt(np.sum(weight * fine**2) / np.sum(weight)))


def _rises(line: ProfileLine, distances: list[float]) -> ProfileRises:
    """The distances that are reached, and the rises there, until the likelihood is negligible."""
    free, theta = list(line.at.runs.problem.free), line.at.theta
    reached, rises = [0.0], [0.0]
    for distance in distances:
        by = distance - reached[-1]
        there, here = line.moved(theta, by)
        found = None if abs(here - reached[-1]) < BOUND_REACHED * abs(by) else line.look(there)
        if found is None:  # a bound, or divergence
            break
        there[free] += found[1]
        theta = there
        reached.append(here)
        rises.append(max(0.0, found[0]))
        if rises[-1] > NEGLIGIBLE_RISE:
            break
    return np.array(reached[1:]), np.array(rises[1:])
