# SPDX-License-Identifier: MIT
"""Pose noise from the poses themselves."""

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.schema import CorrelatedEntry, NoiseEntry
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Mask, body_velocity

EVEN = 0.5  # share of windows at even stamps, below which all are taken as uneven as they are
EVENLY = 0.06  # periods by which the steps of such a window may differ: more, times a speed, looks like noise
NO_RATE = 1e-6  # [rad/s]
_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])  # kills cubics: smooth motion leaves no trace


def pose_noise(*recordings: Recording, first: int | None = None) -> NoiseEntry:
    """Standard deviations of white pose noise [m], [rad], from fourth differences.

    The median keeps pulses and jumps out. Noise that is correlated over several poses is not seen.
    `first`: of each recording's first so many usable poses; of all by default.
    """
    parts = [_differences(r, r.eta, _windows(r, first)) for r in recordings]
    differences = np.concatenate([np.zeros((0, 3)), *parts])
    if len(differences) == 0:
        names = ", ".join(r.name for r in recordings)
        raise RecordingError(
            f"{names}: no five usable poses in a row; there are too many drop-outs or the stamps are too uneven"
        )
    return _entry(_spread(differences))


def noise_beside(recording: Recording, moved: Array) -> NoiseEntry:
    """`pose_noise` where it is known how the boat moved: poses `moved` (n, 3), of any start and heading.

    NaN where it isn't. Poses that are rare have fourth differences by that alone. What is not smaller
    without them is as it was. Raises RecordingError as `pose_noise`.
    """
    windows = _windows(recording)
    windows = windows[np.isfinite(moved[windows]).all(axis=(1, 2))]
    own = pose_noise(recording)
    if len(windows) == 0:
        return own
    whole = _differences(recording, recording.eta, windows)
    known = _differences(recording, moved, windows)
    turn = (recording.eta - moved)[_used(recording, windows)[:, 2], 2]
    known[:, :2] = body_velocity(-turn, known)[:, :2]
    rest = _entry(_spread(whole - known))
    return NoiseEntry(min(own.position, rest.position), min(own.heading, rest.heading))


def _windows(recording: Recording, first: int | None = None) -> NDArray[np.int64]:
    """Five usable poses in a row each (m, 5)."""
    index = np.flatnonzero(recording.valid)[:first]
    if len(index) < 5:
        return np.zeros((0, 5), dtype=np.int64)
    windows = np.lib.stride_tricks.sliding_window_view(index, 5)
    return np.asarray(windows[np.ptp(recording.segment[windows], axis=1) == 0])


def _even(recording: Recording, windows: NDArray[np.int64]) -> Mask:
    """Which windows are of even stamps; none where these are few: all are taken as uneven as they are."""
    even = np.ptp(np.diff(recording.t[windows], axis=1), axis=1) < EVENLY * recording.period
    return even if even.sum() > EVEN * len(even) else np.zeros(len(even), dtype=bool)


def _used(recording: Recording, windows: NDArray[np.int64]) -> NDArray[np.int64]:
    even = _even(recording, windows)
    return windows[even] if even.any() else windows


def _differences(recording: Recording, eta: Array, windows: NDArray[np.int64]) -> Array:
    """Fourth differences (m, 3) of poses (n, 3) at the recording's stamps."""
    used = _used(recording, windows)
    if _even(recording, windows).any():
        return np.asarray(np.einsum("k,nki->ni", _DIFFERENCE, eta[used]))
    return _divided(recording.t[used], eta[used])


def _spread(differences: Array) -> Array:
    """Standard deviations (3,) of the white noise that makes such differences."""
    return np.asarray(
        np.median(np.abs(differences), axis=0) / 0.6745 / np.sqrt(np.sum(_DIFFERENCE**2))
    )


def _entry(spread: Array) -> NoiseEntry:
    return NoiseEntry(float(np.sqrt(np.mean(spread[:2] ** 2))), float(spread[2]))


def _divided(t: Array, eta: Array) -> Array:
    """Divided differences (n, 3) of poses (n, 5, 3) at t (n, 5), as noisy as fourth differences are."""
    apart = t[:, :, None] - t[:, None, :] + np.eye(5)
    weights = 1.0 / np.prod(apart, axis=2)
    weights *= np.sqrt(np.sum(_DIFFERENCE**2) / np.sum(weights**2, axis=1))[:, None]
    return np.asarray(np.einsum("nk,nki->ni", weights, eta))


def left_of(entry: CorrelatedEntry, t: Array) -> Array:
    """Correlation of errors that are correlated after t [s] >= 0, of any shape."""
    fades = 1.0 / entry.memory
    left = np.exp(-fades * t)
    if entry.period is None:
        return np.asarray(left)
    # e'' + 2 fades e' + turn^2 e = white noise; over-damped the rate is imaginary
    rate = np.sqrt(complex((2.0 * np.pi / entry.period) ** 2 - fades**2))
    if abs(rate) < NO_RATE:
        return np.asarray(left * (1.0 + fades * t))
    ahead, back = (
        0.5 * (1.0 + k * fades / (1j * rate)) * np.exp((k * 1j * rate - fades) * t) for k in (1, -1)
    )
    return np.asarray((ahead + back).real)  # two that fade: nothing grows, however long t is


def coloured_ratio(period: float, entry: CorrelatedEntry) -> float:
    """Fourth differences, root mean square, of correlated errors, over those of white ones as large.

    `period` [s] of the poses.
    """
    weights = np.correlate(_DIFFERENCE, _DIFFERENCE, "full")[len(_DIFFERENCE) - 1 :]
    rest = 2.0 * left_of(entry, period * np.arange(1.0, len(weights)))
    return float(np.sqrt(1.0 + weights[1:] @ rest / weights[0]))
