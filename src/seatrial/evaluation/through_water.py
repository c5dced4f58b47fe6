# SPDX-License-Identifier: MIT
"""Recordings whose current a model was identified with: their poses through the water."""

from math import hypot

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.boat.schema import RecordingEntry
from seatrial.recording.origin import poses_of_origin
from seatrial.recording.recording import Recording


def same_recording(entry: RecordingEntry, recording: Recording) -> bool:
    """Whether a model's entry is this recording or another part of it: same files, or same name."""
    own = {source.sha256 for source in recording.sources}
    files = {file.sha256 for file in entry.files}
    return own == files if own and files else recording.name == entry.name


def known_current(model: Model, recording: Recording) -> tuple[float, float]:
    """The current (x, y) [m/s, earth-fixed, z up] that the model was identified with in this recording."""
    for entry in model.recordings:
        x, y = (entry.effects.get(name, 0.0) for name in ("current_x", "current_y"))
        if (x or y) and same_recording(entry, recording):
            return x, y
    return 0.0, 0.0


def through_water(model: Model, recording: Recording) -> tuple[Recording, tuple[Finding, ...]]:
    """The recording with poses in axes that drift with the current of its entry, and a finding on it.

    The model's velocities are relative to the water. Without an estimated current the recording as it is.
    """
    x, y = known_current(model, recording)
    if not (x or y):
        return recording, ()
    moved = poses_of_origin(recording, np.zeros(2), np.array([x, y]))
    return moved, (finding_of(FindingKind.THROUGH_WATER, current=hypot(x, y)),)
