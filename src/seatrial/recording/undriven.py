# SPDX-License-Identifier: MIT
"""Motion while the boat is not driven, before, between and after its commands: it is carried, towed or adrift."""

import shlex
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from seatrial.recording.faults.frozen_poses import runs
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Index

LEAST_COMMAND = 0.02  # of full command
COASTING = 10.0  # [s] after a command, in which a boat still moves by itself
LEAD = 1.0  # [s] of rest before the first command that is kept
WINDOW = 5.0  # [s] in which a displacement is seen
LEAST_MOVED = 1.0  # [m] in a window
FASTEST = 90.0  # percentile of the driven boat's displacements, its usual pace
LEAST_PACE = 0.3  # of that pace


@dataclass(frozen=True)
class Undriven:
    """A stretch without commands in which the boat moves."""

    start: float  # [s] from the recording's first pose
    end: float  # [s]
    moved: float  # [m] extent of the motion
    first: bool = False  # before the first command
    last: bool = False  # after the last one

    def text(self, recording: Recording) -> str:
        """What was found in the recording, and what to do."""
        when = "before the first command" if self.first else "after the last command"
        if not (self.first or self.last):
            when = f"without a command from {recording.offset + self.start:.0f} s on"
        return (
            f"the boat moves {self.moved:.0f} m in the {self.end - self.start:.0f} s {when}: carried, towed or "
            f"adrift? Leave it out with --without {shlex.quote(self.span(recording))}"
        )

    def span(self, recording: Recording) -> str:
        """NAME=FROM-TO of the recorded file, as --without has it."""
        begin = "" if self.first else f"{recording.offset + self.start:.0f}"
        end = "" if self.last else f"{recording.offset + self.end:.0f}"
        return f"{recording.name}={begin}-{end}"


def undriven_motion(recording: Recording) -> list[Undriven]:
    """Such stretches in the order of time.

    Between commands only those in which the boat becomes faster: before, it may coast, or drift with the water.
    """
    driven = _driven(recording)
    if not driven:
        return []
    first, last = driven[0][0], driven[-1][1]
    spans = pairwise(_with_unknown(recording, driven))
    pauses = [(a + COASTING, b) for (_, a), (b, _) in spans if b - a > COASTING + WINDOW]
    return [*_moved_outside(recording, first, last, pauses)]


def without_undriven_ends(recording: Recording) -> Recording:
    """The recording without poses before the first change of a command, and after the last, if it moves there.

    Whatever a command at rest is, as the 1500 us of a servo. Where it is towed, that may begin while it coasts.
    """
    values = recording.commands.values
    changes = np.flatnonzero(np.any(np.diff(values, axis=0) != 0.0, axis=1)) + 1
    if not len(changes):
        return recording
    held = recording.seconds(recording.commands.stamps[changes]).tolist()
    for found in _moved_outside(recording, held[0], held[-1]):
        with suppress(RecordingError):  # no poses remain
            recording = recording.without(held[-1] + LEAD if found.last else found.start, found.end)
    return recording


def _moved_outside(
    recording: Recording, first: float, last: float, pauses: Sequence[tuple[float, float]] = ()
) -> Iterator[Undriven]:
    """Motion before the first time [s] of a drive, in its pauses, and after the last time."""
    begin, end = float(recording.t[0]), float(recording.t[-1])
    first, last = first - LEAD, min(last + COASTING, end)
    own = _displacements(recording, first, last)  # none in a drive of a few poses
    usual = float(np.percentile(own, FASTEST)) if len(own) else 0.0
    least = max(LEAST_MOVED, LEAST_PACE * usual)
    yield from _moving(recording, [(begin, first)], least, first=True)
    yield from _moving(recording, pauses, least)
    yield from _moving(recording, [(last, end)], least, last=True)


def _driven(recording: Recording) -> list[tuple[float, float]]:
    """From when and until when [s] commands are in effect: each holds until the next, or until it is unknown."""
    held = recording.seconds(recording.commands.stamps)
    driven = np.abs(recording.commands.values).max(axis=1) > LEAST_COMMAND
    unknown = [start for start, _ in recording.unknown]
    spans = []
    for first, last in runs(driven):
        since = float(held[last])
        ends = [*held[last + 1 :][:1].tolist(), *(start for start in unknown if start >= since)]
        spans.append((float(held[first]), min([float(recording.t[-1]), *ends])))
    return spans


def _with_unknown(
    recording: Recording, driven: Sequence[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Spans [s] with the intervals in which commands are unknown, joined where they overlap."""
    joined: list[tuple[float, float]] = []
    for start, end in sorted([*driven, *recording.unknown]):
        if joined and start <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(joined[-1][1], end)
        else:
            joined.append((start, end))
    return joined


def _moving(
    recording: Recording,
    stretches: Sequence[tuple[float, float]],
    least: float,
    *,
    first: bool = False,
    last: bool = False,
) -> Iterator[Undriven]:
    """Those in which displacements are more than `least` [m]; between commands, more than before."""
    for start, end in stretches:
        found = _displacements(recording, start, end)
        before = 0.0 if first or last else np.minimum.accumulate(found)
        if (found - before > least).any():
            _, xy = _positions(recording, start, end)
            yield Undriven(start, end, float(np.hypot(*np.ptp(xy, axis=0))), first, last)


def _displacements(recording: Recording, start: float, end: float) -> Array:
    """Displacements (n,) [m] in windows of `WINDOW` between two times, from medians over a second.

    None across a jump of the poses that lasts.
    """
    t, xy = _positions(recording, start, end)
    if len(t) == 0:
        return np.empty(0)
    seconds = np.floor(t - start).astype(int)
    begins = np.flatnonzero(np.diff(seconds, prepend=-1))
    middles = _medians(xy, seconds, begins)
    ticks = seconds[begins]
    later = np.searchsorted(ticks, ticks + WINDOW)
    jumps = [fault.start for fault in recording.faults if fault.kind is FaultKind.JUMP]
    jumped = np.searchsorted(jumps, t, side="right")  # how often, up to each pose
    able = np.flatnonzero(later < len(ticks))
    ends = np.append(begins[1:], len(t)) - 1
    able = able[jumped[ends[later[able]]] == jumped[begins[able]]]
    return np.asarray(np.hypot(*(middles[later[able]] - middles[able]).T))


def _medians(values: Array, group: Index, begins: Index) -> Array:
    """Medians (groups, k) of values (n, k) in groups that follow each other, from where each begins."""
    counts = np.diff(begins, append=len(values))
    low, high = begins + (counts - 1) // 2, begins + counts // 2
    columns = [column[np.lexsort((column, group))] for column in values.T]
    return np.column_stack([(column[low] + column[high]) / 2.0 for column in columns])


def _positions(recording: Recording, start: float, end: float) -> tuple[Array, Array]:
    """Times (n,) [s] and positions (n, 2) [m] between two times, without those left out by --without."""
    first = np.searchsorted(recording.t, start)
    within = slice(first, np.searchsorted(recording.t, end, side="right"))
    t, xy = recording.t[within], recording.eta[within, :2]
    known = ~recording.excluded[within] & np.isfinite(xy).all(axis=1)
    return t[known], xy[known]
