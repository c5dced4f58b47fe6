# SPDX-License-Identifier: MIT
"""Sandwich covariance of the estimates, which holds for correlated innovations."""

from dataclasses import replace

import numpy as np

from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.likelihood.problem import Problem
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Mask
from seatrial.util.statistics import TIED, inverse_of

SHRINKAGE_BLOCKS = 4.0  # blocks per parameter with which the scatter of the scores has weight 1/2
FEW_BLOCKS = 2.0  # blocks per parameter: with fewer, scatter below the information's is chance
SHORTEST_BLOCK = 4.0  # [s] innovations are correlated over less
BLOCKS_PER_PARAMETER = 1.2  # with fewer, blocks are shortened
AT_BOUND_SHARE = 1e-4  # of a parameter's range: within it of a bound it counts as at the bound
BOUND_DISTANCES = 0.5 ** np.arange(
    12, 0, -1
)  # shares of the range at which the likelihood is followed
OPEN_RANGE = 8.0  # standard errors that stand for the range where there is none
NEGLIGIBLE_LIKELIHOOD = 12.0  # rise of -2 log likelihood beyond which it is followed no further
LISTED_WEIGHT = (
    0.1  # of the largest entry: coefficients with less in a tied direction are not named
)


def sandwich_covariance(at: Point, inside: Mask | None = None) -> Array:
    """Covariance (p, p) from the Fisher information and the scatter of scores over blocks.

    inside: (p,) free parameters that may move, the others stay, with 0; by default all that did not
    end at a bound.

    The scatter of few blocks is itself uncertain. It is shrunk towards the information, times a common factor
    that the blocks do know: the fewer blocks per parameter, the more (the idea: Ledoit and Wolf, J. Multivariate
    Analysis 88, 2004). Raises IdentificationError where coefficients are not separable.
    """
    problem = at.runs.problem
    prior, free = problem.prior, list(problem.free)
    if prior is None:
        _refuse_inseparable(at)
    held = at_bounds(at) if inside is None else np.zeros(len(free), dtype=bool)
    inside = ~at_bounds(at) if inside is None else inside
    # bread and meat of the sandwich, and the prior's part of the information
    scores = at.runs.scores[:, inside]
    information = at.runs.information[np.ix_(inside, inside)]
    blocks, p = scores.shape
    known = np.zeros((p, p)) if prior is None else prior.precision[np.ix_(free, free)][
        np.ix_(inside, inside)
    ]  # fmt: skip
    inverse = inverse_of(information)
    informed = float(
        np.sum(inverse * (information - known))
    )  # number of parameters that the recordings determine
    scores = scores - scores.mean(axis=0)
    scores *= np.sqrt(
        blocks / max(blocks - informed / 2, blocks / 4)
    )  # the fit took some of the scatter
    moves = scores @ inverse  # of the parameters by each block
    factor = float(np.sum(moves * scores)) / max(informed, TIED)
    if blocks < FEW_BLOCKS * informed:
        factor = max(factor, 1.0)
    # shrink the scatter of few blocks
    share = (
        blocks / (blocks + SHRINKAGE_BLOCKS * informed) if blocks > 1 else 0.0
    )  # one block has no scatter
    of_prior = inverse @ known @ inverse
    shrunk = share * moves.T @ moves + (1.0 - share) * factor * (inverse - of_prior)
    out = np.zeros((len(free), len(free)))
    out[np.ix_(inside, inside)] = shrunk + of_prior
    # parameters at a bound may be off it: that widens the others
    for i in np.flatnonzero(held):
        out[np.ix_(inside, inside)] += _one_sided_profile(
            at, int(i), inside, inverse, max(factor, 1.0)
        )
    return out


