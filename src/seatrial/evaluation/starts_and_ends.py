# SPDX-License-Identifier: MIT
"""Pairs of poses of a recording that are one horizon apart."""

import numpy as np

from seatrial.evaluation.expected_error import Poses
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion
from seatrial.util.errors import RecordingError

OFF, OFF_SHARE = 0.75, 0.05  # of a period, of the horizon: a pose that far from it will do


def check_horizon(horizon: float) -> None:
    """Raises RecordingError for a horizon [s] that is none."""
    if not 0 < horizon < np.inf:
        raise RecordingError(f"horizon {horizon:g} s: expected a positive number of seconds")


def starts_and_ends(
    recording: Recording, begins: Motion, ends: Motion, horizon: float, every: int = 1
) -> tuple[Poses, Poses]:
    """Poses to start from, every so many, and for each the one that is nearest to `horizon` [s] later.

    Raises RecordingError for a horizon that is none, or for which the poses are too far apart or the intervals too
    short.
    """
    check_horizon(horizon)
    if not (every >= 1 and every % 1 == 0):
        raise RecordingError(f"every {every}: expected a whole number of poses from 1 on")
    if round(horizon / recording.period) < 1:
        raise RecordingError(
            f"{recording.name}: horizon {horizon:g} s is shorter than the time between poses, "
            f"{recording.period:.3f} s; choose a longer one"
        )
    t = recording.t
    start = np.flatnonzero(t <= t[-1] - horizon + 0.5 * recording.period)
    after = np.clip(np.searchsorted(t, t[start] + horizon), 1, len(t) - 1)
    before = 2.0 * (t[start] + horizon) < t[after - 1] + t[after]
    end = after - before
    usable = (end > start) & begins.valid[start] & ends.valid[end]
    off = np.abs(t[end] - t[start] - horizon)
    usable &= off < max(OFF * recording.period, OFF_SHARE * horizon)
    for begin, over in recording.unknown:
        usable &= (recording.t[end] < begin) | (recording.t[start] > over)
    if not usable.any():
        raise RecordingError(
            f"{recording.name}: no two usable velocities {horizon:g} s apart in "
            f"{recording.duration:.1f} s with {int(recording.valid.sum())} usable poses; "
            "record longer, or take a shorter --horizon"
        )
    start, end = start[usable], end[usable]
    kept = start % every == start[0] % every
    return start[kept], end[kept]
