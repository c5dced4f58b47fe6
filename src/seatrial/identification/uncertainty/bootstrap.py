# SPDX-License-Identifier: MIT
"""Block bootstrap: the spread of estimates over recordings resampled from their blocks.

Innovations may be correlated, but hardly over longer than a block (Künsch, Annals of Statistics 17,
1989). A block that is drawn twice counts twice in the likelihood; the filter itself runs through
the unchanged recording, so that there are no seams.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import Point, bounded_step
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.solution import Fit
from seatrial.util.frames import Array
from seatrial.util.parallel import farmed

BOOTSTRAP_CONVERGED = 0.01  # fall of -2 log likelihood that another step still promises
INTERVAL_LEVEL = 95.0  # [%]


def bootstrap(fit: Fit, replicates: int, seed: int = 0) -> Array:
    """Estimates (replicates, p) of the free parameters, the noise held; in the order of `fit.names`.

    A replicate ends where a step promises no more, or leads uphill however short it is.
    """
    rng = np.random.default_rng(seed)
    blocks = [(r.t // fit.problem.block).astype(np.int64) for r in fit.problem.recordings]
    sizes = [int(b.max()) + 1 for b in blocks]
    total = sum(sizes)
    first = np.cumsum([0, *sizes[:-1]])
    places = [f + b for f, b in zip(first, blocks, strict=True)]
    draws = rng.multinomial(total, np.full(total, 1.0 / total), size=replicates).astype(float)
    # `replace`: without what the problem has computed from itself, which can't travel to other processes
    optimum = _Optimum(replace(fit.problem), fit.theta, fit.noise, places)
    return np.array(farmed(_refit, optimum, draws, "bootstrap"))


@dataclass(frozen=True)
class _Optimum:
    """What all replicates begin from."""

    problem: Problem
    theta: Array  # all parameters
    noise: Array  # (12,)
    places: list[NDArray[np.int64]]  # of every recording, the number of each pose's block


def intervals(draws: Array) -> Array:
    """Percentile intervals (p, 2) of replicates (n, p).

    At the order statistics (n + 1) q (Davison, Hinkley, section 5.3.1), which cover a further draw with
    probability `INTERVAL_LEVEL` even for few draws; they exist from 39 on.
    """
    tail = (100.0 - INTERVAL_LEVEL) / 2.0
    return np.percentile(draws, [tail, 100.0 - tail], axis=0, method="weibull").T


def _refit(fit: _Optimum, draw: Array) -> Array:
    """The free parameters (p,) with these weights (blocks,) of the blocks; Gauss-Newton from the optimum."""
    counts = [draw[place] for place in fit.places]
    at = Point(fit.theta, fit.noise, filter_along(fit.problem, fit.theta, fit.noise, counts))
    for _ in range(6):  # one or two do where the likelihood is nearly quadratic
        move, promised = bounded_step(at, 0.0)
        if promised < BOOTSTRAP_CONVERGED:
            break
        for _ in range(4):
            theta = at.theta + move
            found = filter_along(fit.problem, theta, fit.noise, counts)
            if found.cost < at.runs.cost:
                break
            move = 0.5 * move
        else:
            break
        at = Point(theta, fit.noise, found)
    return at.theta[list(fit.problem.free)]
