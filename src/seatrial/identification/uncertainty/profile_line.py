# SPDX-License-Identifier: MIT
"""The profile likelihood along one combination of the parameters, the noise held; and from a bound inwards.

Each point is one filter pass and one Gauss-Newton step of all parameters across the line. The likelihood assumes
independent innovations: its rise is scaled by the ratio of their variance to the sandwich's (Chandler and Bate,
Biometrika 94, 2007).

A parameter at its bound may be off it: a lag that ended at 0 leaves its latency as uncertain as that. There the
likelihood is far from normal. So the one-sided profile is followed from the bound, and the squares of the others'
moves are averaged over it.
"""

from dataclasses import dataclass

import numpy as np

from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import Point
from seatrial.util.frames import Array, Mask
from seatrial.util.statistics import LEAST_EIGENVALUE, inverse_of


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
        runs = filter_along(self.at.runs.problem, theta, self.at.noise, repeatable=False)
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


def one_sided_profile(at: Point, held: int, inside: Mask, inverse: Array, factor: float) -> Array:
    """The addition to the covariance (p, p) of the inner parameters as one at its bound may be off it.

    inverse: of the information of those `inside`; factor: the sandwich's variance over that of independent errors.
    """
    problem, information = at.runs.problem, at.runs.information
    low, high = (float(bound[held]) for bound in problem.bounds)
    value = float(at.theta[problem.free[held]])
    along, course = np.zeros((2, len(inside)))
    along[held] = course[held] = 1.0
    course[inside] = -inverse @ information[inside, held]
    own = float(information[held] @ course)
    normal = 1.0 / np.sqrt(max(own, LEAST_EIGENVALUE * information[held, held], 1e-300))
    side = 1.0 if value - low < high - value else -1.0
    reach = high - low if np.isfinite(high - low) else 8.0 * normal  # standard errors for a range
    line = ProfileLine(at, along, course, inside, 1.0 / factor)

    distance, rise, moves = [0.0], [0.0], [np.zeros(len(inside))]
    d = min(0.5 * normal, 0.125 * reach)
    for _ in range(8):  # passes at most
        if d > reach:
            break
        found = line.look(line.moved(at.theta, side * d)[0])
        if len(distance) == 1 and (found is None or found[0] > 3.0):
            d *= 0.25  # nearer first
            continue
        if found is None:
            break
        distance.append(d)
        rise.append(found[0])
        moves.append(np.where(inside, side * d * course + found[1], 0.0))
        if rise[-1] > 12.0:  # the likelihood is negligible
            break
        d *= 2.0
    return _mean_square(np.array(distance), np.array(rise), np.array(moves))


def _mean_square(distance: Array, rise: Array, moves: Array) -> Array:
    """Mean of the products (p, p) of moves (n, p), weighted with the likelihood along the distance (n,)."""
    steps = np.diff(distance)
    if not len(steps):
        return np.zeros((moves.shape[1],) * 2)
    weight = np.exp(-0.5 * (rise - rise.min()))
    products = weight[:, None, None] * moves[:, :, None] * moves[:, None, :]
    whole = np.sum(0.5 * steps * (weight[1:] + weight[:-1]))
    parts = 0.5 * steps[:, None, None] * (products[1:] + products[:-1])
    return np.asarray(np.sum(parts, axis=0) / whole)
