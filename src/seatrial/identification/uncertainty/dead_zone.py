# SPDX-License-Identifier: MIT
"""How uncertain dead-zone edges are: by the likelihood's whole course, not its curvature at the best.

A command within the dead zone says nothing of the edge, one beyond it does: the curvature changes
from edge to edge. Thrusters in opposite pairs pass both edges at once if these are equal; of their
difference that says little, but more and more where it is not 0. The likelihood may then even have
two summits, and the curvature at the higher one knows nothing of the other.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.likelihood.problem import Problem
from seatrial.util.frames import Array

KINKED = ("edge_forward", "edge_reverse", "pair_dead_zone")
SHARP = 1e-3  # an edge to which hardly any command comes so near: there is nothing to see
OUT = 2.0  # [standard errors] at which it is looked whether the likelihood is a parabola
STRAIGHT = 1.15  # the ratio of the error there to that at the best, up to which it is
STEP = 1.5  # [standard errors] from look to look where it is not
LOOKS = 10  # at most to either side
OVER = 9.0  # rise of the cost, in variances, beyond which nothing is left: exp(-4.5)
FINE = 400  # points of the integral
Places = NDArray[np.int64]
Path = tuple[Array, Array]  # distances and rises of the cost


def as_likely(at: Point, covariance: Array) -> Array:
    """The covariance (p, p) with the edges as uncertain as the likelihood along its course has them.

    For each group of actuators along the combination of its edges that is known least; all others
    follow as far as they are correlated with it. The likelihood is scaled by what the covariance
    knows beyond the curvature (Chandler and Bate, Biometrika 94, 2007).
    """
    out = covariance
    for edges in _groups(at.passes.problem):
        values, vectors = np.linalg.eigh(out[np.ix_(edges, edges)])
        if OUT * np.sqrt(max(values[-1], 0.0)) < SHARP:
            continue
        along = np.zeros(len(out))
        along[edges] = vectors[:, -1]
        error = float(np.sqrt(values[-1]))
        factor = (_error(_Line(at, out, along), error) / error) ** 2
        shift = out @ along / error
        out = out + (factor - 1.0) * np.outer(shift, shift)  # of what the groups before left
    return out


def _groups(problem: Problem) -> Iterator[list[int]]:
    """Places among the free parameters of the edges of one group of actuators."""
    names = [problem.names[i].partition(".") for i in problem.free]
    for group in dict.fromkeys(suffix for kind, _, suffix in names if kind in KINKED):
        yield [k for k, (kind, _, suffix) in enumerate(names) if kind in KINKED and suffix == group]


def _error(line: "_Line", error: float) -> float:
    """Standard error of a combination: the root mean square of its distance from the best."""
    near = [line.look([side * OUT * error]) for side in (-1.0, 1.0)]
    roots = [np.sqrt(max(float(r), 1e-9)) for _, rise in near for r in rise]
    if len(roots) == len(near) and all(1.0 / STRAIGHT < OUT / r < STRAIGHT for r in roots):
        return error * OUT * float(np.mean(1.0 / np.array(roots)))
    steps = STEP * error * np.arange(1, LOOKS + 1)
    low, high = (line.look((side * steps).tolist()) for side in (-1.0, 1.0))
    distance = np.concatenate([low[0][::-1], [0.0], high[0]])
    rise = np.concatenate([low[1][::-1], [0.0], high[1]])
    if len(distance) == 1:  # nowhere to look: the bounds are near, or the boat runs away
        return error
    fine = np.linspace(distance[0], distance[-1], FINE)
    weight = np.exp(-0.5 * np.interp(fine, distance, rise))
    return float(np.sqrt(np.sum(weight * fine**2) / np.sum(weight)))


class _Line:
    """Along one combination of the parameters, all others at their best."""

    def __init__(self, at: Point, covariance: Array, along: Array) -> None:
        self.at, self.along = at, along
        self.inside = np.flatnonzero(np.diag(covariance) > 0.0)  # not what stands at a bound
        self.course = covariance @ along / (along @ covariance @ along)
        self.scale = self._inverse(at.passes.information)[1] / float(along @ covariance @ along)

    def look(self, distances: list[float]) -> Path:
        """Distances that were reached and rises of the cost there, until there is no more to see."""
        problem = self.at.passes.problem
        free, theta = list(problem.free), self.at.theta
        gone, rises = [0.0], [0.0]
        for distance in distances:
            there = theta.copy()
            there[free] += (distance - gone[-1]) * self.course
            there = problem.bounded(there)
            reached = float(self.along @ (there - self.at.theta)[free])
            if abs(reached - gone[-1]) < 0.1 * abs(distance - gone[-1]):
                break  # a bound
            passes = problem.passes(there, self.at.noise, repeatable=False)
            if not np.isfinite(passes.cost):
                break
            step, fall = self._step(passes.information, passes.gradient)
            theta = there
            theta[np.array(free)[self.inside]] += step
            gone.append(reached)
            rises.append(max(0.0, passes.cost - self.at.passes.cost - fall) * self.scale)
            if rises[-1] > OVER:
                break
        return np.array(gone[1:]), np.array(rises[1:])

    def _inverse(self, information: Array) -> tuple[Array, float]:
        """Of the information, and the variance of the combination."""
        a = self.along[self.inside]
        own = information[np.ix_(self.inside, self.inside)]
        inverse = np.asarray(np.linalg.pinv(own, hermitian=True))
        return inverse, float(a @ inverse @ a)

    def _step(self, information: Array, gradient: Array) -> tuple[Array, float]:
        """To the best of the others, and the fall of the cost on that way."""
        inverse, variance = self._inverse(information)
        a, g = self.along[self.inside], gradient[self.inside]
        step = inverse @ (g - a * float(a @ inverse @ g) / variance)
        return step, float(g @ step)
