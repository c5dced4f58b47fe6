# SPDX-License-Identifier: MIT
"""How certain the estimates are: a covariance that holds where errors are correlated."""

from dataclasses import replace

import numpy as np

from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.likelihood.problem import Problem
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Mask
from seatrial.util.statistics import LEAST_EIGENVALUE, inverse_of

SHRINKAGE_BLOCKS = 4.0  # blocks a parameter at which half of the scatter is believed
FEW_BLOCKS = (
    2.0  # blocks a parameter, below which scatter below what the information says is chance
)
SHORTEST_BLOCK = 4.0  # [s] of a block: the filter's errors are correlated over less
# shares of a range, at which the likelihood beside a bound is looked at
BOUND_DISTANCES = 0.5 ** np.arange(12, 0, -1)
NEGLIGIBLE_LIKELIHOOD = 12.0  # fall of twice its logarithm that is followed no further
AT_BOUND_SHARE = 1e-4  # of a range, within which of a bound a parameter is at it
BLOCKS_PER_PARAMETER = 1.2  # blocks a parameter, from which on they are shortened


def sandwich_covariance(at: Point, inside: Mask | None = None) -> Array:
    """Of the information and the scatter of scores over blocks, since errors may be correlated.

    inside: (p,) free parameters that may move, the others stay, with 0; by default all that did not
    end at a bound.

    The scatter of few blocks is uncertain itself. It is drawn towards what the information says of
    it, times a factor for all of it, which the blocks do know: the fewer blocks a parameter, the
    more so (Ledoit and Wolf, J. Multivariate Analysis 88, 2004, for the idea).
    Raises IdentificationError where coefficients can't be told apart.
    """
    problem = at.runs.problem
    prior, free = problem.prior, list(problem.free)
    if prior is None:
        _refuse_inseparable(at)
    held = at_bounds(at) if inside is None else np.zeros(len(free), dtype=bool)
    inside = ~at_bounds(at) if inside is None else inside
    scores = at.runs.scores[:, inside]
    information = at.runs.information[np.ix_(inside, inside)]
    blocks, p = scores.shape
    known = np.zeros((p, p)) if prior is None else prior.precision[np.ix_(free, free)][
        np.ix_(inside, inside)
    ]  # fmt: skip
    inverse = inverse_of(information)
    told = float(np.sum(inverse * (information - known)))  # parameters, as far as by the recordings
    scores = scores - scores.mean(axis=0)
    scores *= np.sqrt(blocks / max(blocks - told / 2, blocks / 4))  # some was fitted away
    moves = scores @ inverse  # by a block
    factor = float(np.sum(moves * scores)) / max(told, LEAST_EIGENVALUE)
    if blocks < FEW_BLOCKS * told:
        factor = max(factor, 1.0)
    share = blocks / (blocks + SHRINKAGE_BLOCKS * told) if blocks > 1 else 0.0  # one has no scatter
    said = inverse @ known @ inverse
    drawn = share * moves.T @ moves + (1.0 - share) * factor * (inverse - said)
    out = np.zeros((len(free), len(free)))
    out[np.ix_(inside, inside)] = drawn + said
    for i in np.flatnonzero(held):
        out[np.ix_(inside, inside)] += _one_sided_profile(
            at, int(i), inside, inverse, max(factor, 1.0)
        )
    return out


def _one_sided_profile(at: Point, held: int, inside: Mask, inverse: Array, factor: float) -> Array:
    """What it adds to the covariance (p, p) of the parameters inside that one at its bound may be off it.

    A lag that ended at nothing leaves its latency as uncertain as that. The likelihood is far from normal
    there: so it is followed from the bound, the others where they are likeliest then, to a step.
    """
    problem, free = at.runs.problem, np.array(at.runs.problem.free)
    low, high = (float(bound[held]) for bound in problem.bounds)
    across = at.runs.information[inside, held]
    moved = -inverse @ across
    own = float(at.runs.information[held, held] + across @ moved)
    normal = 1.0 / np.sqrt(max(own, LEAST_EIGENVALUE * at.runs.information[held, held], 1e-300))
    value = float(at.theta[free[held]])
    side = 1.0 if value - low < high - value else -1.0
    reach = high - low if np.isfinite(high - low) else 8.0 * normal
    distance, fall, off = [0.0], [0.0], [np.zeros(len(moved))]
    for d in reach * BOUND_DISTANCES:
        theta = at.theta.copy()
        theta[free[inside]] += side * d * moved
        theta[free[held]] += side * d
        runs = problem.run_filter(problem.clipped(theta), at.noise, repeatable=False)
        if not np.isfinite(runs.cost):
            break
        gradient = runs.gradient[inside]
        step = inverse_of(runs.information[np.ix_(inside, inside)]) @ gradient
        distance.append(float(d))
        fall.append((runs.cost - float(gradient @ step) - at.runs.cost) / factor)
        off.append(side * d * moved + step)
        if fall[-1] > NEGLIGIBLE_LIKELIHOOD:
            break
    weight = np.exp(-0.5 * (np.array(fall) - min(fall)))
    ways = np.array(off)
    products = weight[:, None, None] * ways[:, :, None] * ways[:, None, :]
    steps = np.diff(distance)
    if not len(steps):
        return np.zeros((len(moved), len(moved)))
    whole = np.sum(0.5 * steps * (weight[1:] + weight[:-1]))
    parts = 0.5 * steps[:, None, None] * (products[1:] + products[:-1])
    return np.asarray(np.sum(parts, axis=0) / whole)


def with_enough_blocks(problem: Problem) -> Problem:
    """The problem with blocks so short that there are enough of them for its free parameters.

    Raises IdentificationError where they would have to be shorter than `SHORTEST`.
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
    """Refuses coefficients of which the data know only a sum, as equation-error does.

    Constants of the chain may be tied: nobody wrote them, and what is known of them is said later.
    """
    problem = at.runs.problem
    information = at.runs.information
    coefficients = np.array(problem.free) < problem.n_coefficients
    alive = np.flatnonzero(coefficients & (np.diag(information) > 0.0))
    if not len(alive):
        return
    scale = 1.0 / np.sqrt(np.diag(information)[alive])
    values, vectors = np.linalg.eigh(information[np.ix_(alive, alive)] * np.outer(scale, scale))
    if values[0] > LEAST_EIGENVALUE:
        return
    weights = np.abs(vectors[:, 0])
    names = [problem.names[problem.free[i]] for i in alive[weights > 0.1 * weights.max()]]
    raise IdentificationError(
        f"{', '.join(names)} can't be told apart: vary speed and command independently, or take one "
        "term out"
    )


def at_bounds(at: Point) -> Mask:
    """Which free parameters ended at a bound, or as good as that: the data say no more of them."""
    problem = at.runs.problem
    low, high = problem.bounds
    theta = at.theta[list(problem.free)]
    reach = np.where(np.isfinite(high - low), AT_BOUND_SHARE * (high - low), 0.0)
    return np.asarray((theta <= low + reach) | (theta >= high - reach))
