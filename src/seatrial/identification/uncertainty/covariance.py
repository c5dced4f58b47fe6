# SPDX-License-Identifier: MIT
"""Sandwich covariance of the estimates, which holds for correlated innovations; and the errors of lags.

A lag delays thrust as a latency does; they differ in how far the lag spreads thrust in time, which is its square.
So the square has about the same error everywhere. Near 0 the likelihood of the lag itself is flat, and its
curvature at the maximum makes any lag look certain.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import at_bounds
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.uncertainty.profile_line import one_sided_profile
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Mask
from seatrial.util.parallel import spread
from seatrial.util.statistics import LEAST_EIGENVALUE, NORMAL_95, inverse_of

SHRINKAGE_BLOCKS = 4.0  # blocks per parameter with which the scatter of the scores has weight 1/2
FEW_BLOCKS = 2.0  # blocks per parameter: with fewer, scatter below the information's is chance
SHORTEST_BLOCK = 4.0  # [s] innovations are correlated over less
BLOCKS_PER_PARAMETER = 1.2  # with fewer, blocks are shortened
PRIOR_SHARE = 0.5  # of a lag's information: with more from the prior, its error is the prior's


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
    for wider in spread(
        lambda i: one_sided_profile(at, i, inside, inverse, max(factor, 1.0)),
        np.flatnonzero(held).tolist(),
    ):
        out += wider
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
    names = [problem.names[problem.free[i]] for i in alive[weights > 0.1 * weights.max()]]
    raise IdentificationError(
        f"{', '.join(names)} can't be told apart: vary speed and command independently, or take one "
        "term out"
    )


def with_lag_by_square(at: Point, covariance: Array) -> Array:
    """The covariance (p, p) with the errors of lags by `lag_error`, and those correlated with them.

    Unchanged where most information about the lag is the prior's: that is about the lag itself.
    """
    out, problem = covariance, at.runs.problem
    for k, i in enumerate(problem.free):
        variance = float(out[k, k])
        before = 0.0 if problem.prior is None else variance * float(problem.prior.precision[i, i])
        if problem.names[i].partition(".")[0] == "lag" and variance > 0.0 and before < PRIOR_SHARE:
            wider = lag_error(float(at.theta[i]), float(np.sqrt(variance))) ** 2
            out = out + (wider / variance - 1.0) / variance * np.outer(out[k], out[k])
    return out


def lag_error(lag: float, error: float) -> float:
    """Standard error [s] of a lag, whose `error` by curvature gives a 95 % interval of its square.

    Where that interval includes 0, 1.96 of it reach the farther end; far from 0, the root mean square of both
    ends' distances. So between 94 and 97.5 % of the intervals hold, whatever the lag
    (`tests/test_uncertainty_lag.py`).
    """
    square, reach = lag**2, NORMAL_95 * 2.0 * lag * error
    low, high = np.sqrt(max(square - reach, 0.0)), np.sqrt(square + reach)
    farther, both = max(lag - low, high - lag), np.hypot(lag - low, high - lag) / np.sqrt(2.0)
    long = low / lag if lag > 0.0 else 0.0
    return float((long * both + (1.0 - long) * farther) / NORMAL_95)
