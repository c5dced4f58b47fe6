# SPDX-License-Identifier: MIT
"""Which one physical change explains the difference of two models best: posterior probabilities.

Every candidate is a map g(theta, phi) from A's coefficients to B's, with few unknowns phi and a Gaussian
prior on them. Its evidence is Laplace's approximation (MacKay, Information Theory, chapter 27; Kass and
Raftery 1995); the candidates are equally probable before, two causes at once a tenth as probable.
"""

from collections.abc import Callable, Sequence

import msgspec
import numpy as np

from seatrial.boat.model import Model
from seatrial.evaluation.comparison.cause_candidates import (
    CAUSES,
    TWO,
    TWO_AT_ONCE,
    Candidate,
    Problem,
    candidates,
)
from seatrial.evaluation.comparison.parameters import Pair, View, estimated_in_both, thrust_and_drag
from seatrial.evaluation.comparison.thrust_curves import stages_apart
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Array
from seatrial.util.statistics import inverse_of

ROUNDS, HALVINGS, CONVERGED = 40, 20, 1e-9  # of the search; relative step that ends it
SLOPE_STEP = 1e-6  # of central differences, in units of the unknowns


class Cause(msgspec.Struct, frozen=True):
    """One candidate. Probabilities of all add up to 1.

    cause: one of `CAUSES`
    probability: by the evidence of all candidates
    change: [-] relative, that fits best; None: it has no single one
    what: of what: a quantity, or a thruster
    log_evidence: less that of the best; of two causes with their prior
    """

    cause: str
    probability: float
    change: float | None = None
    what: str = ""
    log_evidence: float = 0.0


def causes(a: Model, b: Model, found: Sequence[Pair], seen: tuple[View, View]) -> list[Cause]:
    """All candidates, the most probable first; none where no coefficient can be compared."""
    problem = _problem(a, b, found, seen)
    if problem is None:
        return []
    best: list[tuple[float, Candidate, Array]] = []
    for cause in CAUSES:
        own = [one for one in candidates(problem) if one.cause == cause]
        tried = [(*evidence(problem, one), one) for one in own]
        if not tried:
            continue
        _, phi, one = max(tried, key=lambda t: t[0])
        whole = np.logaddexp.reduce([t[0] for t in tried]) - np.log(len(tried))
        whole += np.log(TWO_AT_ONCE) if cause == TWO else 0.0
        best.append((float(whole), one, phi))
    most = max(log for log, _, _ in best)
    total = sum(np.exp(log - most) for log, _, _ in best)
    out = [
        Cause(
            one.cause,
            float(np.exp(log - most) / total),
            None if one.shown is None else one.shown(phi),
            one.described(phi) if one.cause == TWO else one.what,
            log - most,
        )
        for log, one, phi in best
    ]
    return sorted(out, key=lambda cause: -cause.probability)


def _problem(a: Model, b: Model, found: Sequence[Pair], seen: tuple[View, View]) -> Problem | None:
    """Coefficients that both estimate; no thrust where its curves differ in stages."""
    left_out: set[str] = set()
    if stages_apart(a, b, any(view.converted for view in seen)):
        left_out = set().union(*(thrust_and_drag(a, axis)["thrust"] for axis in range(3)))
    names = [
        pair.name
        for pair in found
        if pair.name in a.values and pair.name not in left_out and estimated_in_both(pair)
    ]
    if not names:
        return None
    values, roots = [], []
    for view in seen:
        own, covariance = view.of(names)
        values.append(own)
        roots.append(np.asarray(np.linalg.cholesky(inverse_of(covariance)).T))
    return Problem(a, tuple(names), (values[0], values[1]), (roots[0], roots[1]))


def evidence(problem: Problem, candidate: Candidate) -> tuple[float, Array]:
    """Logarithm of the evidence, but for a constant of all candidates; the unknowns (m,) that fit best.

    Raises SeatrialError where the evidence is not finite.
    """
    n, m = len(problem.names), len(candidate.covariance)
    scale = np.concatenate([problem.units, np.sqrt(np.diag(candidate.covariance))])
    root = np.linalg.cholesky(np.linalg.inv(candidate.covariance)).T if m else np.zeros((0, 0))

    def residuals(scaled: Array) -> Array:
        """Of A's coefficients, of B's, and of the unknowns' prior; scaled (n + m,) in their units."""
        theta, phi = np.split(scaled * scale, [n])
        a, b = problem.values
        off = a - theta, b - candidate.change(theta, phi)
        own = [r @ apart for r, apart in zip(problem.roots, off, strict=True)]
        return np.concatenate([*own, root @ phi])

    # 1. Gauss-Newton over A's coefficients and the unknowns, from no change.
    best = _minimum(residuals, np.concatenate([problem.values[0], np.zeros(m)]) / scale)
    # 2. Laplace: the cost, and the widths of likelihood and prior (units are those of `scale`).
    cost = float(np.sum(residuals(best) ** 2))
    jacobian = _slopes(residuals, best)
    likelihood = float(np.linalg.slogdet(jacobian.T @ jacobian)[1])
    correlation = candidate.covariance / np.outer(scale[n:], scale[n:]) if m else np.zeros((0, 0))
    prior = float(np.linalg.slogdet(correlation)[1]) if m else 0.0
    log = -0.5 * (cost + likelihood + prior)
    if not np.isfinite(log):
        raise SeatrialError(f"the evidence of '{candidate.cause}' is not finite")
    return log, best[n:] * scale[n:]


def _minimum(residuals: Callable[[Array], Array], start: Array) -> Array:
    """Least squares by Gauss-Newton with halved steps."""
    best = start
    for _ in range(ROUNDS):
        step = -np.linalg.lstsq(_slopes(residuals, best), residuals(best), rcond=None)[0]
        share, before = 1.0, float(np.sum(residuals(best) ** 2))
        for _ in range(HALVINGS):
            if float(np.sum(residuals(best + share * step) ** 2)) <= before:
                break
            share /= 2.0
        else:
            return best
        best = best + share * step
        if np.max(np.abs(share * step)) < CONVERGED:
            return best
    return best


def _slopes(residuals: Callable[[Array], Array], at: Array) -> Array:
    """Central differences (residuals, unknowns)."""
    steps = SLOPE_STEP * np.eye(len(at))
    columns = [(residuals(at + step) - residuals(at - step)) / (2.0 * SLOPE_STEP) for step in steps]
    return np.stack(columns, axis=1)
