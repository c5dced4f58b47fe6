# SPDX-License-Identifier: MIT
"""What the on-board filter believes: the model's own noise, and its parameters' errors.

Both are computed in the core (`core/include/seatrial/doubt.hpp`), which derives them.
"""

import numpy as np

from seatrial import _core
from seatrial.filter_noise import COLOUR, MEMORY, NOISE_START
from seatrial.frames import SYMBOLS, Array
from seatrial.model import Model
from seatrial.schema import NoiseEntry


def doubt(model: Model) -> Array:
    """Errors of coefficients and constants (n + m, k) by each of k independent causes of variance 1.

    The few principal ones by what they do to the velocity; their sum of squares is the model's
    covariance but for what hardly matters. None where the model does not state how fast it was
    identified.
    """
    speeds = model.envelope.speeds
    if not set(SYMBOLS) <= set(speeds):
        return np.zeros((len(model.parameters), 0))
    ranges = np.array([speeds[name] for name in SYMBOLS])
    chain, constants = model.vehicle.chain, model.constants
    return np.asarray(_core.doubt(model.boat, chain, constants, ranges, model.covariance))


def believed_on_board(model: Model) -> Array:
    """Noise (10,) of poses and motion, in the order of the filter's noise.

    A model without process noise (the paper's method finds none) gets what the estimator starts
    from.
    """
    return np.asarray(_core.believed_noise(_own(model.noise)))


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
