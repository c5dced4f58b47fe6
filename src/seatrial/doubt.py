# SPDX-License-Identifier: MIT
"""The noise that the on-board filter believes: the model's own, and what its errors amount to.

Both are computed in the core (`core/include/seatrial/doubt.hpp`), which derives them.
"""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.filter_noise import MEMORY, NOISE_START
from seatrial.frames import SYMBOLS, Array
from seatrial.model import Model
from seatrial.schema import NoiseEntry


@dataclass(frozen=True)
class Doubt:
    """What a model's covariance amounts to, averaged over a random drive within its envelope."""

    disturbance: Array  # (3,) [m/s^2, m/s^2, rad/s^2] standard deviations
    memory: Array  # (3,) [s] of the disturbance
    walk: Array  # (3,) [m/s, m/s, rad/s per sqrt(s)] of the velocity


def doubt(model: Model) -> Doubt:
    """The doubt about a model; none where it does not state how fast it was identified."""
    speeds = model.envelope.speeds
    if not set(SYMBOLS) <= set(speeds):
        return Doubt(*np.zeros((3, 3)))
    ranges = np.array([speeds[name] for name in SYMBOLS])
    chain, constants = model.vehicle.chain, model.constants
    return Doubt(*_core.doubt(model.boat, chain, constants, ranges, model.covariance))


def believed_on_board(model: Model) -> Array:
    """Noise (7,) of poses and motion: position, heading, walks, disturbances, memory.

    A model without process noise (the paper's method finds none) gets what the estimator starts
    from. Pose errors that hang together count as white ones of their size: the gate is right, what
    many poses tell is taken for more than it is. The doubt about the model's parameters is added
    in squares.
    """
    own, found = _own(model.noise), doubt(model)
    return _core.believed_noise(own, found.disturbance, found.memory, found.walk)


def _own(noise: NoiseEntry) -> Array:
    """Noise (7,) as the model file states it."""
    own = NOISE_START[: MEMORY + 1].copy()
    own[:2] = noise.position, noise.heading
    if noise.correlated is not None:
        own[:2] = np.hypot(own[:2], [noise.correlated.position, noise.correlated.heading])
    if noise.process is not None:
        p = noise.process
        own[2:6] = p.walk_linear, p.walk_yaw, p.disturbance_linear, p.disturbance_yaw
        own[6] = p.memory
    return own
