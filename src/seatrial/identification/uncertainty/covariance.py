# SPDX-License-Identifier: MIT
"""Sandwich covariance of the estimates, which holds for correlated innovations."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.identification.likelihood.optimiser import Point, at_bounds
from seatrial.identification.likelihood.problem import Problem
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Mask
from seatrial.util.statistics import LEAST_EIGENVALUE, inverse_of

SHRINKAGE_BLOCKS = 4.0  # blocks per parameter with which the scatter of the scores has weight 1/2
FEW_BLOCKS = 2.0  # blocks per parameter: with fewer, scatter below the information's is chance
SHORTEST_BLOCK = 4.0  # [s] innovations are correlated over less
BLOCKS_PER_PARAMETER = 1.2  # with fewer, blocks are shortened
# where the likelihood is followed from a bound: first distance in standard errors and in the range,
# factors from one to the next
FIRST_DISTANCE, LARGEST_FIRST_DISTANCE, FARTHER, NEARER = 0.5, 0.125, 2.0, 0.25
BOUND_EVALUATIONS = 8  # at most
STEEP_LIKELIHOOD = 3.0  # rise of -2 log likelihood at the first distance: it was too far
OPEN_RANGE = 8.0  # standard errors that stand for the range where there is none
NEGLIGIBLE_LIKELIHOOD = 12.0  # rise of -2 log likelihood beyond which it is followed no further
# of the largest entry: coefficients with less in a tied direction are not named
LEAST_INFORMATION = 1e-300  # against a division by 0
LISTED_WEIGHT = 0.1


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
    within = np.ix_(inside, inside)
    known = np.zeros((len(free), len(free)))[within]
    if prior is not None:
        known = prior.precision[np.ix_(free, free)][within]
    inverse = inverse_of(at.runs.information[within])
    covariance, factor = _shrunk(
        at.runs.scores[:, inside], at.runs.information[within], inverse, known
    )
    out = np.zeros((len(free), len(free)))
    out[within] = covariance
    # parameters at a bound may be off it: that widens the others
    for i in np.flatnonzero(held):
        out[within] += _one_sided_profile(at, int(i), inside, inverse, max(factor, 1.0))
    return out


def _shrunk(scores: Array, information: Array, inverse: Array, known: Array) -> tuple[Array, float]:
    """The covariance (p, p) from scores (blocks, p), and their scatter over that of independent innovations.

    information, its inverse, and its part from the prior (`known`): (p, p).
    """
    blocks = len(scores)
    informed = float(np.sum(inverse * (information - known)))  # parameters that the data determine
    # scatter of the scores; the fit took some of it
    scores = scores - scores.mean(axis=0)
    scores *= np.sqrt(blocks / max(blocks - informed / 2, blocks / 4))
    moves = scores @ inverse  # of the parameters by each block
    factor = float(np.sum(moves * scores)) / max(informed, LEAST_EIGENVALUE)
    if blocks < FEW_BLOCKS * informed:
        factor = max(factor, 1.0)
    # shrunk towards the information; one block has no scatter at all
    weight = blocks / (blocks + SHRINKAGE_BLOCKS * informed) if blocks > 1 else 0.0
    of_prior = inverse @ known @ inverse
    shrunk = weight * moves.T @ moves + (1.0 - weight) * factor * (inverse - of_prior)
    return shrunk + of_prior, factor


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
    normal = 1.0 / np.sqrt(
        max(own, LEAST_EIGENVALUE * at.runs.information[held, held], LEAST_INFORMATION)
    )
    value = float(at.theta[free[held]])
    side = 1.0 if value - low < high - value else -1.0
    reach = high - low if np.isfinite(high - low) else OPEN_RANGE * normal

    def away(d: float) -> tuple[float, Array] | None:
        """Rise of the scaled likelihood this far from the bound, the others along with it, and their moves."""
        theta = at.theta.copy()
        theta[free[inside]] += side * d * moved
        theta[free[held]] += side * d
        runs = problem.run_filter(problem.clipped(theta), at.noise, repeatable=False)
        if not np.isfinite(runs.cost):
            return None
        gradient = runs.gradient[inside]
        step = inverse_of(runs.information[np.ix_(inside, inside)]) @ gradient
        return (runs.cost - float(gradient @ step) - at.runs.cost) / factor, side * d * moved + step

    distance, rise, off = [0.0], [0.0], [np.zeros(len(moved))]
    d = min(FIRST_DISTANCE * normal, LARGEST_FIRST_DISTANCE * reach)
    for _ in range(BOUND_EVALUATIONS):
        if d > reach:
            break
        found = away(d)
        steep = len(distance) == 1 and (found is None or found[0] > STEEP_LIKELIHOOD)
        if steep:  # nearer first
            d *= NEARER
            continue
        if found is None:
            break
        distance.append(d)
        rise.append(found[0])
        off.append(found[1])
        if rise[-1] > NEGLIGIBLE_LIKELIHOOD:
            break
        d *= FARTHER
    return _mean_square(np.array(distance), np.array(rise), np.array(off))


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


def with_enough_blocks(problem: Problem) -> Problem:
    """The problem, its blocks shortened until there are enough of them for its free parameters.

    Only time with usable poses counts. Raises IdentificationError where blocks would have to be shorter than
    `SHORTEST_BLOCK`.
    """
    parameters = len(problem.free)
    length = sum(r.duration for r in problem.recordings)
    covered = min(length, SHORTEST_BLOCK * replace(problem, block=SHORTEST_BLOCK).n_blocks)
    block = min(problem.block, max(SHORTEST_BLOCK, covered / (BLOCKS_PER_PARAMETER * parameters)))
    found = replace(problem, block=block)
    if found.n_blocks < parameters:
        names = ", ".join(r.name for r in problem.recordings)
        wanted = 10 * np.ceil(0.1 * SHORTEST_BLOCK * parameters)
        gaps = gaps_text(problem.recordings)
        repair = (
            f": {gaps}. Repair the log (seatrial inspect names the faults), or" if gaps else ";"
        )
        raise IdentificationError(
            f"{names}: {length:.0f} s in all is too short for {parameters} parameters{repair} drive "
            f"{wanted:.0f} s or more{' without gaps' if gaps else ''}, or take another method, "
            "--method equation-error"
        )
    return found


def gaps_text(recordings: Sequence[Recording]) -> str:
    """Number, lengths and share of the gaps of a block or longer without usable poses; empty: there are none."""
    gaps = np.concatenate(
        [np.diff(r.t[r.valid], prepend=0.0, append=r.duration) for r in recordings]
    )
    gaps = gaps[gaps >= SHORTEST_BLOCK]
    if not len(gaps):
        return ""
    share = gaps.sum() / sum(r.duration for r in recordings)
    lengths = f"{gaps.min():.0f} to {gaps.max():.0f} s" if len(gaps) > 1 else f"{gaps[0]:.0f} s"
    number = f"{len(gaps)} gaps" if len(gaps) > 1 else "one gap"
    return f"no usable poses in {number} of {lengths}, {100.0 * share:.0f} % of the time"


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
    if values[0] > LEAST_EIGENVALUE:
        return
    weights = np.abs(vectors[:, 0])
    names = [problem.names[problem.free[i]] for i in alive[weights > LISTED_WEIGHT * weights.max()]]
    raise IdentificationError(
        f"{', '.join(names)} can't be told apart: vary speed and command independently, or take one "
        "term out"
    )
