# SPDX-License-Identifier: MIT
"""Marginal likelihood ratio of a changed boat to the unchanged one, in a window of poses.

Gustafsson, "The marginalized likelihood ratio test for detecting abrupt changes", IEEE Trans. Automatic Control
41 (1996). The integrals over the identification's errors and over the change are Laplace's approximation, about
parameters at which the filter has run (Kass and Raftery, 1995).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial.evaluation.comparison.cause_candidates import NO_CHANGE
from seatrial.monitoring.change_space import ChangeSpace, PhysicalChange, difference_quotients
from seatrial.monitoring.window_likelihood import Quadratic, Window
from seatrial.util.frames import Array, Mask
from seatrial.util.progress import over

NEGLIGIBLE = 12.0  # logarithm of the largest evidence of a noise over another's that is left out
ROUNDS = 4  # of linearisation and maximum
CLOSE = 0.3  # posterior standard deviations of a step that ends them
INNER_ROUNDS, HALVINGS, INNER_CLOSE = 20, 12, 1e-6  # of the search on one linearisation


@dataclass(frozen=True)
class Evidence:
    """The evidence of a change in a window: the mean over the noises that may have been in it."""

    change: PhysicalChange
    log_evidence: float


@dataclass(frozen=True)
class FittedChange(Evidence):
    """A change fitted to a window."""

    size: float | None  # [-]
    error: float | None  # [-] its standard error
    theta: Array  # (n,)
    covariance: Array  # (n, n)


def linear_evidences(space: ChangeSpace, quadratics: Sequence[Quadratic]) -> Array:
    """Log evidences (changes, noises) with every change linear in its unknowns, about the unchanged boat.

    Closed forms, without a search. -inf: with this noise no boat is as probable as the unchanged one with another.
    """
    found = np.full((len(space.changes), len(quadratics)), -np.inf)
    unchanged = [_normal_evidence(one, space.root) for one in quadratics]
    enough = max(unchanged) - NEGLIGIBLE
    for change, logs in zip(space.changes, found, strict=True):
        if not change.unknowns:
            logs[:] = unchanged
            continue
        root = np.hstack([space.root, space.slopes[change.cause, change.what]])
        for i, one in enumerate(quadratics):
            if one.most > enough:
                logs[i] = _normal_evidence(one, root)
    return found


def mean_over_noises(space: ChangeSpace, logs: Array) -> list[Evidence]:
    """The evidence of each change from those (changes, noises) of each noise."""
    return [
        Evidence(one, _mean(own)) for one, own in zip(space.changes, logs.tolist(), strict=True)
    ]


def probable_noises(logs: Array) -> Mask:
    """Which noises matter to the evidence of any change, by log evidences (changes, noises)."""
    return np.asarray((logs > logs.max(axis=1, keepdims=True) - NEGLIGIBLE).any(axis=0))


def _normal_evidence(quadratic: Quadratic, root: Array) -> float:
    """The logarithm of the integral of the likelihood over theta ~ N(at, root root')."""
    whitening, centre = quadratic.whitened
    spread = whitening @ root
    lower = np.linalg.cholesky(np.eye(len(centre)) + spread @ spread.T)
    left = np.linalg.solve(lower, centre)
    gain = 0.5 * float(centre @ centre - left @ left)
    return quadratic.value + gain - float(np.sum(np.log(np.diag(lower))))


def _mean(logs: Sequence[float]) -> float:
    """Logarithm of the mean of numbers that are given by their logarithms."""
    return float(np.logaddexp.reduce(logs) - np.log(len(logs)))


def linearised(space: ChangeSpace, windows: Sequence[Window]) -> list[Quadratic]:
    """The windows about the unchanged boat; none where it diverges in one."""
    found = [window.quadratic(space.wider, space.theta) for window in over(windows)]
    return [] if any(one is None for one in found) else [one for one in found if one is not None]


def fitted_changes(
    space: ChangeSpace, windows: Sequence[Window], quadratics: Sequence[Quadratic], noises: int
) -> list[FittedChange]:
    """Every change of the space, the most probable first; none where no change, or no other, can be fitted.

    windows: one interval with each probable noise; quadratics: `linearised` of them; noises: number of all.
    """
    found = []
    for change in over(space.changes):
        pairs = zip(windows, quadratics, strict=True)
        tried = (_fitted(space, change, window, start) for window, start in over([*pairs]))
        fits = [fit for fit in tried if fit]
        if not fits:
            continue
        best = max(fits, key=lambda fit: fit.log_evidence)
        # of other noises, and of those with which the changed boat diverges, the likelihood is 0
        logs = [fit.log_evidence for fit in fits] + [-np.inf] * (noises - len(fits))
        found.append(replace(best, log_evidence=_mean(logs)))
    causes = {one.change.cause for one in found}
    compared = NO_CHANGE in causes and len(causes) > 1
    return sorted(found, key=lambda one: -one.log_evidence) if compared else []


def log_ratio(found: Sequence[Evidence]) -> float:
    """Logarithm of the evidence of a change, the mean over causes, over that of no change."""
    none = [one.log_evidence for one in found if one.change.cause == NO_CHANGE]
    some = by_cause(found)
    return _mean([*some.values()]) - none[0] if none and some else 0.0


def by_cause(found: Sequence[Evidence]) -> dict[str, float]:
    """Logarithm of the evidence of each cause of a change, the mean over its cases (one for each thruster)."""
    logs: dict[str, list[float]] = {}
    for one in found:
        if one.change.cause != NO_CHANGE:
            logs.setdefault(one.change.cause, []).append(one.log_evidence)
    return {cause: _mean(own) for cause, own in logs.items()}


def _fitted(
    space: ChangeSpace, change: PhysicalChange, window: Window, start: Quadratic
) -> FittedChange | None:
    """The maximum of the posterior, by linearisations about it. None: the boat diverges there."""
    k = space.root.shape[1]
    x, quadratic = np.zeros(k + change.unknowns), start
    for _ in range(ROUNDS):
        begin = x
        x, jacobian, log = _maximum(space, change, quadratic, x)
        if np.linalg.norm(jacobian @ (x - begin)) < CLOSE:
            break
        again = window.quadratic(space.wider, _parameters(space, change, x))
        if again is None:
            return None
        quadratic = again
    x, _, log = _maximum(space, change, quadratic, x)
    near = np.concatenate([x[:k], change.inside(x[k:])])
    jacobian, slopes = _jacobian(space, change, quadratic, near), _slopes(space, change, near)
    spread = np.linalg.inv(jacobian.T @ jacobian)
    size = error = None
    if change.size is not None:
        size_of = change.size
        size = size_of(x[k:])
        along = difference_quotients(lambda phi: np.array([size_of(phi)]), near[k:])[0]
        error = float(np.sqrt(along @ spread[k:, k:] @ along))
    theta = _parameters(space, change, x)
    return FittedChange(change, log, size, error, theta, slopes @ spread @ slopes.T)


def _parameters(space: ChangeSpace, change: PhysicalChange, x: Array) -> Array:
    """theta (n,) of x (k + m,): errors of the identification and unknowns of the change, all of unit variance."""
    k = space.root.shape[1]
    return change.of(space.theta + space.root @ x[:k], x[k:])


def _slopes(space: ChangeSpace, change: PhysicalChange, x: Array) -> Array:
    """d theta / d x (n, k + m)."""
    k = space.root.shape[1]
    return change.slopes(space.theta + space.root @ x[:k], space.root, x[k:])


def _jacobian(space: ChangeSpace, change: PhysicalChange, quadratic: Quadratic, x: Array) -> Array:
    """Of the residuals of `_maximum`: those of the priors, then of the likelihood."""
    return np.vstack([np.eye(len(x)), quadratic.whitened[0] @ _slopes(space, change, x)])


def _maximum(
    space: ChangeSpace, change: PhysicalChange, quadratic: Quadratic, x: Array
) -> tuple[Array, Array, float]:
    """Gauss-Newton on one linearisation, from x (k + m,): the maximum, the Jacobian there, the log evidence."""
    root, centre = quadratic.whitened

    def residuals(y: Array) -> Array:
        theta = _parameters(space, change, y)
        return np.concatenate([y, root @ (theta - quadratic.at) - centre])

    now, jacobian = residuals(x), _jacobian(space, change, quadratic, x)
    for _ in range(INNER_ROUNDS if len(x) else 0):
        step, share = -np.linalg.lstsq(jacobian, now, rcond=None)[0], 1.0
        for _ in range(HALVINGS):
            after = residuals(x + share * step)
            if float(after @ after) <= float(now @ now):
                break
            share /= 2.0
        else:
            break
        moved = np.linalg.norm(jacobian @ (share * step))
        x, now = x + share * step, after
        jacobian = _jacobian(space, change, quadratic, x)
        if moved < INNER_CLOSE:
            break
    log = quadratic.value + 0.5 * float(centre @ centre) - 0.5 * float(now @ now)
    return x, jacobian, log - 0.5 * float(np.linalg.slogdet(jacobian.T @ jacobian)[1])
