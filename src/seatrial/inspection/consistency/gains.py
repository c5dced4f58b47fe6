# SPDX-License-Identifier: MIT
"""What each input does to each axis, without believing the vehicle file about it.

The inertial acceleration in body axes is regressed on all inputs and on drag of any kind. Its
square does not depend on how the poses are turned or mirrored, so that readings of the poses can
be compared by what they leave unexplained.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial.inspection.consistency.accelerations import (
    STRIDE,
    Smooth,
    smooth_poses,
    smooth_signals,
)
from seatrial.recording.recording import Recording, Signal
from seatrial.util.frames import Array
from seatrial.util.statistics import BLOCK

DELAYS = (-0.15, 0.0, 0.15, 0.3, 0.45, 0.6)  # [s] from a command to its effect that are tried
SHORT_BLOCK = 5.0  # [s] the same for comparing what is left unexplained
SHRINKAGE = 0.3  # of the covariance of gains towards the shape that white residuals would give
LEAK = 0.07  # of an axis' RMS acceleration that inputs may explain without the model's knowing it
DRAG = 10  # columns of `_drag`
FLOOR = 1e-12  # in place of nothing at all: a boat at rest without noise
RIDGE = 1e-6  # keeps inputs that never change from making the equations singular


@dataclass(frozen=True)
class Run:
    """One recording under one reading of its poses."""

    recording: Recording
    commands: Signal  # of the inputs (n)
    smooth: Smooth
    stride: float = STRIDE  # [s] between windows

    @cached_property
    def inputs(self) -> Array:
        """The commands averaged like the accelerations, for each delay: (DELAYS, m, n)."""
        s = self.smooth
        return smooth_signals(self.commands, self.recording.origin, s.t, s.half, DELAYS)


@dataclass(frozen=True)
class Gains:
    """Gains of one axis: what it accelerates by for each input at 1."""

    values: Array  # (n,) [m/s^2] or [rad/s^2] per unit of command
    t: Array  # (n,) values over their standard errors
    precision: Array  # (n, n) inverse covariance, with `LEAK` allowed for

    @property
    def total(self) -> float:
        """Chi-square of all gains against none."""
        return float(self.values @ self.precision @ self.values)


def read_run(recording: Recording, commands: Signal, *, thinned: float = 1.0) -> Run:
    """A recording with its poses as they stand; thinned: windows so many times further apart."""
    r, stride = recording, thinned * STRIDE
    smooth = smooth_poses(r.t, r.eta, r.valid, r.segment, stride=stride)
    return Run(r, commands, smooth, stride)


def blocks(runs: Sequence[Run], length: float = BLOCK) -> NDArray[np.int64]:
    """Number of the block that each window is in, over all runs."""
    numbers: list[NDArray[np.int64]] = []
    first = 0
    for run in runs:
        _, inverse = np.unique(run.smooth.t // length, return_inverse=True)
        numbers.append(inverse + first)
        first += int(inverse.max(initial=-1)) + 1
    return np.concatenate(numbers)


def block_count(runs: Sequence[Run]) -> int:
    """Number of blocks in all runs."""
    return int(blocks(runs).max(initial=-1)) + 1


def enough(runs: Sequence[Run]) -> bool:
    """Whether the gains of all inputs, with errors, can be had of these runs."""
    n = len(runs[0].commands.names) if runs else 0
    return bool(runs) and block_count(runs) > n + 1 and len(blocks(runs)) > 2 * (n + DRAG)


def squared(runs: Sequence[Run]) -> float:
    """Sum of the plane's squared accelerations."""
    return float(sum(np.sum(np.abs(run.smooth.acceleration) ** 2) for run in runs))


def gains(runs: Sequence[Run], *, mirrored: bool = False) -> tuple[Gains, Gains, Gains]:
    """Gains of surge, sway and yaw (forward-left-up); mirrored: with y turned round."""
    motion, inputs = cleared(runs, mirrored=mirrored)
    block = blocks(runs)
    surge, sway, yaw = (_gains(motion[:, axis], inputs, block) for axis in range(3))
    return surge, sway, yaw


def unexplained(runs: Sequence[Run], heading: float = 1.0, *, mirrored: bool = False) -> Array:
    """What no gains and no drag explain of the plane's squared acceleration, block by block.

    heading: factor on psi.
    """
    motion, inputs = cleared(runs, heading=heading, mirrored=mirrored)
    squares = np.zeros(len(motion))
    for axis in range(2):
        left = [motion[:, axis] - x @ _solve(x, motion[:, axis]) for x in inputs]
        squares += min(left, key=lambda e: float(e @ e)) ** 2
    return np.asarray(np.bincount(blocks(runs, SHORT_BLOCK), weights=squares), dtype=np.float64)


