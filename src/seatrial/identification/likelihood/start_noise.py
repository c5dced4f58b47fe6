# SPDX-License-Identifier: MIT
"""Start values of the noise (12,), where no model gives any.

Fourth differences of the poses show the size of their errors, but not whether these are correlated: small
white errors and large correlated ones have the same fourth differences.
"""

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from seatrial.boat.noise_parameters import (
    COLOUR,
    NOISE_FIRST,
    NOISE_START,
    PROCESS_START,
)
from seatrial.boat.schema import CorrelatedEntry
from seatrial.recording.pose_noise import correlated_difference_ratio, pose_noise
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array


def noise_from_poses(recordings: Sequence[Recording]) -> Array:
    """White pose errors from fourth differences, and correlated ones of half their size."""
    own = []
    for recording in recordings:
        with suppress(RecordingError):  # other recordings may do
            own.append(pose_noise(recording))
    own = own or [pose_noise(*recordings)]
    position, heading = (
        float(np.median([getattr(o, k) for o in own])) for k in ("position", "heading")
    )
    white = np.maximum([position, heading], NOISE_FIRST)
    noise = np.array([*white, *PROCESS_START, *NOISE_START[COLOUR[0] :]])
    noise[COLOUR] = 0.5 * noise[:2]
    return noise


def correlated_size(period: float, memory: float) -> float:
    """Size over white errors of Gauss-Markov pose errors with the same fourth differences.

    period: [s] of the poses; memory: [s] of the errors.
    """
    unit = CorrelatedEntry(1.0, 1.0, memory)
    return 1.0 / correlated_difference_ratio(period, unit)
