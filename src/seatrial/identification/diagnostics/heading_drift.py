# SPDX-License-Identifier: MIT
"""A heading that turns away with the time: the integral of a gyro without a compass."""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.identification.diagnostics.heading_offset import (
    LEAST_HEADING_OFFSET,
    Correction,
    cost_with,
    in_most_blocks,
    likelier_size,
    with_headings_less,
)
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import maximise_likelihood
from seatrial.identification.selection.score_test import LARGE_GAIN, REPORTED_GAIN
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

ROUNDS = 6  # of offset and drift in turn: each takes up a part of the other
SETTLED = 2e-3  # [rad] of a round


@dataclass(frozen=True)
class HeadingDrift:
    """A drift of the heading that is likelier than none."""

    # fall of -2 log L without it, and without the offset in the middle of each recording
    gain: float
    offset: float  # [rad]
    drift: float  # [rad] at the end of the longest recording
    half: float  # [s] from its middle to its end


def likelier_drift(at: Point) -> HeadingDrift | None:
    """One rate for all recordings, each with the same offset in its middle; None where it gains little."""
    half = 0.5 * max(recording.duration for recording in at.runs.problem.recordings)
    # 1. The drift alone, 0 in the middle of each recording
    first = likelier_size(at, lambda by: _less(half, 0.0, by))
    if first is None or first[1] < REPORTED_GAIN:
        return None
    # 2. With the offset it gains much beyond an offset, in most of the time, and it is no small one
    offset, drift = _offset_and_drift(at, half)
    both = _less(half, offset, drift)
    cost = cost_with(at, both)
    beyond = cost_with(at, _less(half, offset, 0.0)) - cost
    large = 2.0 * abs(drift) > LEAST_HEADING_OFFSET
    if not (large and beyond > LARGE_GAIN and in_most_blocks(at, both)):
        return None
    return HeadingDrift(at.runs.cost - cost, offset, drift, half)


def drift_findings(at: Point, found: HeadingDrift, least: Array) -> list[Finding]:
    """The drift after a fit with corrected headings. least: (12,) floor of the noise."""
    problem, drift = at.runs.problem, found.drift
    correct = _less(found.half, found.offset, drift)
    without = replace(problem, recordings=tuple(map(correct, problem.recordings)))
    with suppress(IdentificationError):  # the first estimate is near enough
        there = maximise_likelihood(without, at.theta, at.noise, least=least)
        drift += _offset_and_drift(there, found.half)[1]
    return [finding_of(FindingKind.HEADING_DRIFT, rate=60.0 * abs(drift) / found.half)]


def _offset_and_drift(at: Point, half: float) -> tuple[float, float]:
    """The likeliest offset and drift [rad], each by its own parabola in turn."""
    offset = drift = 0.0
    for _ in range(ROUNDS):
        more = _size(at, half, (offset, drift), (1.0, 0.0))
        offset += more
        faster = _size(at, half, (offset, drift), (0.0, 1.0))
        drift += faster
        if max(abs(more), abs(faster)) < SETTLED:
            break
    return offset, drift


def _size(at: Point, half: float, known: tuple[float, float], along: tuple[float, float]) -> float:
    """How much more than the known offset and drift the parabola asks for; 0 where it is not identifiable."""

    def of(by: float) -> Correction:
        return _less(half, known[0] + by * along[0], known[1] + by * along[1])

    found = likelier_size(at, of, cost_with(at, of(0.0)))
    return 0.0 if found is None else found[0]


def _less(half: float, offset: float, drift: float) -> Correction:
    """Headings less by an offset [rad] and a drift, which is as large as stated `half` [s] after the middle."""

    def correct(recording: Recording) -> Recording:
        middle = 0.5 * float(recording.t[0] + recording.t[-1])
        return with_headings_less(
            recording,
            lambda psi, stamps: (
                np.full_like(psi, offset) + drift / half * (recording.seconds(stamps) - middle)
            ),
        )

    return correct