def cleared(
    runs: Sequence[Run],
    inputs: Array | None = None,
    *,
    heading: float = 1.0,
    mirrored: bool = False,
) -> tuple[Array, Array]:
    """Accelerations (m, 3) and inputs (delays, m, n) with all that drag explains taken out.

    inputs: by default the commands at the usual delays. heading: factor on psi.
    """
    turned = [_body(run.smooth, heading, mirrored) for run in runs]
    drag = np.concatenate([d for _, d in turned])
    motion = np.concatenate([a for a, _ in turned])
    if inputs is None:
        inputs = np.concatenate([run.inputs for run in runs], axis=1)
    size = np.linalg.norm(drag, axis=0)
    basis = np.linalg.qr(drag / np.where(size > 0, size, 1.0))[0]
    return motion - basis @ (basis.T @ motion), inputs - basis @ (basis.T @ inputs)


def left_over(motion: Array, inputs: Array) -> Array:
    """Share (delays, 3) of the squared accelerations that gains of the inputs do not explain."""
    left = np.array([np.sum((motion - x @ _solve(x, motion)) ** 2, axis=0) for x in inputs])
    return np.asarray((left + FLOOR) / (np.sum(motion**2, axis=0) + FLOOR))


def _body(smooth: Smooth, heading: float, mirrored: bool) -> tuple[Array, Array]:
    """Inertial accelerations (m, 3) in body axes, and drag (m, DRAG)."""
    turn = np.exp(-1j * heading * smooth.psi)
    speed, push = smooth.velocity, smooth.acceleration
    if mirrored:
        speed, push = speed.conj(), push.conj()
    speed, push = speed * turn, push * turn
    acceleration = np.column_stack([push.real, push.imag, smooth.r_dot])
    return acceleration, _drag(speed.real, speed.imag, smooth.r)


def _drag(u: Array, v: Array, r: Array) -> Array:
    """Drag of any kind, the same for every axis: turning or mirroring the boat changes no span."""
    own = [f for nu in (u, v, r) for f in (nu, np.abs(nu) * nu)]
    return np.column_stack([np.ones_like(u), *own, v * r, u * r, u * v])


def _solve(inputs: Array, motion: Array) -> Array:
    return np.asarray(np.linalg.solve(_normal(inputs), inputs.T @ motion))


def _normal(inputs: Array) -> Array:
    normal = inputs.T @ inputs
    ridge = RIDGE * float(np.trace(normal)) / len(normal) + FLOOR
    return np.asarray(normal + ridge * np.eye(len(normal)))


def _gains(motion: Array, inputs: Array, block: NDArray[np.int64]) -> Gains:
    """Least squares at the best delay, with errors that hold for correlated residuals."""
    fits = [(x, _solve(x, motion)) for x in inputs]
    x, values = min(fits, key=lambda f: float(np.sum((motion - f[0] @ f[1]) ** 2)))
    residual, n = motion - x @ values, x.shape[1]
    normal, free = _normal(x), max(1, len(residual) - n - DRAG)
    white = (float(residual @ residual) / free + FLOOR) * np.linalg.inv(normal)
    spread = _jackknifed(x, residual, normal, block)
    inflation = max(1.0, float(np.trace(np.linalg.solve(white, spread))) / n)
    covariance = (1.0 - SHRINKAGE) * spread + SHRINKAGE * inflation * white
    leak = LEAK**2 * float(values @ normal @ values) * np.linalg.inv(normal)
    return Gains(
        values,
        values / np.sqrt(np.diag(covariance)),
        np.linalg.inv(covariance + leak),
    )


def _jackknifed(x: Array, residual: Array, normal: Array, block: NDArray[np.int64]) -> Array:
    """Covariance (n, n) of the gains from leaving out one block at a time.

    Unlike sums over blocks it notices when all that is known of an input comes from a few of them.
    """
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    products = x[:, :, None] * x[:, None, :]
    curvature = np.add.reduceat(products, starts, axis=0)  # (blocks, n, n)
    slope = np.add.reduceat(x * residual[:, None], starts, axis=0)
    changes = np.linalg.solve(normal - curvature, slope[:, :, None])[:, :, 0]
    return np.asarray(changes.T @ changes)
