# SPDX-License-Identifier: MIT
"""What a parameter that ended at its bound does to the others: it may be off it.

A lag that ended at 0 leaves its latency as uncertain as that. The likelihood is far from normal there: so the
one-sided profile likelihood is followed from the bound, and the squares of the others' moves are averaged over it.
"""

import numpy as np

from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.uncertainty.profile_line import ProfileLine
from seatrial.util.frames import Array, Mask
from seatrial.util.statistics import LEAST_EIGENVALUE

# first distance in standard errors and in the range, factors from one to the next
FIRST_DISTANCE, LARGEST_FIRST_DISTANCE, FARTHER, NEARER = 0.5, 0.125, 2.0, 0.25
BOUND_EVALUATIONS = 8  # at most
STEEP_LIKELIHOOD = 3.0  # rise of -2 log likelihood at the first distance: it was too far
OPEN_RANGE = 8.0  # standard errors that stand for the range where there is none
NEGLIGIBLE_LIKELIHOOD = 12.0  # rise of -2 log likelihood beyond which it is followed no further
LEAST_INFORMATION = 1e-300  # against a division by 0


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
    normal = 1.0 / np.sqrt(max(own, LEAST_EIGENVALUE * information[held, held], LEAST_INFORMATION))
    side = 1.0 if value - low < high - value else -1.0
    reach = high - low if np.isfinite(high - low) else OPEN_RANGE * normal
    line = ProfileLine(at, along, course, inside, 1.0 / factor)

    distance, rise, moves = [0.0], [0.0], [np.zeros(len(inside))]
    d = min(FIRST_DISTANCE * normal, LARGEST_FIRST_DISTANCE * reach)
    for _ in range(BOUND_EVALUATIONS):
        if d > reach:
            break
        found = line.look(line.moved(at.theta, side * d)[0])
        if len(distance) == 1 and (found is None or found[0] > STEEP_LIKELIHOOD):
            d *= NEARER  # nearer first
            continue
        if found is None:
            break
        distance.append(d)
        rise.append(found[0])
        moves.append(np.where(inside, side * d * course + found[1], 0.0))
        if rise[-1] > NEGLIGIBLE_LIKELIHOOD:
            break
        d *= FARTHER
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
