# SPDX-License-Identifier: MIT
"""Block bootstrap: the spread of estimates over recordings put together anew from their blocks.

Errors may be correlated, but hardly over longer than a block (Künsch, Annals of Statistics 17,
1989). A block that is drawn twice counts twice in the likelihood; the filter itself runs through
the recording as it is, so that no seam is made.
"""

import numpy as np

from seatrial.identification.likelihood.optimiser import Point, step_within
from seatrial.identification.solution import Fit
from seatrial.util.frames import Array
from seatrial.util.parallel import spread

REPLICATES = 200
STEPS = 6  # of Gauss and Newton's; one or two do where the likelihood is nearly quadratic
SETTLED = 0.01  # of the cost, that another step promises
HALVINGS = 4  # of a step that leads uphill
LEVEL = 95.0  # [%] of the intervals


def bootstrap(fit: Fit, replicates: int = REPLICATES, seed: int = 0) -> Array:
    """Estimates (replicates, p) of the free parameters, the noise held; in the order of `fit.names`.

    A replicate's search ends where a step no longer gains, or leads uphill however short it is.
    """
    rng = np.random.default_rng(seed)
    blocks = [(r.t // fit.problem.block).astype(np.int64) for r in fit.problem.recordings]
    sizes = [int(b.max()) + 1 for b in blocks]
    total = sum(sizes)
    first = np.cumsum([0, *sizes[:-1]])
    draws = rng.multinomial(total, np.full(total, 1.0 / total), size=replicates).astype(float)

    def one(draw: Array) -> Array:
        return _refit(fit, [draw[f + b] for f, b in zip(first, blocks, strict=True)])

    return np.array(spread(one, draws))


def intervals(draws: Array) -> Array:
    """Percentile intervals (p, 2) of replicates (n, p).

    At the order statistics (n + 1) q (Davison, Hinkley, section 5.3.1), outside of which a further
    draw lies as often as `LEVEL` says, few as the draws may be; from 39 on they exist.
    """
    tail = (100.0 - LEVEL) / 2.0
    return np.percentile(draws, [tail, 100.0 - tail], axis=0, method="weibull").T


def _refit(fit: Fit, counts: list[Array]) -> Array:
    """The free parameters (p,) where poses count so often; Gauss-Newton from the optimum."""
    at = Point(fit.theta, fit.noise, fit.problem.passes(fit.theta, fit.noise, counts))
    for _ in range(STEPS):
        move, promised = step_within(at, 0.0)
        if promised < SETTLED:
            break
        for _ in range(HALVINGS):
            theta = at.theta + move
            found = fit.problem.passes(theta, fit.noise, counts)
            if found.cost < at.passes.cost:
                break
            move = 0.5 * move
        else:
            break
        at = Point(theta, fit.noise, found)
    return at.theta[list(fit.problem.free)]
