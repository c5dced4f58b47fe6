# SPDX-License-Identifier: MIT
"""Pose noise from the poses themselves."""

import numpy as np

from seatrial.errors import RecordingError
from seatrial.recording import Recording
from seatrial.schema import NoiseEntry

_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])  # kills cubics: smooth motion leaves no trace


def pose_noise(*recordings: Recording, first: int | None = None) -> NoiseEntry:
    """Standard deviations of white pose noise [m], [rad], from fourth differences.

    The median keeps pulses and jumps out. Noise that is correlated over several poses is not seen.
    `first`: of each recording's first so many usable poses; of all by default.
    """
    parts = []
    for recording in recordings:
        index = np.flatnonzero(recording.valid)[:first]
        if len(index) < 5:
            continue
        windows = np.lib.stride_tricks.sliding_window_view(index, 5)
        even = np.ptp(np.diff(recording.t[windows], axis=1), axis=1) < 0.5 * recording.period
        even &= np.ptp(recording.segment[windows], axis=1) == 0
        parts.append(np.einsum("k,nki->ni", _DIFFERENCE, recording.eta[windows[even]]))
    differences = np.concatenate(parts) if parts else np.zeros((0, 3))
    if len(differences) == 0:
        names = ", ".join(r.name for r in recordings)
        raise RecordingError(
            f"{names}: no five usable poses in a row; there are too many drop-outs or the stamps are too uneven"
        )
    spread = np.median(np.abs(differences), axis=0) / 0.6745 / np.sqrt(np.sum(_DIFFERENCE**2))
    return NoiseEntry(float(np.sqrt(np.mean(spread[:2] ** 2))), float(spread[2]))


def hanging(period: float, memory: float) -> float:
    """Fourth differences, root mean square, of errors that hang together, over those of white ones as large.

    `period` [s] of the poses; the errors' correlation fades with the time constant `memory` [s].
    """
    weights = np.correlate(_DIFFERENCE, _DIFFERENCE, "full")[len(_DIFFERENCE) - 1 :]
    fades = 2.0 * np.exp(-np.arange(1, len(weights)) * period / memory)
    return float(np.sqrt(1.0 + weights[1:] @ fades / weights[0]))
