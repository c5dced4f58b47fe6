# SPDX-License-Identifier: MIT
"""Motion before the boat is driven and after it: the boat is carried, towed or adrift."""

import shlex
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

LEAST_COMMAND = 0.02  # of full command
COASTING = 10.0  # [s] after the last command, in which a boat still moves by itself
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
    first: bool  # before the first command, else after the last

    def text(self, recording: Recording) -> str:
        """What was found in the recording, and what to do."""
        when = "before the first command" if self.first else "after the last command"
        return (
            f"the boat moves {self.moved:.0f} m in the {self.end - self.start:.0f} s {when}: carried, towed or "
            f"adrift? Leave it out with --without {shlex.quote(self.span(recording))}"
        )

    def span(self, recording: Recording) -> str:
        """NAME=FROM-TO of the recorded file, as --without has it."""
        begin, end = recording.offset + self.start, recording.offset + self.end
        return f"{recording.name}=" + (f"-{end:.0f}" if self.first else f"{begin:.0f}-")


def undriven_motion(recording: Recording) -> list[Undriven]:
    """Such stretches at the beginning and at the end."""
    driven = _driven(recording)
    if driven is None:
        return []
    t, end = recording.t, float(recording.t[-1])
    first, last = driven[0] - LEAD, min(driven[1] + COASTING, end)
    own = _displacements(recording, first, last)  # none in a drive of a few poses
    usual = float(np.percentile(own, FASTEST)) if len(own) else 0.0
    return list(_moving(recording, ((float(t[0]), first, True), (last, end, False)), usual))


def _driven(recording: Recording) -> tuple[float, float] | None:
    """From when and until when [s] a command is in effect: each holds until the next, or until it is unknown."""
    held = recording.seconds(recording.commands.stamps)
    rows = np.flatnonzero(np.abs(recording.commands.values).max(axis=1) > LEAST_COMMAND)
    if len(rows) == 0:
        return None
    since = float(held[rows[-1]])
    ends = [start for start, _ in recording.unknown if start >= since]
    until = min([float(recording.t[-1]), *held[rows[-1] + 1 :][:1].tolist(), *ends])
    return float(held[rows[0]]), until


def _moving(
    recording: Recording, stretches: tuple[tuple[float, float, bool], ...], usual: float
) -> Iterator[Undriven]:
    for start, end, first in stretches:
        found = _displacements(recording, start, end)
        if len(found) and found.max() > max(LEAST_MOVED, LEAST_PACE * usual):
            inside = ~recording.excluded & (recording.t >= start) & (recording.t <= end)
            extent = np.nanmax(recording.eta[inside, :2], axis=0) - np.nanmin(
                recording.eta[inside, :2], axis=0
            )
            yield Undriven(start, end, float(np.hypot(*extent)), first)


def _displacements(recording: Recording, start: float, end: float) -> Array:
    """Displacements (n,) [m] in windows of `WINDOW` between two times, from medians over a second."""
    known = (
        ~recording.excluded
        & np.isfinite(recording.eta[:, :2]).all(axis=1)
        & (recording.t >= start)
        & (recording.t <= end)
    )
    t, xy = recording.t[known], recording.eta[known, :2]
    if len(t) == 0:
        return np.empty(0)
    seconds = np.floor(t - start).astype(int)
    begins = np.flatnonzero(np.diff(seconds, prepend=-1))
    parts = np.split(xy, begins[1:])
    middles = np.array([np.median(part, axis=0) for part in parts])
    ticks = seconds[begins]
    later = np.searchsorted(ticks, ticks + WINDOW)
    able = later < len(ticks)
    return np.asarray(np.hypot(*(middles[later[able]] - middles[able]).T))