def _one_sided_profile(at: Point, held: int, inside: Mask, inverse: Array, factor: float) -> Array:
    """The addition to the covariance (p, p) of the inner parameters as one at its bound may be off it.

    A lag that ended at 0 leaves its latency as uncertain as that. The likelihood is far from normal there: so the
    one-sided profile likelihood is followed from the bound, the other parameters one Gauss-Newton step from their
    best, and the squares of their moves are averaged over it.
    """
    problem, free = at.runs.problem, np.array(at.runs.problem.free)
    low, high = (float(bound[held]) for bound in problem.bounds)
    across = at.runs.information[inside, held]
    moved = -inverse @ across
    own = float(at.runs.information[held, held] + across @ moved)
    normal = 1.0 / np.sqrt(max(own, TIED * at.runs.information[held, held], 1e-300))
    value = float(at.theta[free[held]])
    side = 1.0 if value - low < high - value else -1.0
    reach = high - low if np.isfinite(high - low) else OPEN_RANGE * normal
    distance, rise, off = [0.0], [0.0], [np.zeros(len(moved))]
    for d in reach * BOUND_DISTANCES:
        # this far from the bound, the others along with it
        theta = at.theta.copy()
        theta[free[inside]] += side * d * moved
        theta[free[held]] += side * d
        runs = problem.run_filter(problem.clipped(theta), at.noise, repeatable=False)
        if not np.isfinite(runs.cost):
            break
        gradient = runs.gradient[inside]
        step = inverse_of(runs.information[np.ix_(inside, inside)]) @ gradient
        distance.append(float(d))
        rise.append((runs.cost - float(gradient @ step) - at.runs.cost) / factor)
        off.append(side * d * moved + step)
        if rise[-1] > NEGLIGIBLE_LIKELIHOOD:
            break
    # mean square of the moves, weighted with the likelihood
    weight = np.exp(-0.5 * (np.array(rise) - min(rise)))
    moves = np.array(off)
    products = weight[:, None, None] * moves[:, :, None] * moves[:, None, :]
    steps = np.diff(distance)
    if not len(steps):
        return np.zeros((len(moved), len(moved)))
    whole = np.sum(0.5 * steps * (weight[1:] + weight[:-1]))
    parts = 0.5 * steps[:, None, None] * (products[1:] + products[:-1])
    return np.asarray(np.sum(parts, axis=0) / whole)


def with_enough_blocks(problem: Problem) -> Problem:
    """The problem, its blocks shortened until there are enough of them for its free parameters.

    Raises IdentificationError where they would have to be shorter than `SHORTEST_BLOCK`.
    """
    parameters = len(problem.free)
    length = sum(r.duration for r in problem.recordings)
    block = min(problem.block, max(SHORTEST_BLOCK, length / (BLOCKS_PER_PARAMETER * parameters)))
    found = replace(problem, block=block)
    if sum(int(b[-1]) + 1 for b in found.blocks) < parameters:
        names = ", ".join(r.name for r in problem.recordings)
        raise IdentificationError(
            f"{names}: {length:.0f} s in all is too short for {parameters} parameters; drive "
            f"{10 * np.ceil(0.1 * SHORTEST_BLOCK * parameters):.0f} s or more, or take another method, "
            "--method equation-error"
        )
    return found


def _refuse_inseparable(at: Point) -> None:
    """Refuses coefficients of which the data know only a combination, as equation-error does.

    Constants of the chain may be tied: the user did not choose them, and combinations of them are reported.
    """
    problem = at.runs.problem
    information = at.runs.information
    coefficients = np.array(problem.free) < problem.n_coefficients
    alive = np.flatnonzero(coefficients & (np.diag(information) > 0.0))
    if not len(alive):
        return
    scale = 1.0 / np.sqrt(np.diag(information)[alive])
    values, vectors = np.linalg.eigh(information[np.ix_(alive, alive)] * np.outer(scale, scale))
    if values[0] > TIED:
        return
    weights = np.abs(vectors[:, 0])
    names = [problem.names[problem.free[i]] for i in alive[weights > LISTED_WEIGHT * weights.max()]]
    raise IdentificationError(
        f"{', '.join(names)} can't be told apart: vary speed and command independently, or take one "
        "term out"
    )


def at_bounds(at: Point) -> Mask:
    """Which free parameters (p,) are at a bound, or as good as that."""
    problem = at.runs.problem
    low, high = problem.bounds
    theta = at.theta[list(problem.free)]
    reach = np.where(np.isfinite(high - low), AT_BOUND_SHARE * (high - low), 0.0)
    return np.asarray((theta <= low + reach) | (theta >= high - reach))
