# SPDX-License-Identifier: MIT
"""The noise that the on-board filter believes: the model's own, and what its errors amount to.

Both are computed in the core (`core/include/seatrial/doubt.hpp`), which derives them.
"""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.filter_noise import COLOUR, MEMORY, NOISE_START
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
    """Noise (10,) of poses and motion, in the order of the filter's noise.

    A model without process noise (the paper's method finds none) gets what the estimator starts
    from. The doubt about the model's parameters is added in squares.
    """
    own, found = _own(model.noise), doubt(model)
    return _core.believed_noise(own, found.disturbance, found.memory, found.walk)


def _own(noise: NoiseEntry) -> Array:
    """Noise (10,) as the model file states it."""
    own = NOISE_START.copy()
    own[:2] = noise.position, noise.heading
    own[COLOUR] = 0.0
    if (c := noise.correlated) is not None:
        own[COLOUR[0] :] = c.position, c.heading, c.memory
    if noise.process is not None:
        p = noise.process
        own[2:6] = p.walk_linear, p.walk_yaw, p.disturbance_linear, p.disturbance_yaw
        own[MEMORY] = p.memory
    return own
