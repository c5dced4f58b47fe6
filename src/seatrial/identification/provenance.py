# SPDX-License-Identifier: MIT
"""Provenance of a model: recordings, ranges of speeds and forces."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.model import thrust_trace
from seatrial.boat.schema import EnvelopeEntry, RecordingEntry, SourceEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion
from seatrial.util.frames import SYMBOLS, Array


def envelope(
    vehicle: Vehicle, constants: Array, recordings: Sequence[Recording], moving: Sequence[Motion]
) -> EnvelopeEntry:
    """0.5th to 99.5th percentile of speeds, and the range of forces, over all recordings."""
    nu = np.concatenate([m.nu[m.valid] for m in moving])
    low, high = np.percentile(nu, [0.5, 99.5], axis=0)  # beyond is noise
    ranges: list[Array] = []
    for recording in recordings:
        forces = thrust_trace(vehicle, constants, recording).forces(recording.t)
        ranges += [forces.min(axis=0), forces.max(axis=0)]
    force = np.array(ranges)
    return EnvelopeEntry(
        {s: (float(low[i]), float(high[i])) for i, s in enumerate(SYMBOLS)},
        {
            f.name: (float(force[:, i].min()), float(force[:, i].max()))
            for i, f in enumerate(vehicle.forces)
        },
    )


def recording_entry(recording: Recording) -> RecordingEntry:
    """A recording as the model file names it."""
    files = [SourceEntry(s.name, s.sha256) for s in recording.sources]
    without = [
        (round(recording.offset + f.start, 3), round(recording.offset + f.end, 3))
        for f in recording.faults
        if f.kind is FaultKind.EXCLUDED
    ]
    return RecordingEntry(
        recording.name,
        round(recording.duration, 3),
        round(recording.offset, 3),
        files,
        without=without,
    )
