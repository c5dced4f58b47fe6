# SPDX-License-Identifier: MIT
"""Homogeneity across recordings: whether thrust, drag, mass or the clock offset is the same in all.

A battery's voltage falls from drive to drive, a payload is added, a clock is set. One model for all recordings
then describes none, and its standard errors do not show it. So each recording's scale factor and delay are tested.
"""

from dataclasses import replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.identification.diagnostics.scale_factors import (
    LARGEST_FACTOR_ERROR,
    LEAST_FACTOR_GAIN,
    FactorChange,
    WithScaleFactors,
    dead_zone_of,
    manifest_changes,
)
from seatrial.identification.likelihood.optimiser import Point, full_pass
from seatrial.identification.selection.score_test import ScoreTest, score_test
from seatrial.util.frames import AXES, Array

LEAST_DELAY = 0.04  # [s] between recordings, reported: less hardly biases the latency
DISAGREEMENTS = (FindingKind.HOMOGENEITY, FindingKind.CLOCK_HOMOGENEITY)


def homogeneity_findings(at: Point) -> list[Finding]:
    """Significant differences between recordings: scale factors, or a delay if that is the likelier cause."""
    if at.runs.problem.prior is not None or len(at.runs.by_recording) < 2:
        return []
    manifest = manifest_changes(
        at, lambda axis, quantity, weights: _factor_by_recording(at, axis, quantity, weights)
    )
    delays, gain = _clock_offset(at)
    if gain > sum(change.test.gain for change in manifest):
        return delays
    return [_finding(at, change) for change in manifest]


def _finding(at: Point, change: FactorChange) -> Finding:
    return finding_of(
        FindingKind.HOMOGENEITY,
        *(AXES[change.axis], change.less, change.more),
        change=1.0 - change.ratio,
        quantity=change.quantity,
        dead_zone=dead_zone_of(at, change.quantity),
    )


def _clock_offset(at: Point) -> tuple[list[Finding], float]:
    """The largest difference of delays from commands to poses, and the expected fall of -2 log L."""
    problem = at.runs.problem
    late = np.array([problem.names[i].partition(".")[0] == "latency" for i in problem.free])
    found = _by_recording(at, late.astype(float))
    if found is None:
        return [], 0.0
    known, test = found
    delays = np.concatenate([[0.0], test.step])
    if test.likely and test.gain >= LEAST_FACTOR_GAIN:
        delays = delays + _further_delays(at, late, known, delays)
    early, last = int(np.argmin(delays)), int(np.argmax(delays))
    more = float(delays[last] - delays[early])
    if not (test.likely and test.gain >= LEAST_FACTOR_GAIN and more >= LEAST_DELAY):
        return [], 0.0
    one, other = (problem.recordings[known[i]].name for i in (last, early))
    return [finding_of(FindingKind.CLOCK_HOMOGENEITY, one, other, delay=more)], test.gain


def _further_delays(at: Point, late: Array, known: list[int], delays: Array) -> Array:
    """What the delays of some recordings lack: of a long one the first step is too short.

    By a pass with their commands shifted. late: (p,) weights of the latencies; delays: [s] of those `known`.
    """
    shifted = list(at.runs.problem.recordings)
    for i, delay in zip(known, delays.tolist(), strict=True):
        commands = shifted[i].commands
        stamps = commands.stamps + round(delay * 1e9)
        shifted[i] = replace(shifted[i], commands=replace(commands, stamps=stamps))
    problem = replace(at.runs.problem, recordings=tuple(shifted))
    again = _by_recording(full_pass(problem, at.theta, at.noise), late.astype(float))
    if again is None or again[0] != known:
        return np.zeros(len(delays))
    return np.concatenate([[0.0], again[1].step])


def _factor_by_recording(
    at: Point, axis: int, quantity: str, weights: Array
) -> FactorChange | None:
    """The largest difference of scale factors between recordings; None where fewer than two identify one."""
    found = _by_recording(at, weights)
    if found is None:
        return None
    known, test = found
    factors = np.concatenate([[1.0], 1.0 + test.step])
    low, high = int(np.argmin(factors)), int(np.argmax(factors))
    less, more = (at.runs.problem.recordings[known[i]].name for i in (low, high))
    return FactorChange(
        axis, quantity, less, more, float(max(factors[low], 0.0) / factors[high]), test
    )


def _by_recording(at: Point, weights: Array) -> tuple[list[int], ScoreTest] | None:
    """Recordings that identify it, and the score test of each one's own step along `weights` (p,) of the free
    parameters, relative to the first's; None where fewer than two identify it.
    """
    problem, runs = at.runs.problem, at.runs
    p, known, columns, scores = len(problem.free), [], [], []
    for i, each in enumerate(runs.by_recording):
        to = problem.free_columns(i)
        own = np.where(to >= 0, weights[to], 0.0)
        across = np.zeros(p)
        across[to[to >= 0]] = (np.asarray(each.information) @ own)[to >= 0]
        if weights @ across > LARGEST_FACTOR_ERROR**-2:
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
    tested = list(
        range(p + 1, p + k)
    )  # the first is the reference: a factor of all is in the coefficients
    test = score_test(WithScaleFactors(wide, np.hstack([runs.scores, blocks])), tested, neutral=[p])
    return known, test
