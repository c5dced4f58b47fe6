# SPDX-License-Identifier: MIT
"""Parameter drift: thrust or drag that fall or rise in the course of a recording.

A battery runs down, weeds gather, water comes in. The model then holds for the middle of a recording. So a scale
factor that is linear in time is tested, with one slope for all recordings. It is 1 in the middle of each, so that
it is independent of differences between recordings.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.identification.diagnostics.scale_factors import (
    LARGEST_FACTOR_ERROR,
    FactorChange,
    dead_zone_of,
    manifest_changes,
)
from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.likelihood.problem import FilterRuns
from seatrial.identification.selection.score_test import ScoreTest
from seatrial.util.frames import AXES, Array


@dataclass(frozen=True)
class _Blocks:
    """Scores and information of one recording's m parameters, in blocks of time."""

    places: NDArray[np.int64]  # (m,) among the free parameters; -1: nowhere
    time: Array  # (blocks,) [s] of their middle
    information: Array  # (blocks, m, m)
    score: Array  # (blocks, m)


@dataclass(frozen=True)
class _Recordings:
    """All recordings, block by block."""

    runs: FilterRuns
    blocks: list[_Blocks]
    longest: str  # recording
    span: float  # [s] its length: the tested slope is the change over it


def drift_findings(at: Point) -> list[Finding]:
    """Significant drift, by axis."""
    if at.runs.problem.prior is not None:
        return []
    drives = _in_blocks(at)
    if drives.span <= 0.0:
        return []
    manifest = manifest_changes(
        at, lambda axis, quantity, weights: _slope_test(drives, axis, quantity, weights)
    )
    return [_finding(at, drives, change) for change in manifest]


def _finding(at: Point, drives: _Recordings, change: FactorChange) -> Finding:
    return finding_of(
        FindingKind.PARAMETER_DRIFT,
        *(AXES[change.axis], drives.longest),
        change=1.0 - change.ratio,
        quantity=change.quantity,
        lower=change.less,
        higher=change.more,
        of="one recording" if len(drives.blocks) == 1 else "all recordings",
        dead_zone=dead_zone_of(at, change.quantity),
    )


def _in_blocks(at: Point) -> _Recordings:
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
    return _Recordings(runs, found, problem.recordings[longest].name, span)


def _slope_test(
    drives: _Recordings, axis: int, quantity: str, weights: Array
) -> FactorChange | None:
    """The change over the longest recording, by one slope for all; None where it is not identifiable."""
    wide, scores = _with_slope(drives, weights)
    information = wide.sum(axis=0)
    if not information[-1, -1] > LARGEST_FACTOR_ERROR**-2:
        return None
    test = _test_after_step(wide, scores)
    change = float(test.step[0])
    less, more = ("beginning", "end") if change > 0.0 else ("end", "beginning")
    half = min(0.5 * abs(change), 1.0)
    return FactorChange(axis, quantity, less, more, (1.0 - half) / (1.0 + half), test)


def _with_slope(drives: _Recordings, weights: Array) -> tuple[Array, Array]:
    """Information (blocks, p + 1, p + 1) and scores (blocks, p + 1) with the slope as a further parameter."""
    p = len(weights)
    wide, scores = [], []
    for each in drives.blocks:
        n, use = len(each.time), each.places >= 0
        to = each.places[use]
        own = np.where(use, weights[each.places], 0.0)
        along = each.information @ own
        known = along @ own
        middle = float(known @ each.time / known.sum()) if known.sum() > 0.0 else 0.0
        when = (each.time - middle) / drives.span
        block, score = np.zeros((n, p + 1, p + 1)), np.zeros((n, p + 1))
        block[np.ix_(np.arange(n), to, to)] = each.information[np.ix_(np.arange(n), use, use)]
        block[:, to, p] = block[:, p, to] = when[:, None] * along[:, use]
        block[:, p, p] = when**2 * known
        score[:, to], score[:, p] = each.score[:, use], when * (each.score @ own)
        wide.append(block)
        scores.append(score)
    return np.concatenate(wide), np.concatenate(scores)


def _test_after_step(wide: Array, scores: Array) -> ScoreTest:
    """Test of the last parameter, with the scatter of the scores after its step: a real drift is no scatter.

    As many blocks as there are parameters carry no information on the scatter.
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
