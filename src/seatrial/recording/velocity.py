# SPDX-License-Identifier: MIT
"""Velocity from poses: differentiation schemes, one function each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.boat.schema import NoiseEntry
from seatrial.recording.delays import at_one_time
from seatrial.recording.recording import Recording
from seatrial.util.arguments import expect
from seatrial.util.frames import Array, Index, Mask, body_velocity, freeze
from seatrial.util.frozen import once

UNEVEN = 1.5  # usual steps; a window with a longer step is not differentiated
NOISIER_WINDOW = 3.0  # times the usual noise; a window of closer poses is not differentiated
# [Hz] of poses that show how a boat moves; with more their noise looks like speed
MOTION_RATE = 10.0
SLOW = 0.55  # [s] between poses, above which the stencil misses motion within its four steps
STENCIL_NOISE = float(np.sqrt(130.0) / 12.0)  # 0.95: std of the stencil over sigma_pose / dt
EVEN_WEIGHTS = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0  # times 1/dt, at even stamps
STENCIL_CORRELATION = np.array([1.0, -16 / 130, -64 / 130, 16 / 130, -1 / 130])  # by shared poses


@dataclass(frozen=True, eq=False)
class Motion:
    """Poses with velocities at the same instants. NaN where not valid.

    t: (n,) [s]
    eta: (n, 3) [m, m, rad]
    nu: (n, 3) body velocity [m/s, m/s, rad/s]
    valid: (n,) those with a velocity
    deviation: (n, 3) standard deviation of nu, from a filter
    """

    t: Array
    eta: Array
    nu: Array
    valid: Mask
    deviation: Array | None = None

    def __post_init__(self) -> None:
        freeze(self, "nu")
        freeze(self, "valid", dtype=np.bool_)
        if self.deviation is not None:
            freeze(self, "deviation")


def motion(recording: Recording) -> Motion:
    """The paper's velocities: five-point stencil in earth axes, then Eq. (1) into body axes."""
    expect(recording, Recording, "recording")
    return _motion(recording)


@once
def _motion(recording: Recording) -> Motion:
    whole = at_one_time(recording)
    eta_dot, valid = five_point_stencil(whole)
    nu = body_velocity(whole.eta[:, 2], eta_dot)
    nu[~valid] = np.nan
    return Motion(whole.t, whole.eta, nu, valid)


def usual_velocities(recordings: Sequence[Recording]) -> Array:
    """Body velocities (m, 3) of some recordings, of poses at `MOTION_RATE` at most."""
    found = []
    for whole in recordings:
        moving, fewer = motion(whole), whole.thinned(MOTION_RATE)
        if fewer is not whole and moving.valid.any():
            slower = motion(fewer)
            moving = slower if slower.valid.any() else moving
        found.append(moving)
    return np.concatenate([m.nu[m.valid] for m in found])


def five_point_stencil(recording: Recording, eta: Array | None = None) -> tuple[Array, Mask]:
    """eta_dot (n, 3) and its validity (n,), of the recording's poses or of others (n, 3) at its stamps.

    The derivative of the quartic through five poses at the middle one. For even stamps its weights
    are the stencil's (1, -8, 0, 8, -1) / 12 dt; uneven stamps are exact. Windows never
    include a masked pose, a gap or a jump.
    """
    n = len(recording.t)
    eta_dot = np.full((n, 3), np.nan)
    valid = np.zeros(n, dtype=bool)
    windows, weights = _stencils(recording)
    poses = recording.eta if eta is None else eta
    eta_dot[windows[:, 2]] = np.einsum("ni,nij->nj", weights, poses[windows])
    valid[windows[:, 2]] = True
    return eta_dot, valid


def _stencils(recording: Recording) -> tuple[Index, Array]:
    """Windows of five poses (m, 5), and the weights (m, 5) of the derivative at the middle one."""
    index = np.flatnonzero(recording.valid)
    if len(index) < 5:
        return np.zeros((0, 5), dtype=np.int64), np.zeros((0, 5))
    windows = np.lib.stride_tricks.sliding_window_view(index, 5)
    t, segment = recording.t[index], recording.segment[index]
    close = np.diff(t) < UNEVEN * recording.usual_step
    usable = close[:-3] & close[1:-2] & close[2:-1] & close[3:] & (segment[4:] == segment[:-4])
    windows = windows[usable]
    weights = stencil_weights(recording.t[windows])
    quiet = np.linalg.norm(weights, axis=1) < NOISIER_WINDOW * STENCIL_NOISE / recording.usual_step
    return windows[quiet], weights[quiet]


def stencil_deviation(
    noise: NoiseEntry, recording: Recording, *, first: int | None = None
) -> Array:
    """Standard deviations (3,) of the stencil's velocities [m/s, m/s, rad/s] for white pose noise.

    Root mean square over the recording, or over its `first` stencils; close stamps make it far larger.
    """
    sigma = np.array([noise.position, noise.position, noise.heading])
    weights = _stencils(recording)[1][:first]
    if not len(weights):
        return STENCIL_NOISE / recording.period * sigma
    return np.asarray(np.sqrt(np.mean(np.sum(weights**2, axis=1))) * sigma)


def stencil_weights(t: Array) -> Array:
    """Weights (n, 5) of the derivative at t[:, 2] of the quartic through five points t (n, 5)."""
    h = t - t[:, 2:3]
    weights = np.zeros_like(h)
    for j in (0, 1, 3, 4):
        others = [m for m in (0, 1, 3, 4) if m != j]
        above = np.prod(-h[:, others], axis=1)
        weights[:, j] = above / (h[:, j] * np.prod(h[:, [j]] - h[:, others], axis=1))
    weights[:, 2] = np.sum(-1.0 / h[:, [0, 1, 3, 4]], axis=1)
    return weights
