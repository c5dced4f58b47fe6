# SPDX-License-Identifier: MIT
"""Record length: standard errors against the length of the recordings, and the length that halves them.

The information of the poses up to a time, and of each recording, is known. Both are scaled by the ratio of the
sandwich's variance to that of independent innovations.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.identification.console import minutes as spelled
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.optimiser import at_bounds
from seatrial.identification.solution import Fit
from seatrial.identification.uncertainty.parameter_verdict import (
    SHARP_ERROR,
    ParameterVerdict,
    verdict_of,
)
from seatrial.util.format import table
from seatrial.util.frames import Array
from seatrial.util.statistics import pseudo_inverse

LENGTH_SHARES = (0.25, 0.5, 0.75, 1.0)  # of every recording, from its start
# [min] between which the length for half the error is sought
SHORTEST_MORE, LONGEST_MORE = 0.1, 1e4
ALONE_BETTER = 0.8  # times the length of all recordings: with less, one of them alone is proposed


@dataclass(frozen=True)
class RecordLength:
    """Standard errors against the recorded length, and the further length that halves them."""

    names: tuple[str, ...]  # (p,)
    values: Array  # (p,)
    lengths: Array  # (q,) [min]
    errors: Array  # (q, p) standard errors after these; infinite: not identifiable yet
    recordings: tuple[str, ...]  # (r,)
    more: Array  # (r, p) [min] more like one recording that halve an error; infinite: never


def accuracy_by_length(fit: Fit) -> RecordLength:
    """Standard errors after a quarter, a half, three quarters, the whole; the length that halves them.

    Parameters at a bound have no standard error, and are left out.
    """
    problem = fit.problem
    inside = np.flatnonzero(~at_bounds(fit.point))
    square = np.ix_(inside, inside)
    total = sum(r.duration for r in problem.recordings) / 60.0  # [min]
    whole = [own[square] for own in _own(fit)]
    excess = np.sqrt(np.diag(fit.covariance)[inside] / np.square(_errors(_sum(whole))))
    parts = [_sum(_own(fit, part))[square] for part in LENGTH_SHARES[:-1]] + [_sum(whole)]
    errors = np.array([_errors(part) for part in parts])
    rates = [w / (r.duration / 60.0) for w, r in zip(whole, problem.recordings, strict=True)]
    return RecordLength(
        tuple(fit.names[i] for i in inside),
        fit.theta[list(problem.free)][inside],
        total * np.array(LENGTH_SHARES),
        np.multiply(errors, excess, out=np.full_like(errors, np.inf), where=np.isfinite(errors)),
        tuple(r.name for r in problem.recordings),
        np.array([_halved(_sum(whole), rate) for rate in rates]),
    )


def record_length_text(found: RecordLength) -> str:
    """One table: standard errors, total length for 5 %, further length for half the error."""
    total = float(found.lengths[-1])
    head = ["standard error after", *(spelled(x) for x in found.lengths)]
    head += [f"total for {100 * SHARP_ERROR:.0f} %", "more for half"]
    rows = []
    for k, name in enumerate(found.names):
        error = float(found.errors[-1, k])
        known, relative = verdict_of(name, float(found.values[k]), error)
        wanted = {ParameterVerdict.SHARP: "done", ParameterVerdict.ZERO: "-"}.get(known)
        best = int(np.argmin(found.more[:, k]))
        more = float(found.more[best, k])
        like = f" like {found.recordings[best]}"
        if len(found.recordings) == 1 or not more < ALONE_BETTER * 3 * total:
            more, like = 3 * total, " like these"
        rows.append(
            [
                name,
                *(f"{e:.2g}" if np.isfinite(e) else "-" for e in found.errors[:, k]),
                wanted or _wanted(total, relative),
                spelled(more) + like,
            ]
        )
    return table(head, rows)


def _wanted(total: float, relative: float) -> str:
    return spelled(total * (relative / SHARP_ERROR) ** 2) if np.isfinite(relative) else "-"


def _own(fit: Fit, part: float = 1.0) -> list[Array]:
    """Information (p, p) of the first part of each recording."""
    problem = fit.problem
    counts = [(r.t <= r.t[0] + part * r.duration).astype(float) for r in problem.recordings]
    runs = fit.runs if part == 1.0 else filter_along(problem, fit.theta, fit.noise, counts)
    return [runs.information_of(i) for i in range(len(runs.by_recording))]


def _sum(parts: Sequence[Array]) -> Array:
    return np.asarray(np.sum(parts, axis=0))


def _errors(information: Array) -> Array:
    """Standard errors (p,); infinite for parameters in a direction without information."""
    inverse, known = pseudo_inverse(information)
    return np.where(known, np.sqrt(np.diag(inverse)), np.inf)


def _halved(information: Array, rate: Array) -> Array:
    """Minutes (p,) until errors are half, with further information at a rate (p, p) per minute."""
    goal = _errors(information) / 2.0
    low, high = np.full(len(goal), np.log(SHORTEST_MORE)), np.full(len(goal), np.log(LONGEST_MORE))
    for _ in range(20):
        middle = 0.5 * (low + high)
        reached = np.array(
            [_errors(information + np.exp(m) * rate)[k] < goal[k] for k, m in enumerate(middle)]
        )
        low, high = np.where(reached, low, middle), np.where(reached, middle, high)
    return np.where(high < np.log(LONGEST_MORE), np.exp(high), np.inf)
