# SPDX-License-Identifier: MIT
"""Start values of the noise (11,), where no model gives any.

Fourth differences of the poses show the size of their errors, but not whether these are correlated: small
white errors and large correlated ones have the same fourth differences.
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
from seatrial.recording.pose_noise import correlated_difference_ratio, pose_noise
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

CORRELATED_START = 0.5  # of the white errors: size of the correlated ones in a first search
LONG_CORRELATIONS = ((3.0, 3.0), (10.0, 10.0))  # times the white errors, memory [s]
DISTURBANCE_START = (0.03, 0.3)  # [m/s^2], [rad/s^2]
DISTURBANCE_MEMORY = 1.5  # [s]
OSCILLATION_PERIODS = 2.0  # memory of oscillating errors in periods
WHITE_REMAINDER = 0.1  # of the white errors that stays beside correlated ones, which stand for them


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
    noise[COLOUR] = CORRELATED_START * noise[:2]
    return noise


def gauss_markov_poses(recordings: Sequence[Recording], times: float, memory: float) -> Array:
    """No process noise: all residuals are Gauss-Markov pose errors with a memory [s]."""
    noise = noise_from_poses(recordings)
    noise[PROCESS] = NOISE_LEAST[PROCESS]
    noise[COLOUR] = times * noise[:2]
    noise[COLOUR_MEMORY] = memory
    return noise


def oscillating_poses(recordings: Sequence[Recording], times: float, period: float) -> Array:
    """No process noise: all residuals are oscillating pose errors of a period [s], as in waves."""
    noise = gauss_markov_poses(recordings, times, OSCILLATION_PERIODS * period)
    noise[COLOUR_TURN] = 2.0 * np.pi / period
    return noise


def disturbance_and_gauss_markov(recordings: Sequence[Recording]) -> Array:
    """Gauss-Markov pose errors and disturbance forces, without random walks of the velocity."""
    noise = gauss_markov_for_white(recordings)
    noise[PROCESS] = NOISE_LEAST[PROCESS]
    noise[DISTURBANCES], noise[MEMORY] = DISTURBANCE_START, DISTURBANCE_MEMORY
    return noise


def gauss_markov_for_white(recordings: Sequence[Recording]) -> Array:
    """Gauss-Markov pose errors with the fourth differences that the white ones have."""
    noise = noise_from_poses(recordings)
    period = float(np.median([r.period for r in recordings]))
    unit = CorrelatedEntry(1.0, 1.0, float(noise[COLOUR_MEMORY]))
    noise[COLOUR] = noise[:2] / correlated_difference_ratio(period, unit)
    noise[:2] *= WHITE_REMAINDER
    return noise
