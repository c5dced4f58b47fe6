# SPDX-License-Identifier: MIT
"""Gain from each input to each axis, estimated without the vehicle file's structure.

The inertial acceleration in body axes is regressed on all inputs and on a drag basis that is
the same for every axis. The squared acceleration is invariant under rotation and reflection of the
poses, so readings of the poses are compared by the part that stays unexplained.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial.inspection.consistency.accelerations import (
    SPINS,
    STRIDE,
    WINDOW,
    Smooth,
    smooth,
    smooth_poses,
    smooth_signals,
    turning_rate,
)
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.util.frames import Array, Index
from seatrial.util.statistics import BLOCK

# [s] tried from a command to its effect: the usual actuator delays
DELAYS = (-0.15, 0.0, 0.15, 0.3, 0.45, 0.6)
UNEXPLAINED_BLOCK = 5.0  # [s] blocks for comparing the unexplained acceleration of two readings
WHITE_SHRINKAGE = 0.3  # of the gains' covariance towards that of white residuals
# of an axis' RMS acceleration that inputs may explain beyond the file's structure
UNMODELLED_SHARE = 0.07
DRAG_COLUMNS, WIND = 12, 2  # columns of `_drag`, the last of them of a steady wind
# of the squared acceleration that drag and inputs leave, over what is left with a wind, too: a weaker one costs
# the inputs more than it gives them
LEAST_WIND_RATIO = 1.5
SQUARES_AT_REST = 1e-12  # added to sums of squares: a boat at rest without noise has 0
# [s] of a window at most: with longer ones the boat turns too far
LONGEST_WINDOW = 4 * WINDOW
# fall of the squared acceleration in windows twice as long that shows noise: white noise falls by 32, that of
# positions that wander by 8, a boat's own acceleration by 1.1 to 2.5
NOISE_FALL = 3.0
PROBED = 5  # of so many windows one shows whether they are long enough
# of the mean diagonal: inputs that never change would make the equations singular
GAINS_RIDGE = 1e-6


@dataclass(frozen=True)
class Run:
    """One recording with one reading of its poses."""

    recording: Recording
    commands: Signal  # of the inputs (n)
    smooth: Smooth
    stride: float = STRIDE  # [s] between windows
    window: float | None = None  # [s] of a quadratic; None: the usual one

    @cached_property
    def inputs(self) -> Array:
        """The commands averaged like the accelerations, for each delay: (DELAYS, m, n)."""
        s = self.smooth
        return smooth_signals(self.commands, self.recording.origin, s.t, s.half, DELAYS)

    def delayed(self, offset: float) -> "Run":
        """The run with its commands delayed by `offset` [s]."""
        c = self.commands
        return replace(self, commands=Signal(c.names, c.stamps + round(1e9 * offset), c.values))

    def thinned(self, every: int) -> "Run":
        """The run with one window of so many."""
        few = self.smooth.at(slice(None, None, every))
        thinned = replace(self, smooth=few, stride=every * self.stride)
        thinned.__dict__["inputs"] = self.inputs[:, ::every]  # averaged around the same centres
        return thinned


@dataclass(frozen=True)
class Gains:
    """Gains of one axis: acceleration for each input at 1. Of h hypotheses there is a row of each."""

    values: Array  # (n,) or (h, n) [m/s^2] or [rad/s^2] per unit of command
    t: Array  # the same over their standard errors
    precision: Array  # (n, n) or (h, n, n) inverse covariance, `UNMODELLED_SHARE` included

    @property
    def total(self) -> Array:
        """Chi-square () or (h,) of the hypothesis that all gains are 0."""
        return np.asarray(np.einsum("...i,...ij,...j", self.values, self.precision, self.values))


Runs = Sequence[Run]


def read_runs(
    recordings: Sequence[Recording], commands: Sequence[Signal], *, spacing: float = 1.0
) -> list[Run]:
    """Recordings with their poses as read; spacing: factor on the distance between windows.

    Windows are twice as long, and twice again, while positions' noise has most of the acceleration.
    """
    runs = [_read_run(r, own, spacing) for r, own in zip(recordings, commands, strict=True)]
    fastest = max(turning_rate(r.t[r.valid], r.eta[r.valid, 2]) for r in recordings)
    longest = min(LONGEST_WINDOW, SPINS / max(fastest, SPINS / LONGEST_WINDOW))
    window = 2.0 * WINDOW
    while window <= longest:
        some = [_in_windows(run, 0.5 * window, thinned=PROBED) for run in runs]
        longer = [_in_windows(run, window, thinned=PROBED) for run in runs]
        if _acceleration(some) < NOISE_FALL * _acceleration(longer):
            break
        runs = [_in_windows(run, window) for run in runs]
        window *= 2.0
    return runs


def _read_run(recording: Recording, commands: Signal, spacing: float) -> Run:
    if spacing == 1.0:
        return Run(recording, commands, smooth(recording))
    r, stride = recording, spacing * STRIDE
    wide = smooth_poses(r.t, r.eta, r.valid, r.segment, stride=stride)
    return Run(r, commands, wide, stride)


def _in_windows(run: Run, window: float, *, thinned: int = 1) -> Run:
    """The run with windows so long [s], one of so many."""
    r = run.recording
    wide = smooth_poses(r.t, r.eta, r.valid, r.segment, window=window, stride=thinned * run.stride)
    return replace(run, smooth=wide, window=window)


def _acceleration(runs: Runs) -> float:
    """Mean square of the plane's acceleration; 0 without a window."""
    squares = np.concatenate([np.abs(run.smooth.acceleration) ** 2 for run in runs])
    return float(squares.mean()) if len(squares) else 0.0


