# SPDX-License-Identifier: MIT
"""Block bootstrap: the spread of estimates over recordings put together anew from their blocks.

Errors may hang together, but hardly over longer than a block (Künsch, Annals of Statistics 17,
1989). A block that is drawn twice counts twice in the likelihood; the filter itself runs through
the recording as it is, so that no seam is made.
"""

import numpy as np

from seatrial.causal import spread
from seatrial.frames import Array
from seatrial.identify.output_error import Fit
from seatrial.identify.problem import Passes

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
    blocks = [(r.t // fit.settings.block).astype(np.int64) for r in fit.problem.recordings]
    sizes = [int(b.max()) + 1 for b in blocks]
    total = sum(sizes)
    first = np.cumsum([0, *sizes[:-1]])
    draws = rng.multinomial(total, np.full(total, 1.0 / total), size=replicates).astype(float)

    def one(draw: Array) -> Array:
        return _refit(fit, [draw[f + b] for f, b in zip(first, blocks, strict=True)])

    return np.array(spread(one, draws))


def intervals(draws: Array) -> Array:
    """Percentile intervals (p, 2) of replicates (n, p)."""
    tail = (100.0 - LEVEL) / 2.0
    return np.percentile(draws, [tail, 100.0 - tail], axis=0).T


def _refit(fit: Fit, counts: list[Array]) -> Array:
    """The free parameters (p,) where poses count so often; Gauss-Newton from the optimum."""
    problem, theta = fit.problem, fit.theta
    at = problem.passes(theta, fit.noise, counts)
    for _ in range(STEPS):
        moved, promised = _moved(at, theta)
        if promised < SETTLED:
            break
        found = problem.passes(moved, fit.noise, counts)
        for _ in range(HALVINGS):
            if found.cost < at.cost:
                break
            moved = 0.5 * (theta + moved)
            found = problem.passes(moved, fit.noise, counts)
        if not found.cost < at.cost:
            break
        theta, at = moved, found
    return theta[list(problem.free)]


def _moved(at: Passes, theta: Array) -> tuple[Array, float]:
    """All parameters after a step, and the cost's fall that it promises.

    What the step would take beyond its bound goes to the bound, and the others follow.
    """
    free, H, g = list(at.problem.free), at.information, at.gradient
    step = np.linalg.lstsq(H, g, rcond=None)[0]
    held = np.zeros(len(free), dtype=bool)
    for _ in free:
        wanted = theta.copy()
        wanted[free] += step
        allowed = (at.problem.bounded(wanted) - theta)[free]
        beyond = (allowed != step) & ~held
        if not beyond.any():
            break
        held |= beyond
        step = np.where(held, allowed, 0.0)
        rest = np.flatnonzero(~held)
        step[rest] = np.linalg.lstsq(H[np.ix_(rest, rest)], (g - H @ step)[rest], rcond=None)[0]
    moved = theta.copy()
    moved[free] += step
    return at.problem.bounded(moved), float(2.0 * step @ g - step @ H @ step)
