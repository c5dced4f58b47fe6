# SPDX-License-Identifier: MIT
"""Marginal likelihood ratio of a changed boat to the unchanged one, in a window of poses.

Gustafsson, "The marginalized likelihood ratio test for detecting abrupt changes", IEEE Trans. Automatic Control
41 (1996). The integrals over the identification's errors and over the change are Laplace's approximation, about
parameters at which the filter has run (Kass and Raftery, 1995).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.evaluation.comparison.cause_candidates import NO_CHANGE
from seatrial.monitoring.change_space import ChangeSpace, PhysicalChange, difference_quotients
from seatrial.monitoring.window_likelihood import Quadratic, Window
from seatrial.util.frames import Array

ROUNDS = 4  # of linearisation and maximum
CLOSE = 0.3  # posterior standard deviations of a step that ends them
INNER_ROUNDS, HALVINGS, INNER_CLOSE = 20, 12, 1e-6  # of the search on one linearisation
LEAST_INFORMATION = 1e-12  # of the largest: less is round-off


@dataclass(frozen=True)
class Explained:
    """A change fitted to a window."""

    change: PhysicalChange
    log_evidence: float
    size: float | None  # [-]
    error: float | None  # [-] its standard error
    theta: Array  # (n,)
    covariance: Array  # (n, n)


def most_to_gain(space: ChangeSpace, seen: Sequence[Quadratic]) -> float:
    """Upper bound of `log_ratio`, about the unchanged boat: that of parameters without any prior."""
    none = next(change for change in space.changes if change.cause == NO_CHANGE)
    start = np.zeros(space.root.shape[1])
    unchanged = [_maximum(space, none, one, start)[3] for one in seen]
    most = max(one.value + 0.5 * float(np.sum(_whitened(one)[1] ** 2)) for one in seen)
    return most - float(np.logaddexp.reduce(unchanged) - np.log(len(unchanged)))


def linearised(space: ChangeSpace, several: Sequence[Window]) -> list[Quadratic]:
    """The windows about the unchanged boat; none where it diverges in one."""
    found = [window.quadratic(space.wider, space.theta) for window in several]
    return [] if any(one is None for one in found) else [one for one in found if one is not None]


def explained(
    space: ChangeSpace,
    several: Sequence[Window],
    seen: Sequence[Quadratic],
    rounds: int = ROUNDS,
) -> list[Explained]:
    """Every change of the space, the most probable first; the evidence is a mean over the windows' noise.

    seen: `linearised` of the windows; rounds: of further linearisations, 0 for a first look.
    """
    found = []
    for change in space.changes:
        fits = [
            fit for window, start in zip(several, seen, strict=True)
            if (fit := _fitted(space, window, change, start, rounds)) is not None
        ]  # fmt: skip
        if not fits:
            continue
        logs = np.array([fit.log_evidence for fit in fits])
        best = fits[int(np.argmax(logs))]
        whole = float(np.logaddexp.reduce(logs) - np.log(len(several)))
        found.append(Explained(change, whole, best.size, best.error, best.theta, best.covariance))
    return sorted(found, key=lambda one: -one.log_evidence)


def log_ratio(found: Sequence[Explained]) -> float:
    """Logarithm of the evidence of a change, the mean over causes, over that of no change."""
    none = [one.log_evidence for one in found if one.change.cause == NO_CHANGE]
    some: dict[str, list[float]] = {}
    for one in found:
        if one.change.cause != NO_CHANGE:
            some.setdefault(one.change.cause, []).append(one.log_evidence)
    if not none or not some:
        return 0.0
    each = [np.logaddexp.reduce(logs) - np.log(len(logs)) for logs in some.values()]
    return float(np.logaddexp.reduce(each) - np.log(len(each)) - none[0])


def _fitted(
    space: ChangeSpace, window: Window, change: PhysicalChange, start: Quadratic, rounds: int
) -> Explained | None:
    """The maximum of the posterior, by linearisations about it. None: the boat diverges there."""
    k, m = space.root.shape[1], change.unknowns
    x, seen = np.zeros(k + m), start
    for _ in range(rounds):
        x, step, jacobian, log = _maximum(space, change, seen, x)
        if np.linalg.norm(jacobian @ step) < CLOSE:
            break
        again = window.quadratic(space.wider, change.of(space.theta + space.root @ x[:k], x[k:]))
        if again is None:
            return None
        seen = again
    x, _, jacobian, log = _maximum(space, change, seen, x)
    spread = np.linalg.inv(jacobian.T @ jacobian)
    slopes = difference_quotients(lambda y: change.of(space.theta + space.root @ y[:k], y[k:]), x)
    size = error = None
    if change.size is not None:
        size_of = change.size
        size = size_of(x[k:])
        along = difference_quotients(lambda y: np.array([size_of(y)]), x[k:])[0]
        error = float(np.sqrt(along @ spread[k:, k:] @ along))
    theta = change.of(space.theta + space.root @ x[:k], x[k:])
    return Explained(change, log, size, error, theta, slopes @ spread @ slopes.T)


def _maximum(
    space: ChangeSpace, change: PhysicalChange, seen: Quadratic, x: Array
) -> tuple[Array, Array, Array, float]:
    """Gauss-Newton on one linearisation: the maximum, the move to it, its Jacobian, the log evidence.

    x (k + m,): errors of the identification and unknowns of the change, all of unit variance.
    """
    k = space.root.shape[1]
    root, centre = _whitened(seen)

    def residuals(y: Array) -> Array:
        theta = change.of(space.theta + space.root @ y[:k], y[k:])
        return np.concatenate([y, root @ (theta - seen.at) - centre])

    begin, now = x, residuals(x)
    for _ in range(INNER_ROUNDS if len(x) else 0):
        jacobian = difference_quotients(residuals, x)
        step, share = -np.linalg.lstsq(jacobian, now, rcond=None)[0], 1.0
        for _ in range(HALVINGS):
            after = residuals(x + share * step)
            if float(after @ after) <= float(now @ now):
                break
            share /= 2.0
        else:
            break
        x, now = x + share * step, after
        if np.linalg.norm(jacobian @ (share * step)) < INNER_CLOSE:
            break
    jacobian = difference_quotients(residuals, x)
    log = seen.value + 0.5 * float(centre @ centre) - 0.5 * float(now @ now)
    return x, x - begin, jacobian, log - 0.5 * float(np.linalg.slogdet(jacobian.T @ jacobian)[1])


def _whitened(seen: Quadratic) -> tuple[Array, Array]:
    """R (m, n) and c (m,): log L = value + |c|^2 / 2 - |R d - c|^2 / 2, d from `seen.at`."""
    values, vectors = np.linalg.eigh(0.5 * (seen.information + seen.information.T))
    kept = values > LEAST_INFORMATION * values.max(initial=0.0)
    root = (vectors[:, kept] * np.sqrt(values[kept])).T
    return root, (vectors[:, kept].T @ seen.gradient) / np.sqrt(values[kept])
