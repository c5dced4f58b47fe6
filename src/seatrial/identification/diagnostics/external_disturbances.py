# SPDX-License-Identifier: MIT
"""External disturbances (a hand, a rope, a wall) and their influence on the estimates.

A boat that is carried for ten seconds of ten minutes enlarges the estimated noise and with it all standard errors.
So innovations are searched for disturbed intervals, and the model is fitted again without them. Whether they are
excluded is the user's choice: model mismatch can look alike.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of, finding_text
from seatrial.boat.noise_parameters import loosened
from seatrial.evaluation.disturbed_intervals import (
    MOST_DISTURBED_SHARE,
    MOST_INTERVALS,
    DisturbedInterval,
    disturbed_intervals,
    interval_findings,
    joined_intervals,
    squared_innovations,
)
from seatrial.identification.likelihood.filter_runs import FilterRuns
from seatrial.identification.likelihood.linearised import Point, by_linearisation
from seatrial.identification.likelihood.optimiser import at_bounds, full_pass
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.uncertainty.covariance import sandwich_covariance
from seatrial.util.errors import IdentificationError, RecordingError
from seatrial.util.frames import Array

END_LENGTH = 20.0  # [s] of a recording's beginning and end, when boats are put in and taken out
END_SHARE = 0.15  # of a short recording, instead
LEAST_POSES_LEFT = 0.5  # share of every recording's poses: else the intervals are no exceptions
WORTHWHILE_ERROR_RATIO = 0.7  # of standard errors without over with them: only then a finding

FromStartValues = Callable[[Problem], Point]  # a maximum of the likelihood, from start values


def disturbed_at(at: Point) -> list[DisturbedInterval]:
    """Intervals in which innovations are larger than elsewhere."""
    recordings, each = at.runs.problem.recordings, at.runs.by_recording
    return disturbed_intervals(recordings, [squared_innovations(p) for p in each])


def disturbance_findings(seen: Point | None, at: Point, covariance: Array) -> list[Finding]:
    """Disturbed intervals and the influence of their exclusion; none where that hardly changes standard errors.

    seen: the likelihood's maximum, if its innovations show intervals; at: the solution, which may have another
    fit horizon just because of them, or more actuator stages; covariance: (p, p) of its free parameters.
    """
    near = at if seen is None else seen
    problem = near.runs.problem
    best, findings = WORTHWHILE_ERROR_RATIO, []
    # innovations of the solution, then of one fitted to the recordings' middles
    begins = [] if seen is None else [seen]
    middles = _middles(problem)
    if middles is not None:
        fitted = _refitted(middles, near)
        noise = loosened(fitted.noise, 1.0)  # so that it recovers from a disturbance
        runs = near.runs.relinearised(noise, fitted.theta - near.theta)
        # the linearisation shows whether there are intervals, not always how long they are
        if disturbed_at(Point(fitted.theta, noise, runs)):
            begins.append(full_pass(problem, fitted.theta, noise))
    for begin in begins:
        found, after = _excluded(begin, near)
        influence = None if after is None else _influence(at, covariance, after)
        if influence is not None and influence.number("ratio") < best:
            best = influence.number("ratio")
            findings = [*interval_findings(problem.recordings, found), influence]
    return findings


def disturbance_hint(problem: Problem, from_start_values: FromStartValues) -> str:
    """Text for a refusal: the disturbed intervals without which there is a solution; empty without any."""
    middles = _middles(problem)
    if middles is None:
        return ""
    with suppress(IdentificationError):
        fitted = from_start_values(middles)
        begin = full_pass(problem, fitted.theta, loosened(fitted.noise, 1.0))
        found, after = _excluded(begin, begin)
        if after is not None:
            texts = map(finding_text, interval_findings(problem.recordings, found))
            return f". There is a solution without some of it: {'; '.join(texts)}"
    return ""


def _middles(problem: Problem) -> Problem | None:
    """The problem without the recordings' ends, when boats are put in and taken out; None where little is left.

    With much of that no interval stands out.
    """
    recordings = []
    with suppress(RecordingError):
        for r in problem.recordings:
            end = min(END_LENGTH, END_SHARE * r.duration)
            recordings.append(r.without(r.duration - end, r.duration).without(0.0, end))
        return replace(problem, recordings=tuple(recordings))
    return None


def _excluded(at: Point, about: Point) -> tuple[list[DisturbedInterval], Point | None]:
    """All intervals, also those that show only after others are excluded, and the solution without them.

    Fitted on the linearisation of `about`. None where they are too many to be exceptions.
    """
    problem, there = at.runs.problem, at
    found: list[DisturbedInterval] = []
    for _ in range(4):  # those that hid others are found in two or three
        new = disturbed_at(there)
        if not new:
            break
        found = joined_intervals([*found, *new])
        left = _without(problem, found)
        if len(found) > MOST_INTERVALS or left is None:
            return [], None
        there = _refitted(left, about)
        if not np.isfinite(there.runs.cost):
            return [], None
    return found, there if found else None


def _refitted(problem: Problem, near: Point) -> Point:
    """The solution of a problem with fewer poses, on the linearisation of one with all of them."""
    runs = FilterRuns(problem, near.theta, near.runs.by_recording)
    return by_linearisation(Point(near.theta, near.noise, runs), noise=near.noise)


def _without(problem: Problem, found: Sequence[DisturbedInterval]) -> Problem | None:
    """The problem without these intervals; None where they are too much of it, or of one recording.

    Most of a recording is no exception in it: that is another boat, or model mismatch.
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
    if (
        after.sum() <= (1.0 - MOST_DISTURBED_SHARE) * before.sum()
        or (after < LEAST_POSES_LEFT * before).any()
    ):
        return None
    return replace(problem, recordings=tuple(recordings))


def _influence(at: Point, covariance: Array, after: Point) -> Finding | None:
    """Ratio of standard errors without over with the intervals, and the parameter that changes most."""
    try:
        errors = _estimates(after, sandwich_covariance(after, ~at_bounds(after)))
    except IdentificationError:  # the rest does not identify all parameters
        return None
    old = _estimates(at, covariance)
    both = [n for n in old if n in errors and min(old[n][1], errors[n][1]) > 0.0]
    if not both:
        return None
    ratio = float(np.median([errors[n][1] / old[n][1] for n in both]))
    most = max(both, key=lambda n: abs(errors[n][0] - old[n][0]) / old[n][1])
    value, error = errors[most]
    kind = FindingKind.DISTURBANCE_INFLUENCE
    return finding_of(kind, most, ratio=ratio, value=value, error=error)


def _estimates(at: Point, covariance: Array) -> dict[str, tuple[float, float]]:
    """Values and standard errors of the free parameters."""
    problem, errors = at.runs.problem, np.sqrt(np.diag(covariance)).tolist()
    pairs = zip(at.theta[list(problem.free)].tolist(), errors, strict=True)
    return dict(zip((problem.names[i] for i in problem.free), pairs, strict=True))