def blocks(runs: Runs, length: float = BLOCK) -> Index:
    """Number of the block that each window is in, over all runs."""
    numbers: list[Index] = []
    first = 0
    for run in runs:
        _, inverse = np.unique(run.smooth.t // length, return_inverse=True)
        numbers.append(inverse + first)
        first += int(inverse.max(initial=-1)) + 1
    return np.concatenate(numbers)


def block_count(runs: Runs) -> int:
    """Number of blocks in all runs."""
    return int(blocks(runs).max(initial=-1)) + 1


def enough(runs: Runs) -> bool:
    """Whether the runs are long enough for the gains of all inputs and their covariance."""
    n = len(runs[0].commands.names)
    return block_count(runs) > n + 1 and len(blocks(runs)) > 2 * (n + DRAG_COLUMNS)


def gains(runs: Runs, motion: Array, inputs: Array) -> tuple[Gains, Gains, Gains]:
    """Gains of surge, sway and yaw (forward-left-up). motion, inputs: those of the runs, `without_drag`."""
    block = blocks(runs)
    surge, sway, yaw = (gains_of_axis(motion[:, axis], inputs, block) for axis in range(3))
    return surge, sway, yaw


def unexplained(runs: Runs, motion: Array, inputs: Array) -> Array:
    """Squared acceleration (blocks,) of the plane that neither inputs nor drag explain.

    motion, inputs: those of the runs, `without_drag`.
    """
    plane = motion[:, :2]
    left = (plane - inputs @ solved(inputs, plane)) ** 2  # (delays, m, 2)
    squares = sum(left[best, :, axis] for axis, best in enumerate(left.sum(axis=1).argmin(axis=0)))
    return np.asarray(np.bincount(blocks(runs, UNEXPLAINED_BLOCK), weights=squares), dtype=float)


def without_drag(
    runs: Runs,
    inputs: Array | None = None,
    *,
    heading: float = 1.0,
    mirrored: bool = False,
    lever: bool = False,
) -> tuple[Array, Array]:
    """Accelerations (m, 3) and inputs (delays, m, n), projected off the drag basis, and off that of a wind if any.

    inputs: by default the commands at the usual delays. heading: factor on psi. lever: off those of a point beside
    the origin, too, for which only the plane's have a meaning.
    """
    calm, windy = projected(runs, inputs, heading=heading, mirrored=mirrored, lever=lever)
    left, with_wind = (float(unexplained(runs, *each).sum()) for each in (calm, windy))
    return windy if left > LEAST_WIND_RATIO * with_wind else calm


def projected(
    runs: Runs,
    inputs: Array | None = None,
    *,
    heading: float = 1.0,
    mirrored: bool = False,
    lever: bool = False,
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Accelerations and inputs of `without_drag`, off the drag basis alone, and off that of a wind, too."""
    turned = [body(run.smooth, heading=heading, mirrored=mirrored) for run in runs]
    drag = np.concatenate([d for _, d in turned])
    motion = np.concatenate([a for a, _ in turned])
    if lever:  # a point's acceleration beyond that of the origin: r_dot x arm - r^2 arm
        r = np.concatenate([run.smooth.r for run in runs])
        drag = np.column_stack([motion[:, 2], r**2, drag])
    if inputs is None:
        inputs = np.concatenate([run.inputs for run in runs], axis=1)
    basis = orthonormal(drag)
    calm = less(motion, basis[:, :-WIND]), less(inputs, basis[:, :-WIND])
    return calm, (less(calm[0], basis[:, -WIND:]), less(calm[1], basis[:, -WIND:]))


def orthonormal(drag: Array) -> Array:
    """A basis of drag's columns (..., m, DRAG_COLUMNS); its first columns span what as many of drag's do."""
    size = np.linalg.norm(drag, axis=-2, keepdims=True)
    return np.asarray(np.linalg.qr(drag / np.where(size > 0, size, 1.0))[0])


def less(columns: Array, basis: Array) -> Array:
    """Columns (..., m, k) less what an orthonormal basis (..., m, b) explains of them."""
    return np.asarray(columns - basis @ (basis.swapaxes(-1, -2) @ columns))


def unexplained_share(motion: Array, inputs: Array) -> Array:
    """Share (delays, 3) of the squared accelerations that the inputs do not explain."""
    left = np.sum((motion - inputs @ solved(inputs, motion)) ** 2, axis=1)
    return np.asarray((left + SQUARES_AT_REST) / (np.sum(motion**2, axis=0) + SQUARES_AT_REST))


def body(smooth: Smooth, *, heading: float = 1.0, mirrored: bool = False) -> tuple[Array, Array]:
    """Inertial accelerations (..., m, 3) in body axes, and drag (..., m, DRAG_COLUMNS)."""
    turn = np.exp(-1j * heading * smooth.psi)
    velocity, acceleration = smooth.velocity, smooth.acceleration
    if mirrored:
        velocity, acceleration = velocity.conj(), acceleration.conj()
    velocity, acceleration = velocity * turn, acceleration * turn
    own = np.stack([acceleration.real, acceleration.imag, smooth.r_dot], axis=-1)
    return own, _drag(velocity.real, velocity.imag, smooth.r, turn)


def _drag(u: Array, v: Array, r: Array, turn: NDArray[np.complex128]) -> Array:
    """Drag and a steady wind, the same for every axis: rotation and reflection of the boat keep its span.

    turn: exp(-i psi), from the earth's axes to the boat's.
    """
    own = [f for nu in (u, v, r) for f in (nu, np.abs(nu) * nu)]
    wind = turn.real, turn.imag
    return np.stack([np.ones_like(u), *own, v * r, u * r, u * v, *wind], axis=-1)


def solved(inputs: Array, motion: Array) -> Array:
    """Gains (n,) or (..., n, axes) of inputs (..., m, n) by least squares."""
    return np.asarray(np.linalg.solve(_normal(inputs), inputs.swapaxes(-1, -2) @ motion))


def _normal(inputs: Array) -> Array:
    normal = inputs.swapaxes(-1, -2) @ inputs
    n = normal.shape[-1]
    ridge = GAINS_RIDGE * np.trace(normal, axis1=-2, axis2=-1) / n + SQUARES_AT_REST
    return np.asarray(normal + ridge[..., None, None] * np.eye(n))


def gains_of_axis(motion: Array, inputs: Array, block: Index) -> Gains:
    """Least squares at the best delay; block jackknife covariance for correlated residuals."""
    fits = [(x, solved(x, motion)) for x in inputs]
    x, values = min(fits, key=lambda f: float(np.sum((motion - f[0] @ f[1]) ** 2)))
    residual, n = motion - x @ values, x.shape[1]
    normal, free = _normal(x), max(1, len(residual) - n - DRAG_COLUMNS)
    white = (float(residual @ residual) / free + SQUARES_AT_REST) * np.linalg.inv(normal)
    spread = _jackknife_covariance(x, residual, normal, block)
    inflation = max(1.0, float(np.trace(np.linalg.solve(white, spread))) / n)
    covariance = (1.0 - WHITE_SHRINKAGE) * spread + WHITE_SHRINKAGE * inflation * white
    leak = UNMODELLED_SHARE**2 * float(values @ normal @ values) * np.linalg.inv(normal)
    return Gains(values, values / np.sqrt(np.diag(covariance)), np.linalg.inv(covariance + leak))


def _jackknife_covariance(x: Array, residual: Array, normal: Array, block: Index) -> Array:
    """Block jackknife covariance (n, n) of the gains: one block left out at a time.

    Unlike a sandwich over blocks it is large when only a few blocks excite an input.
    """
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    products = x[:, :, None] * x[:, None, :]
    curvature = np.add.reduceat(products, starts, axis=0)  # (blocks, n, n)
    slope = np.add.reduceat(x * residual[:, None], starts, axis=0)
    changes = np.linalg.solve(normal - curvature, slope[:, :, None])[:, :, 0]
    return np.asarray(changes.T @ changes)
