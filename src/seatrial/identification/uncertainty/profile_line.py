# SPDX-License-Identifier: MIT
"""The profile likelihood along one combination of the parameters, the noise held.

Each point is one filter pass and one Gauss-Newton step of all parameters across the line. The likelihood assumes
independent innovations: its rise is scaled by the ratio of their variance to the sandwich's (Chandler and Bate,
Biometrika 94, 2007).
"""

from dataclasses import dataclass

import numpy as np

from seatrial.identification.likelihood.optimiser import Point
from seatrial.util.frames import Array, Mask
from seatrial.util.statistics import inverse_of


@dataclass(frozen=True)
class ProfileLine:
    """A line through the maximum of the likelihood."""

    at: Point
    along: Array  # (p,) the combination of the free parameters: its value is the distance
    course: Array  # (p,) how all of them move with it: along @ course is 1
    inside: Mask  # (p,) those that follow; the others are at a bound
    scale: float  # of the rise

    def moved(self, theta: Array, by: float) -> tuple[Array, float]:
        """Parameters (names,) farther along the line, within their bounds; their distance from the maximum."""
        problem, there = self.at.runs.problem, theta.copy()
        there[list(problem.free)] += by * self.course
        there = problem.clipped(there)
        return there, float(self.along @ (there - self.at.theta)[list(problem.free)])

    def look(self, theta: Array) -> tuple[float, Array] | None:
        """Scaled rise of -2 log likelihood there, and the others' step (p,) to their best; None: divergence."""
        runs = self.at.runs.problem.run_filter(theta, self.at.noise, repeatable=False)
        if not np.isfinite(runs.cost):
            return None
        inside = self.inside
        a, g = self.along[inside], runs.gradient[inside]
        inverse = inverse_of(runs.information[np.ix_(inside, inside)])
        if a.any():  # not along the line
            g = g - a * float(a @ inverse @ g) / float(a @ inverse @ a)
        step = np.zeros(len(inside))
        step[inside] = inverse @ g
        fall = float(runs.gradient @ step)
        return (runs.cost - self.at.runs.cost - fall) * self.scale, step
