# SPDX-License-Identifier: MIT
"""Means of neighbouring poses: a fast tracker has more poses than the motion of a boat needs."""

from dataclasses import replace

import numpy as np

from seatrial.recording.recording import Recording
from seatrial.util.frames import Array, Index, Stamps

EVEN = 0.1  # of two steps, by which they differ at most
# [Hz] of poses: a boat moves smoothly between them, and their noise averages out
ENOUGH_RATE = 40.0


def with_enough_poses(recording: Recording) -> Recording:
    """The recording with at most twice `ENOUGH_RATE`: each pose the mean of neighbours, without a fault between.

    Poses of which position and heading have rates of their own stay as they are.
    """
    count = int(1.0 / (recording.period * ENOUGH_RATE)) if recording.period > 0 else 1
    if count < 2 or recording.parts is not None:
        return recording
    first = _groups(recording, count)
    if not recording.valid[first].sum() >= 2:
        return recording
    rows = first[:, None] + np.arange(count)
    middle = rows[:, count // 2]
    valid = recording.valid[middle]
    stamps = recording.stamps[middle].copy()
    eta = recording.eta[middle].copy()
    own = rows[valid]
    offsets = (recording.stamps[own] - recording.stamps[own[:, :1]]).astype(np.float64)
    stamps[valid] = recording.stamps[own[:, 0]] + np.rint(offsets.mean(axis=1)).astype(np.int64)
    eta[valid] = at_middle(stamps[valid], recording.eta[own].mean(axis=1), count)
    moved = float(stamps[0] - recording.stamps[0]) * 1e-9
    faults = tuple(replace(f, start=f.start - moved, end=f.end - moved) for f in recording.faults)
    text = (
        f"poses at {1.0 / recording.period:.0f} Hz: each {count} are averaged, as a boat moves smoothly "
        "between them"
    )
    return replace(
        recording, stamps=stamps, eta=eta, raw=recording.raw[middle], valid=valid,
        segment=recording.segment[middle], faults=faults, remarks=(*recording.remarks, text),
    )  # fmt: skip


def at_middle(stamps: Stamps, means: Array, count: int) -> Array:
    """Values in the middle of groups of `count` rows from their means (m, k) at stamps (m,).

    A mean over a time T is x + T^2 (1 - 1 / count^2) x'' / 24. x'' is that of the means, where three follow
    each other evenly; as it is small beside them it adds little noise.
    """
    out = means.copy()
    steps = np.diff(stamps).astype(np.float64)
    even = np.abs(steps[1:] - steps[:-1]) < EVEN * (steps[1:] + steps[:-1])
    even &= steps[1:] < 2.0 * np.median(steps)
    bend = means[2:] - 2.0 * means[1:-1] + means[:-2]
    out[1:-1] -= np.where(even[:, None], bend, 0.0) * (1.0 - 1.0 / count**2) / 24.0
    return out


def _groups(recording: Recording, count: int) -> Index:
    """First rows (m,) of groups of `count` rows that are alike: usable or not, of one segment, close in time."""
    steps = np.diff(recording.t)
    alike = (np.diff(recording.valid.astype(int)) == 0) & (np.diff(recording.segment) == 0)
    alike &= steps < 2.0 * recording.period
    run: Array = np.concatenate([[0], np.cumsum(~alike)])
    begins = np.flatnonzero(np.concatenate([[True], ~alike]))
    place = np.arange(len(run)) - begins[run.astype(np.int64)]
    first = np.flatnonzero(place % count == 0)
    first = first[first + count <= len(run)]
    return np.asarray(first[run[first + count - 1] == run[first]], dtype=np.int64)
