# SPDX-License-Identifier: MIT
"""Accelerations from poses by local quadratics, and commands smoothed by the matching kernel.

Second differences of poses are dominated by noise; a quadratic through 1.2 s of them is not. Its
curvature is the true acceleration averaged over the window with weight (1 - s^2)^2, s from -1 to 1.
So commands are averaged with the same weight before the two are compared.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.util.frames import Array, Index, Mask, Stamps
from seatrial.util.frozen import once

Complex = NDArray[np.complex128]

# [s] of one quadratic: long against pose noise, short against the boat's time constants
WINDOW = 1.2
MOST_TURN = 2.0  # [rad] within a window, of a craft that spins: else forces average out in it
SPINS = 4.0  # [rad] within a usual window, from which on a craft spins
TURN_SPAN = 0.1  # [s] over which its yaw rate is seen
STRIDE = 0.2  # [s] between the windows' centres
MOST_STRETCH = 1.3  # times the nominal length; a longer window (dropped poses) is not used
COMMAND_GRID = 0.02  # [s] at which commands are averaged
KERNEL_STEPS = 30  # of the grid in half a window, at the most
MOST_GRID_STEPS = 2_000_000  # of the whole grid: bounds memory


@dataclass(frozen=True)
class Smooth:
    """Velocities and accelerations at the centres of windows; the plane is complex, x + i y."""

    t: Array  # (m,) [s]
    half: float  # [s] half the length of a window
    psi: Array  # (m,) [rad]
    r: Array  # (m,) [rad/s]
    r_dot: Array  # (m,) [rad/s^2]
    velocity: Complex  # (m,) [m/s] earth-fixed
    acceleration: Complex  # (m,) [m/s^2] earth-fixed

    def at(self, windows: Index | Mask | slice) -> "Smooth":
        """Some of the windows."""
        return Smooth(
            self.t[windows], self.half, self.psi[windows], self.r[windows], self.r_dot[windows],
            self.velocity[windows], self.acceleration[windows],
        )  # fmt: skip


@once
def smooth(recording: Recording) -> Smooth:
    """Local quadratics of a recording, of the usual length and spacing; computed once."""
    return smooth_poses(recording.t, recording.eta, recording.valid, recording.segment)


def smooth_poses(
    t: Array,
    eta: Array,
    valid: Mask,
    segment: Index,
    *,
    window: float | None = None,
    stride: float = STRIDE,
) -> Smooth:
    """Local quadratics through the usable poses eta (n, 3) at t (n,) [s].

    `window` [s] long, every `stride` [s]; by default `WINDOW`, less for a craft that spins. No window
    reaches over a gap or a jump.
    """
    period = float(np.median(np.diff(t)))  # [s]
    index = np.flatnonzero(valid)
    window = _turning_window(t[index], eta[index, 2]) if window is None else window
    side = max(2, round(window / 2 / period))
    count = 2 * side + 1
    windows = np.zeros((0, count), dtype=np.int64)
    if len(index) >= count:
        windows = np.lib.stride_tricks.sliding_window_view(index, count)
        windows = windows[:: max(1, round(stride / period))]
    half = (side + 0.5) * period
    s = (t[windows] - t[windows[:, side]][:, None]) / half
    usable = s[:, -1] - s[:, 0] < 2 * MOST_STRETCH
    usable &= segment[windows[:, 0]] == segment[windows[:, -1]]
    windows, s = windows[usable], s[usable]
    value, slope, bend = np.moveaxis(_quadratics(s, eta[windows]), 1, 0)
    velocity, acceleration = slope / half, 2.0 * bend / half**2
    return Smooth(
        t[windows[:, side]],
        half,
        value[:, 2],
        velocity[:, 2],
        acceleration[:, 2],
        velocity[:, 0] + 1j * velocity[:, 1],
        acceleration[:, 0] + 1j * acceleration[:, 1],
    )


def _turning_window(t: Array, psi: Array) -> float:
    """Length [s] in which a craft turns by `MOST_TURN` at most; `WINDOW` for a boat."""
    fast = turning_rate(t, psi)
    return MOST_TURN / fast if fast * WINDOW > SPINS else WINDOW


def turning_rate(t: Array, psi: Array) -> float:
    """Yaw rate [rad/s] of a craft that turns fast: 90 % of the time it is below."""
    apart = max(1, round(TURN_SPAN / float(np.median(np.diff(t))))) if len(t) > 1 else 1
    if len(t) <= apart:
        return 0.0
    rate = np.abs(psi[apart:] - psi[:-apart]) / (t[apart:] - t[:-apart])
    return float(np.percentile(rate, 90))


def _quadratics(s: Array, values: Array) -> Array:
    """Coefficients (m, 3, k) of 1, s, s^2 through values (m, count, k) at s (m, count)."""
    square = s * s
    powers = np.stack([np.ones_like(s), s, square, square * s, square * square])  # (5, m, count)
    moments = powers.sum(axis=2)
    normal = np.stack([moments[i : i + 3] for i in range(3)])  # (3, 3, m)
    right = np.einsum("pmc,mck->mpk", powers[:3], values)
    return np.linalg.solve(np.moveaxis(normal, 2, 0), right)


@dataclass(frozen=True)
class Averaged:
    """Zero-order-hold rows of a signal, averaged like the accelerations, at even times."""

    begin: float  # [s]
    step: float  # [s]
    rows: Array  # (k, names)

    def before(self, centres: Array, delays: Array) -> Array:
        """Rows at the centres (m,) [s] minus each delay [s]: (delays, m, names)."""
        place = (centres - delays[:, None] - self.begin) / self.step
        row = place.astype(np.int64)
        low = self.rows[row]
        return np.asarray(low + (place - row)[:, :, None] * (self.rows[row + 1] - low))


def averaged(
    signal: Signal, origin: int, centres: Array, half: float, delays: tuple[float, float]
) -> Averaged:
    """The signal for centres (m,) [s] minus delays [s] of this range; windows of `half` their length.

    `origin` [ns] is the zero of the centres; before the first row it holds.
    """
    lowest = float(centres[0]) - delays[1] - half
    highest = float(centres[-1]) - delays[0] + half
    # poses far apart need no fine grid
    step = max(COMMAND_GRID, half / KERNEL_STEPS, (highest - lowest) / MOST_GRID_STEPS)
    grid = np.arange(lowest, highest + 2 * step, step)
    held = signal.values[held_rows(signal.stamps, origin, grid)]
    s = np.arange(-half, half + step / 2, step) / half
    kernel = np.clip(1.0 - s**2, 0.0, None) ** 2
    kernel /= kernel.sum()
    rows = np.column_stack([np.convolve(column, kernel, mode="same") for column in held.T])
    return Averaged(lowest, step, rows)


def smooth_signals(
    signal: Signal, origin: int, centres: Array, half: float, delays: Sequence[float]
) -> Array:
    """The same at the centres minus each delay [s]: (delays, m, names)."""
    if len(centres) == 0:
        return np.zeros((len(delays), 0, len(signal.names)))
    found = averaged(signal, origin, centres, half, (min(delays), max(delays)))
    return found.before(centres, np.asarray(delays))


def held_rows(stamps: Stamps, origin: int, t: Array) -> Index:
    """The row that holds at each time t [s] after origin [ns]; before the first, the first."""
    seconds = (stamps - origin).astype(np.float64) * 1e-9
    return np.maximum(np.searchsorted(seconds, t, side="right") - 1, 0)
