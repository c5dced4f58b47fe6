# SPDX-License-Identifier: MIT
"""What a hand, a rope or a wall did to the estimates.

A boat that was carried for ten seconds of ten minutes makes the noise large, and with it all standard
errors, and nobody is told when it was. So the filter's errors are looked through for such
stretches, and the model is fitted again without them, to see how much they matter. Whether they are left out
is for those to say who were there: what a poor structure does not explain may look alike.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of, finding_text
from seatrial.boat.noise_parameters import loosened
from seatrial.evaluation.disturbed_intervals import (
    MANY,
    MOST,
    Stretch,
    squared_errors,
    stretches,
    stretches_found,
    together,
)
from seatrial.identification.likelihood.optimiser import Point, maximise_likelihood
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.uncertainty.covariance import sandwich_covariance
from seatrial.util.errors import IdentificationError, RecordingError
from seatrial.util.frames import Array

ROUNDS = 4  # of looking and fitting
END, END_SHARE = 20.0, 0.15  # [s] and of a recording, that its beginning and its end are
LEFT = 0.5  # of the poses of every recording is left, at the least
SHARPER = 0.7  # times the standard errors, without a stretch that is worth a word

Afresh = Callable[[Problem], Point]  # the search from start values


def bumps(at: Point) -> list[Stretch]:
    """Stretches in which the filter's errors are larger than elsewhere."""
    recordings, each = at.runs.problem.recordings, at.runs.by_recording
    return stretches(recordings, [squared_errors(p) for p in each])


def bumps_said(seen: Point | None, at: Point, covariance: Array, afresh: Afresh) -> list[Finding]:
    """Such stretches, and what it changes to leave them out; none where there are none.

    seen: the likelihood's choice, where its errors show some; at: the solution, which may be believed less
    closely just because of them, or have more stages; covariance: (p, p) of its free parameters.
    """
    near = at if seen is None else seen
    problem = near.runs.problem
    best, findings = SHARPER, []
    for begin in _beginnings(seen, near, problem, afresh):
        found, after = _followed(begin, afresh)
        influence = None if after is None else _difference(at, covariance, after)
        if influence is not None and influence.number("ratio") < best:
            best = influence.number("ratio")
            findings = [*stretches_found(problem.recordings, found), influence]
    return findings


def bumps_tried(problem: Problem, afresh: Afresh) -> str:
    """What is to be said where there is no solution, but one without such stretches."""
    for begin in _beginnings(None, None, problem, afresh):
        found, after = _followed(begin, afresh)
        if after is not None:
            texts = map(finding_text, stretches_found(problem.recordings, found))
            return f". There is a solution without some of it: {'; '.join(texts)}"
    return ""


def _beginnings(
    seen: Point | None, near: Point | None, problem: Problem, afresh: Afresh
) -> Iterator[Point]:
    """By whose errors stretches may be seen: the solution's, then what the middle of every recording tells.

    At beginning and end boats are put in and taken out: with enough of that nothing stands out any more.
    """
    if seen is not None:
        yield seen
    recordings = []
    with suppress(RecordingError, IdentificationError):
        for r in problem.recordings:
            end = min(END, END_SHARE * r.duration)
            recordings.append(r.without(r.duration - end, r.duration).without(0.0, end))
        own = replace(problem, recordings=tuple(recordings))
        middle = afresh(own) if near is None else _searched(own, near, afresh)
        noise = loosened(middle.noise, 1.0)  # so that it finds back from what it does not foresee
        runs = problem.run_filter(middle.theta, noise, repeatable=False)
        yield Point(middle.theta, noise, runs)


def _followed(at: Point, afresh: Afresh) -> tuple[list[Stretch], Point | None]:
    """Stretches, and those that are seen only without these; and the solution without all of them.

    None where they are too many to be exceptions.
    """
    problem, there = at.runs.problem, at
    found: list[Stretch] = []
    for _ in range(ROUNDS):
        new = bumps(there)
        if not new:
            break
        found = together([*found, *new])
        left = _without(problem, found)
        if len(found) > MANY or left is None:
            return [], None
        try:
            there = _searched(left, there, afresh)
        except IdentificationError:
            return [], None
    return found, there if found else None


def _searched(problem: Problem, near: Point, afresh: Afresh) -> Point:
    """The solution of a problem, from a point or, where that leads nowhere, from start values."""
    try:
        return maximise_likelihood(problem, near.theta, near.noise)
    except IdentificationError:
        return afresh(problem)


def _without(problem: Problem, found: Sequence[Stretch]) -> Problem | None:
    """The problem without these; None where that is too much, or leaves too little.

    Most of one recording, too, is no exception in it: it is another boat, or shows what no term explains.
    """
    recordings = list(problem.recordings)
    try:
        for s in found:
            recordings[s.recording] = recordings[s.recording].without(s.start, s.end)
    except RecordingError:
        return None
    before, after = (
        np.array([r.valid.sum() for r in all_]) for all_ in (problem.recordings, recordings)
    )
    if after.sum() <= (1.0 - MOST) * before.sum() or (after < LEFT * before).any():
        return None
    return replace(problem, recordings=tuple(recordings))


def _difference(at: Point, covariance: Array, after: Point) -> Finding | None:
    """What it makes of standard errors to leave stretches out, and of the parameter that changes most."""
    try:
        errors = _named(after, sandwich_covariance(after))
    except IdentificationError:  # what is left does not tell them apart
        return None
    old = _named(at, covariance)
    both = [n for n in old if n in errors and min(old[n][1], errors[n][1]) > 0.0]
    if not both:
        return None
    ratio = float(np.median([errors[n][1] / old[n][1] for n in both]))
    most = max(both, key=lambda n: abs(errors[n][0] - old[n][0]) / old[n][1])
    value, error = errors[most]
    kind = FindingKind.DISTURBANCE_INFLUENCE
    return finding_of(kind, most, ratio=ratio, value=value, error=error)


def _named(at: Point, covariance: Array) -> dict[str, tuple[float, float]]:
    """Values and standard errors of the free parameters."""
    problem, errors = at.runs.problem, np.sqrt(np.diag(covariance)).tolist()
    pairs = zip(at.theta[list(problem.free)].tolist(), errors, strict=True)
    return dict(zip((problem.names[i] for i in problem.free), pairs, strict=True))
