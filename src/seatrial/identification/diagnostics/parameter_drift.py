# SPDX-License-Identifier: MIT
"""Whether the boat stays what it is in the course of a recording: thrust or drag that fall or rise.

A battery that runs down makes thrust weaker all the time, weeds gather, water comes in. The model is then that
of the middle, and of neither end. So a factor that grows evenly with time is tested, as fast in all recordings;
it is 1 in the middle of each, so that it is none between recordings.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.identification.diagnostics.scale_factors import (
    SHARP,
    Change,
    changes,
    dead_zone_of,
)
from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.likelihood.problem import FilterRuns
from seatrial.identification.selection.score_test import ScoreTest
from seatrial.util.frames import AXES, Array


@dataclass(frozen=True)
class _Blocks:
    """What blocks of time of one recording tell of its parameters, m of them."""

    places: NDArray[np.int64]  # (m,) among the free parameters; -1: nowhere
    time: Array  # (blocks,) [s] of their middle
    information: Array  # (blocks, m, m)
    score: Array  # (blocks, m)


@dataclass(frozen=True)
class _Course:
    """All recordings, block by block."""

    runs: FilterRuns
    blocks: list[_Blocks]
    longest: str  # recording
    span: float  # [s] its length, over which a factor changes by what is sought


def wear(at: Point) -> list[Finding]:
    """How the boat changes in the course of a recording, if it does."""
    if at.runs.problem.prior is not None:
        return []
    course = _course(at)
    if course.span <= 0.0:
        return []
    manifest = changes(at, lambda axis, what, weights: _tested(course, axis, what, weights))
    return [_finding(at, course, change) for change in manifest]


def _finding(at: Point, course: _Course, change: Change) -> Finding:
    return finding_of(
        FindingKind.PARAMETER_DRIFT,
        *(AXES[change.axis], course.longest),
        change=1.0 - change.ratio,
        quantity=change.what,
        lower=change.less,
        higher=change.more,
        of="one recording" if len(course.blocks) == 1 else "all recordings",
        dead_zone=dead_zone_of(at, change.what),
    )


def _course(at: Point) -> _Course:
    problem = at.runs.problem
    runs = problem.run_filter(at.theta, at.noise, repeatable=False, shares=True)
    found = []
    for i, (recording, each) in enumerate(zip(problem.recordings, runs.by_recording, strict=True)):
        block, places = problem.blocks[i], problem.free_columns(i)
        time = np.bincount(block, recording.t) / np.bincount(block)
        m = len(places)
        found.append(_Blocks(places, time, each.share.reshape(-1, m, m), np.asarray(each.score)))
    longest = max(range(len(found)), key=lambda i: float(np.ptp(found[i].time)))
    span = float(np.ptp(found[longest].time))
    return _Course(runs, found, problem.recordings[longest].name, span)


def _tested(course: _Course, axis: int, what: str, weights: Array) -> Change | None:
    """One slope for all recordings; nothing where they do not tell it."""
    wide, scores = _with_slope(course, weights)
    information = wide.sum(axis=0)
    if not information[-1, -1] > SHARP**-2:
        return None
    test = _with_step_taken(wide, scores)
    change = float(test.step[0])
    less, more = ("beginning", "end") if change > 0.0 else ("end", "beginning")
    half = min(0.5 * abs(change), 1.0)
    return Change(axis, what, less, more, (1.0 - half) / (1.0 + half), test)


def _with_slope(course: _Course, weights: Array) -> tuple[Array, Array]:
    """Information (blocks, p + 1, p + 1) and scores (blocks, p + 1) as they were with it."""
    p = len(weights)
    wide, scores = [], []
    for each in course.blocks:
        n, use = len(each.time), each.places >= 0
        to = each.places[use]
        own = np.where(use, weights[each.places], 0.0)
        tells = each.information @ own
        known = tells @ own
        middle = float(known @ each.time / known.sum()) if known.sum() > 0.0 else 0.0
        when = (each.time - middle) / course.span
        block, score = np.zeros((n, p + 1, p + 1)), np.zeros((n, p + 1))
        block[np.ix_(np.arange(n), to, to)] = each.information[np.ix_(np.arange(n), use, use)]
        block[:, to, p] = block[:, p, to] = when[:, None] * tells[:, use]
        block[:, p, p] = when**2 * known
        score[:, to], score[:, p] = each.score[:, use], when * (each.score @ own)
        wide.append(block)
        scores.append(score)
    return np.concatenate(wide), np.concatenate(scores)


def _with_step_taken(wide: Array, scores: Array) -> ScoreTest:
    """Of the last parameter, by how the scores scatter once its step is taken: a change that is there is no
    chance. Of few blocks as many as there are parameters tell nothing.
    """
    information = wide.sum(axis=0)
    n, p = len(scores), len(information) - 1
    through = np.linalg.pinv(information[:p, :p], hermitian=True) @ information[:p, p]
    direction = np.append(-through, 1.0)  # the others follow
    known = float(direction @ information @ direction)
    total = float(scores.sum(axis=0) @ direction)
    step = total / known
    after = (scores - step * (wide @ direction)) @ direction
    statistic = total**2 / float(after @ after) * max(n - p - 1, 0) / n
    return ScoreTest(statistic, 1, total * step, np.array([step]))
