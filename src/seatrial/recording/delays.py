# SPDX-License-Identifier: MIT
"""Positions and headings of one stamp that were measured at two times."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from seatrial.recording.recording import Recording
from seatrial.util.frames import Array, Index, Stamps


def at_one_time(recording: Recording) -> Recording:
    """The recording with positions at the time of the headings, by cubic interpolation.

    A pose is valid where those around it are, in one segment. Filters do not need it: to them
    position and heading are two measurements.
    """
    delay = recording.position_delay
    if delay == 0.0:
        return recording
    index = np.flatnonzero(recording.valid)
    known, wanted = recording.t[index], recording.t + delay
    after = np.clip(np.searchsorted(known, wanted, side="right"), 1, len(known) - 1)
    before = (after - 1).astype(np.int64)
    within = (wanted >= known[0]) & (wanted <= known[-1])
    within &= recording.segment[index[before]] == recording.segment[index[after]]
    eta = recording.eta.copy()
    slopes = _slopes(known, recording.eta[index, :2], recording.segment[index])
    eta[:, :2] = _hermite(known, recording.eta[index, :2], slopes, before, wanted)
    eta[~within] = recording.eta[~within]
    valid = recording.valid & within & (recording.segment == recording.segment[index[before]])
    return replace(recording, eta=eta, valid=valid, position_delay=0.0)


def _slopes(t: Array, values: Array, segment: Index) -> Array:
    """Slopes (n, 2) by three points of one segment, at its ends by two; 0 where a pose is alone."""
    slopes = np.zeros_like(values)
    ends = np.flatnonzero(np.diff(segment, prepend=segment[0], append=segment[-1] + 1))
    for first, end in pairwise([0, *ends.tolist()]):
        if end - first > 1:
            slopes[first:end] = np.gradient(values[first:end], t[first:end], axis=0)
    return slopes


def _hermite(t: Array, values: Array, slopes: Array, before: Index, wanted: Array) -> Array:
    """Values (n, 2) at the times wanted (n,), between t[before] and the next."""
    length = (t[before + 1] - t[before])[:, None]
    s = (wanted - t[before])[:, None] / length
    first, second = values[before], values[before + 1]
    return np.asarray(
        first * (1 + 2 * s) * (1 - s) ** 2
        + second * s**2 * (3 - 2 * s)
        + length * (slopes[before] * s * (1 - s) ** 2 - slopes[before + 1] * s**2 * (1 - s))
    )


def with_delays(recording: Recording, position: float, heading: float) -> Recording:
    """The recording with positions and headings that are older by these times [s]."""
    if position == heading == 0.0:
        return recording
    asynchronous = recording.asynchronous
    return replace(
        recording,
        stamps=stamps_of_headings(recording.stamps, heading),
        asynchronous=None if asynchronous is None else asynchronous.shifted(-round(1e9 * heading)),
        position_delay=recording.position_delay + position - heading,
    )


def stamps_of_headings(stamps: Stamps, heading_delay: float) -> Stamps:
    """Stamps [ns] less the delay [s] of the headings."""
    return stamps - round(1e9 * heading_delay)


def heading_at_positions(stamps: Stamps, psi: Array, position_delay: float) -> Array:
    """Heading (n,) [rad] when the position of each pose was measured, `position_delay` [s] before it."""
    order = np.argsort(stamps, kind="stable")
    order = order[np.isfinite(psi[order])]
    if position_delay == 0.0 or len(order) == 0:
        return psi
    seconds = (stamps - stamps[order[0]]).astype(np.float64) * 1e-9
    turned = np.unwrap(psi[order])
    found = np.interp(seconds - position_delay, seconds[order], turned)
    return np.where(np.isfinite(psi), found, psi)
