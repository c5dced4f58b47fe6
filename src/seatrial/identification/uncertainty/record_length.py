# SPDX-License-Identifier: MIT
"""How many minutes must I drive? Accuracy against length, from the recordings themselves.

What the poses up to a time say is the information gathered until then; what a recording adds is
its own. Both are scaled by what the blocks' scores found errors to be worth (the sandwich).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.identification.console import minutes as spelled
from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.solution import Fit
from seatrial.identification.uncertainty.covariance import at_bounds
from seatrial.identification.uncertainty.parameter_verdict import SHARP, Verdict, verdict_of
from seatrial.util.format import table
from seatrial.util.frames import Array

PARTS = (0.25, 0.5, 0.75, 1.0)  # of every recording, from its start
LEAST, MOST = 0.1, 1e4  # [min] that are looked through for half the error
LOST = 1e-10  # share of the largest eigenvalue below which a direction says nothing
SHARE = 1e-3  # in a direction that says nothing: a parameter with less is known all the same
CLEARLY = 0.8  # times the minutes of all: a recording worth repeating alone


@dataclass(frozen=True)
class Minutes:
    """Errors against the length that was driven, and what more would do."""

    names: tuple[str, ...]  # (p,)
    values: Array  # (p,)
    lengths: Array  # (q,) [min]
    errors: Array  # (q, p) standard errors after these; infinite: nothing is known yet
    recordings: tuple[str, ...]  # (r,)
    more: Array  # (r, p) [min] more like one recording that halve an error; infinite: it can't


def minutes(fit: Fit) -> Minutes:
    """Accuracy after a quarter, a half, three quarters, the whole; what would halve the errors.

    Of parameters that did not end at a bound: how well those are known is not.
    """
    problem = fit.problem
    inside = np.flatnonzero(~at_bounds(Point(fit.theta, fit.noise, fit.passes)))
    square = np.ix_(inside, inside)
    total = sum(r.duration for r in problem.recordings) / 60.0  # [min]
    whole = [own[square] for own in _own(fit)]
    excess = np.sqrt(np.diag(fit.covariance)[inside] / np.square(_errors(_sum(whole))))
    parts = [_sum(_own(fit, part))[square] for part in PARTS[:-1]] + [_sum(whole)]
    errors = np.array([_errors(part) for part in parts])
    rates = [w / (r.duration / 60.0) for w, r in zip(whole, problem.recordings, strict=True)]
    return Minutes(
        tuple(fit.names[i] for i in inside),
        fit.theta[list(problem.free)][inside],
        total * np.array(PARTS),
        np.multiply(errors, excess, out=np.full_like(errors, np.inf), where=np.isfinite(errors)),
        tuple(r.name for r in problem.recordings),
        np.array([_halved(_sum(whole), rate) for rate in rates]),
    )


def minutes_text(found: Minutes) -> str:
    """One table: errors as they fell, minutes in all for 5 %, minutes more for half the error."""
    total = float(found.lengths[-1])
    head = ["standard error after", *(spelled(x) for x in found.lengths)]
    head += [f"{100 * SHARP:.0f} % takes", "half takes, more"]
    rows = []
    for k, name in enumerate(found.names):
        error = float(found.errors[-1, k])
        known, relative = verdict_of(name, float(found.values[k]), error)
        wanted = {Verdict.SHARP: "done", Verdict.ZERO: "-"}.get(known)
        best = int(np.argmin(found.more[:, k]))
        alone = float(found.more[best, k])
        like = f" like {found.recordings[best]}"
        if len(found.recordings) == 1 or not alone < CLEARLY * 3 * total:
            alone, like = 3 * total, " like these"
        rows.append(
            [
                name,
                *(f"{e:.2g}" if np.isfinite(e) else "-" for e in found.errors[:, k]),
                wanted or _wanted(total, relative),
                spelled(alone) + like,
            ]
        )
    return table(head, rows)


def _wanted(total: float, relative: float) -> str:
    return spelled(total * (relative / SHARP) ** 2) if np.isfinite(relative) else "-"


def _own(fit: Fit, part: float = 1.0) -> list[Array]:
    """Information (p, p) of the first part of each recording."""
    problem = fit.problem
    counts = [(r.t <= r.t[0] + part * r.duration).astype(float) for r in problem.recordings]
    passes = fit.passes if part == 1.0 else problem.passes(fit.theta, fit.noise, counts)
    found = []
    for i, each in enumerate(passes.each):
        to = problem.places(i)
        own = np.zeros((len(problem.free),) * 2)
        own[np.ix_(to[to >= 0], to[to >= 0])] = each.information[np.ix_(to >= 0, to >= 0)]
        found.append(own)
    return found


def _sum(parts: Sequence[Array]) -> Array:
    return np.asarray(np.sum(parts, axis=0))


def _errors(information: Array) -> Array:
    """Standard errors (p,); infinite where a direction that says nothing has a share in one."""
    size = np.sqrt(np.diag(information))
    known = size > 0
    scaled = information[np.ix_(known, known)] / np.outer(size[known], size[known])
    spectrum, vectors = np.linalg.eigh(scaled)
    lost = spectrum <= LOST * spectrum[-1]
    variance = np.square(vectors[:, ~lost]) @ (1.0 / spectrum[~lost])
    variance[np.any(np.abs(vectors[:, lost]) > SHARE, axis=1)] = np.inf
    errors = np.full(len(size), np.inf)
    errors[known] = np.sqrt(variance) / size[known]
    return errors


def _halved(information: Array, rate: Array) -> Array:
    """Minutes (p,) of more information at a rate (p, p) per minute after which errors are half."""
    goal = _errors(information) / 2.0
    low, high = np.full(len(goal), np.log(LEAST)), np.full(len(goal), np.log(MOST))
    for _ in range(20):
        middle = 0.5 * (low + high)
        reached = np.array(
            [_errors(information + np.exp(m) * rate)[k] < goal[k] for k, m in enumerate(middle)]
        )
        low, high = np.where(reached, low, middle), np.where(reached, middle, high)
    return np.where(high < np.log(MOST), np.exp(high), np.inf)
