# SPDX-License-Identifier: MIT
"""Block bootstrap: the spread of estimates over recordings resampled from their blocks.

Innovations may be correlated, but hardly over longer than a block (Künsch, Annals of Statistics 17,
1989). A block that is drawn twice counts twice in the likelihood; the filter itself runs through
the unchanged recording, so that there are no seams.
"""

import numpy as np

from seatrial.identification.likelihood.optimiser import Point, bounded_step
from seatrial.identification.solution import Fit
from seatrial.util.frames import Array
from seatrial.util.parallel import spread

BOOTSTRAP_REPLICATES = 200
# Gauss-Newton steps at most; one or two do where the likelihood is nearly quadratic
BOOTSTRAP_STEPS = 6
BOOTSTRAP_CONVERGED = 0.01  # fall of -2 log likelihood that another step still promises
STEP_HALVINGS = 4  # of a step that leads uphill
INTERVAL_LEVEL = 95.0  # [%]


def bootstrap(fit: Fit, replicates: int = BOOTSTRAP_REPLICATES, seed: int = 0) -> Array:
    """Estimates (replicates, p) of the free parameters, the noise held; in the order of `fit.names`.

    A replicate ends where a step promises no more, or leads uphill however short it is.
    """
    rng = np.random.default_rng(seed)
    blocks = [(r.t // fit.problem.block).astype(np.int64) for r in fit.problem.recordings]
    sizes = [int(b.max()) + 1 for b in blocks]
    total = sum(sizes)
    first = np.cumsum([0, *sizes[:-1]])
    draws = rng.multinomial(total, np.full(total, 1.0 / total), size=replicates).astype(float)

    def one(draw: Array) -> Array:
        return _refit(fit, [draw[f + b] for f, b in zip(first, blocks, strict=True)])

    return np.array(spread(one, draws, "bootstrap"))


def intervals(draws: Array) -> Array:
    """Percentile intervals (p, 2) of replicates (n, p).

    At the order statistics (n + 1) q (Davison, Hinkley, section 5.3.1), which cover a further draw with
    probability `INTERVAL_LEVEL` even for few draws; they exist from 39 on.
    """
    tail = (100.0 - INTERVAL_LEVEL) / 2.0
    return np.percentile(draws, [tail, 100.0 - tail], axis=0, method="weibull").T


def _refit(fit: Fit, counts: list[Array]) -> Array:
    """The free parameters (p,) with these weights of the poses; Gauss-Newton from the optimum."""
    at = Point(fit.theta, fit.noise, fit.problem.run_filter(fit.theta, fit.noise, counts))
    for _ in range(BOOTSTRAP_STEPS):
        move, promised = bounded_step(at, 0.0)
        if promised < BOOTSTRAP_CONVERGED:
            break
        for _ in range(STEP_HALVINGS):
            theta = at.theta + move
            found = fit.problem.run_filter(theta, fit.noise, counts)
            if found.cost < at.runs.cost:
                break
            move = 0.5 * move
        else:
            break
        at = Point(theta, fit.noise, found)
    return at.theta[list(fit.problem.free)]
