# SPDX-License-Identifier: MIT
"""Whether recordings agree: thrust, drag or mass of one that is not that of the others, or its clock.

A battery that falls from drive to drive makes thrust weaker, a payload that is taken in between makes the
boat heavier, and clocks of poses and commands that are set anew put both apart. One model for all is then that of
none, and its errors do not say so. So each recording's own factor is tested, and its own delay.
"""

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.identification.diagnostics.scale_factors import (
    SHARP,
    WORTH,
    Change,
    WithFactors,
    changes,
    dead_zone_of,
)
from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.selection.score_test import ScoreTest, score_test
from seatrial.util.frames import AXES, Array

LATER = 0.04  # [s] between recordings: less is nothing to speak of
DISAGREEMENTS = (FindingKind.HOMOGENEITY, FindingKind.CLOCK_HOMOGENEITY)


def disagreements(at: Point) -> list[Finding]:
    """How recordings are of different boats; none where chance explains it."""
    if at.runs.problem.prior is not None or len(at.runs.by_recording) < 2:
        return []
    manifest = changes(at, lambda axis, what, weights: _tested(at, axis, what, weights))
    delays, gain = _clocks(at)
    if gain > sum(change.test.gain for change in manifest):
        return delays
    return [_finding(at, change) for change in manifest]


def _finding(at: Point, change: Change) -> Finding:
    return finding_of(
        FindingKind.HOMOGENEITY,
        *(AXES[change.axis], change.less, change.more),
        change=1.0 - change.ratio,
        quantity=change.what,
        dead_zone=dead_zone_of(at, change.what),
    )


def _clocks(at: Point) -> tuple[list[Finding], float]:
    """A delay from commands to poses that is not the same in all recordings, and the gain that it promises."""
    problem = at.runs.problem
    late = np.array([problem.names[i].partition(".")[0] == "latency" for i in problem.free])
    found = _apart(at, late.astype(float))
    if found is None:
        return [], 0.0
    known, test = found
    delays = np.concatenate([[0.0], test.step])
    early, last = int(np.argmin(delays)), int(np.argmax(delays))
    more = float(delays[last] - delays[early])
    if not (test.likely and test.gain >= WORTH and more >= LATER):
        return [], 0.0
    one, other = (problem.recordings[known[i]].name for i in (last, early))
    return [finding_of(FindingKind.CLOCK_HOMOGENEITY, one, other, delay=more)], test.gain


def _tested(at: Point, axis: int, what: str, weights: Array) -> Change | None:
    """A factor on each recording that tells one; nothing where fewer than two do."""
    found = _apart(at, weights)
    if found is None:
        return None
    known, test = found
    factors = np.concatenate([[1.0], 1.0 + test.step])
    low, high = int(np.argmin(factors)), int(np.argmax(factors))
    less, more = (at.runs.problem.recordings[known[i]].name for i in (low, high))
    return Change(axis, what, less, more, float(max(factors[low], 0.0) / factors[high]), test)


def _apart(at: Point, weights: Array) -> tuple[list[int], ScoreTest] | None:
    """Recordings that tell it, and the test of each one's own share in what moves the free parameters by
    `weights` (p,), beside that of the first; None where fewer than two do.
    """
    problem, runs = at.runs.problem, at.runs
    p, known, columns, scores = len(problem.free), [], [], []
    for i, each in enumerate(runs.by_recording):
        to = problem.free_columns(i)
        own = np.where(to >= 0, weights[to], 0.0)
        across = np.zeros(p)
        across[to[to >= 0]] = (np.asarray(each.information) @ own)[to >= 0]
        if weights @ across > SHARP**-2:
            known.append(i)
            columns.append(across)
        scores.append(np.asarray(each.score) @ own)
    k = len(known)
    if k < 2:
        return None
    wide = np.zeros((p + k, p + k))
    wide[:p, :p] = runs.information
    wide[:p, p:] = np.array(columns).T
    wide[p:, :p] = wide[:p, p:].T
    wide[p:, p:] = np.diag(np.array(columns) @ weights)
    ends = np.cumsum([len(s) for s in scores])
    blocks = np.zeros((ends[-1], k))
    for j, i in enumerate(known):
        blocks[ends[i] - len(scores[i]) : ends[i], j] = scores[i]
    tested = list(range(p + 1, p + k))  # one for all is in the coefficients
    test = score_test(WithFactors(wide, np.hstack([runs.scores, blocks])), tested, neutral=[p])
    return known, test
