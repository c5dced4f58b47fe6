# SPDX-License-Identifier: MIT
"""Pose noise from fourth differences of the poses, and the correlation of Gauss-Markov pose errors."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.schema import CorrelatedEntry, NoiseEntry
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Index, Mask, body_velocity
from seatrial.util.frozen import once

EVEN_SHARE = 0.5  # of the windows with regular stamps; below it divided differences of all are used
# periods by which the steps of a regular window differ: times a speed that is an error
EVEN_STEPS = 0.06
CRITICAL_DAMPING = 1e-6  # [rad/s] oscillation rate below which the critically damped form is used
MAD_OF_NORMAL = 0.6745  # median absolute deviation of a standard normal distribution
_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])  # zero for cubics: smooth motion cancels


def pose_noise(*recordings: Recording, first: int | None = None) -> NoiseEntry:
    """Standard deviations of white pose noise [m], [rad], from fourth differences.

    The median is robust to pulses and jumps. Noise that is correlated over several poses cancels, too.
    `first`: number of usable poses from the start of each recording; all by default.
    """
    if len(recordings) == 1 and first is None:
        return _own_noise(*recordings)
    return _noise_of(recordings, first)


@once
def _own_noise(recording: Recording) -> NoiseEntry:
    return _noise_of([recording])


def _noise_of(recordings: Sequence[Recording], first: int | None = None) -> NoiseEntry:
    parts = [_differences(r, r.eta, _windows(r, first)) for r in recordings]
    differences = np.concatenate([np.zeros((0, 3)), *parts])
    if len(differences) == 0:
        names = ", ".join(r.name for r in recordings)
        raise RecordingError(
            f"{names}: no five usable poses in a row; there are too many drop-outs or the stamps are too uneven"
        )
    return _entry(_white_deviation(differences))


def known_pose_noise(*recordings: Recording, first: int | None = None) -> NoiseEntry | None:
    """The same; None where too few usable poses are in a row."""
    try:
        return pose_noise(*recordings, first=first)
    except RecordingError:
        return None


def pose_noise_given_motion(recording: Recording, moved: Array) -> NoiseEntry:
    """`pose_noise` with the boat's motion removed: poses `moved` (n, 3) from any start and heading.

    NaN where the motion is unknown. At low pose rates the motion itself has fourth differences. The
    smaller of the two estimates counts. Raises RecordingError as `pose_noise` does.
    """
    windows = _windows(recording)
    windows = windows[np.isfinite(moved[windows]).all(axis=(1, 2))]
    own = pose_noise(recording)
    if len(windows) == 0:
        return own
    whole = _differences(recording, recording.eta, windows)
    known = _differences(recording, moved, windows)
    even = _even(recording, windows)
    turn = (recording.eta - moved)[(windows[even] if even.any() else windows)[:, 2], 2]
    known[:, :2] = body_velocity(-turn, known)[:, :2]
    rest = _entry(_white_deviation(whole - known))
    return NoiseEntry(min(own.position, rest.position), min(own.heading, rest.heading))


def _windows(recording: Recording, first: int | None = None) -> Index:
    """Windows (m, 5) of five usable poses in a row."""
    index = np.flatnonzero(recording.valid)[:first]
    if len(index) < 5:
        return np.zeros((0, 5), dtype=np.int64)
    windows = np.lib.stride_tricks.sliding_window_view(index, 5)
    segment = recording.segment[index]
    return np.asarray(windows[segment[4:] == segment[:-4]])


def _even(recording: Recording, windows: Index) -> Mask:
    """Windows with regular stamps; none where these are few."""
    steps = np.diff(recording.t[windows].T, axis=0)
    even = np.ptp(steps, axis=0) < EVEN_STEPS * recording.period
    return even if even.sum() > EVEN_SHARE * len(even) else np.zeros(len(even), dtype=bool)


def _differences(recording: Recording, eta: Array, windows: Index) -> Array:
    """Fourth differences (m, 3) of poses (n, 3) at the recording's stamps."""
    even = _even(recording, windows)
    if even.any():
        return np.asarray(np.einsum("k,nki->ni", _DIFFERENCE, eta[windows[even]]))
    return _divided_differences(recording.t[windows], eta[windows])


def _white_deviation(differences: Array) -> Array:
    """Standard deviations (3,) of the white noise with such fourth differences."""
    deviation = np.median(np.abs(differences), axis=0) / MAD_OF_NORMAL
    return np.asarray(deviation / np.sqrt(np.sum(_DIFFERENCE**2)))


def _entry(spread: Array) -> NoiseEntry:
    return NoiseEntry(float(np.sqrt(np.mean(spread[:2] ** 2))), float(spread[2]))


def _divided_differences(t: Array, eta: Array) -> Array:
    """Divided differences (n, 3) of poses (n, 5, 3) at t (n, 5), scaled to the noise of fourth differences."""
    apart = t[:, :, None] - t[:, None, :] + np.eye(5)
    weights = 1.0 / np.prod(apart, axis=2)
    weights *= np.sqrt(np.sum(_DIFFERENCE**2) / np.sum(weights**2, axis=1))[:, None]
    return np.asarray(np.einsum("nk,nki->ni", weights, eta))


def pose_error_correlation(entry: CorrelatedEntry, t: Array) -> Array:
    """Autocorrelation at t [s] >= 0 of Gauss-Markov pose errors, first-order or oscillating."""
    fades = 1.0 / entry.memory
    left = np.exp(-fades * t)
    if entry.period is None:
        return np.asarray(left)
    # e'' + 2 fades e' + turn^2 e = white noise; the rate of an over-damped one is imaginary
    rate = np.sqrt(complex((2.0 * np.pi / entry.period) ** 2 - fades**2))
    if abs(rate) < CRITICAL_DAMPING:
        return np.asarray(left * (1.0 + fades * t))
    ahead, back = (
        0.5 * (1.0 + k * fades / (1j * rate)) * np.exp((k * 1j * rate - fades) * t) for k in (1, -1)
    )
    return np.asarray((ahead + back).real)  # two decaying terms: finite for any t


def correlated_difference_ratio(period: float, entry: CorrelatedEntry) -> float:
    """RMS fourth difference of Gauss-Markov errors over that of white errors of equal variance.

    `period` [s] of the poses.
    """
    weights = np.correlate(_DIFFERENCE, _DIFFERENCE, "full")[len(_DIFFERENCE) - 1 :]
    rest = 2.0 * pose_error_correlation(entry, period * np.arange(1.0, len(weights)))
    return float(np.sqrt(1.0 + weights[1:] @ rest / weights[0]))
