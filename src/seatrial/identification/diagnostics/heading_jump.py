# SPDX-License-Identifier: MIT
"""A heading that is off on one side of its jump: an estimator that resets its yaw, a compass that is aligned anew.

Where a map is turned as a whole, as by SLAM that closes a loop, the course turns with the heading. Poses then
fit far worse with the heading turned back alone. Both alternatives have the same parameters.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from seatrial import _core
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.identification.diagnostics.heading_offset import (
    LEAST_HEADING_OFFSET,
    cost_of,
    with_headings_less,
)
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.selection.score_test import LARGE_GAIN, REPORTED_GAIN
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array, Stamps

MOST_JUMPS = 4  # that are tested, the largest first


@dataclass(frozen=True)
class HeadingJump:
    """A jump of the heading alone."""

    gain: float  # fall of -2 log L without it
    size: float  # [rad]
    recording: str
    time: float  # [s]

    @property
    def findings(self) -> list[Finding]:
        """What is reported of it."""
        size = abs(self.size)
        return [finding_of(FindingKind.HEADING_JUMP, self.recording, size=size, at=self.time)]


def likelier_jump(at: Point, *, mismatch: bool = False) -> HeadingJump | None:
    """The jump of a heading without which poses fit best, and far better than with it.

    mismatch: the noise is that of a fit under model mismatch, which the jump itself enlarges: less is much.
    """
    least = REPORTED_GAIN if mismatch else LARGE_GAIN
    recordings = at.runs.problem.recordings
    jumps = [(size, i, stamp) for i, r in enumerate(recordings) for size, stamp in heading_jumps(r)]
    largest = sorted(jumps, key=lambda jump: -abs(jump[0]))[:MOST_JUMPS]
    found = [_tested(at, i, size, stamp) for size, i, stamp in largest]
    return max((one for one in found if one.gain > least), key=lambda one: one.gain, default=None)


def heading_jumps(recording: Recording) -> Iterator[tuple[float, int]]:
    """Size [rad] and first stamp [ns] behind each jump for good that the heading takes part in."""
    for fault in recording.faults:
        after = int(np.searchsorted(recording.t, fault.end))
        if fault.kind is FaultKind.JUMP and 1 < after < len(recording.t) - 1:
            stamps, psi = _headings(recording, slice(after - 2, after + 2))
            steps = np.diff(psi)
            at = 1 + int(np.argmax(np.abs(steps[1:-1])))
            # without the turn of the boat
            size = float(steps[at] - 0.5 * (steps[at - 1] + steps[at + 1]))
            if abs(size) > LEAST_HEADING_OFFSET:
                yield size, int(stamps[at + 1])


def _headings(recording: Recording, rows: slice) -> tuple[Stamps, Array]:
    """Stamps (n,) [ns] and headings (n,) [rad] of some poses; with headings of their own, those between them."""
    stamps, psi = recording.stamps[rows], recording.eta[rows, 2]
    more = recording.asynchronous
    if more is None:
        return stamps, psi
    own = (
        (more.parts == _core.HEADING_PART) & (more.stamps > stamps[0]) & (more.stamps < stamps[-1])
    )
    # headings of the poses are interpolated from these
    return (more.stamps[own], more.values[own]) if own.sum() > len(psi) else (stamps, psi)


def _tested(at: Point, place: int, size: float, stamp: int) -> HeadingJump:
    problem = at.runs.problem
    recording = problem.recordings[place]
    back = with_headings_less(recording, lambda _, stamps: np.where(stamps < stamp, 0.0, size))
    recordings = (*problem.recordings[:place], back, *problem.recordings[place + 1 :])
    gain = at.runs.cost - cost_of(at, replace(problem, recordings=recordings))
    time = float(recording.seconds(np.array([stamp]))[0])
    return HeadingJump(gain, size, recording.name, time)
