# SPDX-License-Identifier: MIT
"""The noise (11,) that a search begins with, where no model says better.

Fourth differences show how much of it the poses have, but not whether it is correlated: white errors
make as large ones as larger errors do that fade over several poses.
"""

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from seatrial.boat.noise_parameters import (
    COLOUR,
    COLOUR_MEMORY,
    COLOUR_TURN,
    DISTURBANCES,
    MEMORY,
    NOISE_FIRST,
    NOISE_LEAST,
    NOISE_START,
    PROCESS,
    PROCESS_START,
)
from seatrial.boat.schema import CorrelatedEntry
from seatrial.recording.pose_noise import coloured_ratio, pose_noise
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

COLOUR_START = 0.5  # errors of the poses that are correlated over the white ones
LASTING = ((3.0, 3.0), (10.0, 10.0))  # times the white errors, [s]: errors of the poses that last
PUSHED, PUSHED_FOR = (0.03, 0.3), 1.5  # [m/s^2, rad/s^2], [s] of a boat that is pushed
SWINGS = 2.0  # periods over which errors that swing are correlated
BARE = 0.1  # of the white errors that is left where all are said to be correlated


def first_noise(recordings: Sequence[Recording]) -> Array:
    """White errors of the poses as fourth differences show them, and half as large ones that are correlated."""
    own = []
    for recording in recordings:
        with suppress(RecordingError):  # the others may do
            own.append(pose_noise(recording))
    own = own or [pose_noise(*recordings)]
    position, heading = (
        float(np.median([getattr(o, k) for o in own])) for k in ("position", "heading")
    )
    white = np.maximum([position, heading], NOISE_FIRST)
    noise = np.array([*white, *PROCESS_START, *NOISE_START[COLOUR[0] :]])
    noise[COLOUR] = COLOUR_START * noise[:2]
    return noise


def lasting(recordings: Sequence[Recording], times: float, memory: float) -> Array:
    """Nothing that pushes the boat: all that the model does not say are errors of the poses that last."""
    noise = first_noise(recordings)
    noise[PROCESS] = NOISE_LEAST[PROCESS]
    noise[COLOUR] = times * noise[:2]
    noise[COLOUR_MEMORY] = memory
    return noise


def swinging(recordings: Sequence[Recording], times: float, period: float) -> Array:
    """The same for errors that swing with a period [s], as waves make them."""
    noise = lasting(recordings, times, SWINGS * period)
    noise[COLOUR_TURN] = 2.0 * np.pi / period
    return noise


def pushed_and_coloured(recordings: Sequence[Recording]) -> Array:
    """Errors of the poses that are all correlated, and a boat that is pushed: no velocity that wanders."""
    noise = all_coloured(recordings)
    noise[PROCESS] = NOISE_LEAST[PROCESS]
    noise[DISTURBANCES], noise[MEMORY] = PUSHED, PUSHED_FOR
    return noise


def all_coloured(recordings: Sequence[Recording]) -> Array:
    """The same fourth differences, made by correlated errors, as good as alone."""
    noise = first_noise(recordings)
    period = float(np.median([r.period for r in recordings]))
    unit = CorrelatedEntry(1.0, 1.0, float(noise[COLOUR_MEMORY]))
    noise[COLOUR] = noise[:2] / coloured_ratio(period, unit)
    noise[:2] *= BARE
    return noise
