# SPDX-License-Identifier: MIT
"""What the on-board filter believes: the model's own noise, and its parameters' errors.

Both are computed in the core (`core/include/seatrial/onboard/parameter_uncertainty.hpp`), which derives them.
"""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import (
    COLOUR,
    COLOUR_TURN,
    MEMORY,
    NOISE_START,
    correlated_vector,
)
from seatrial.boat.schema import NoiseEntry
from seatrial.util.frames import SYMBOLS, Array


@dataclass(frozen=True)
class Believed:
    """What is believed of a model on board."""

    noise: Array  # (11,) of poses and motion, in the order of the filter's noise
    errors: Array  # (n + m, k) of coefficients and constants by each of k causes of variance 1


def believed_on_board(model: Model) -> Believed:
    """Noise, and the errors of the parameters.

    Where structure and noise explain what was recorded the errors are constants: the principal causes of
    them by what they do to the boat. Else, or where no one has asked (the paper's method), they are in the
    noise. Neither where the model does not state how fast it was identified.
    A model without process noise gets what the estimator starts from.
    """
    speeds = model.envelope.speeds
    known = set(SYMBOLS) <= set(speeds)
    ranges = np.array([speeds[name] if known else (-1.0, 1.0) for name in SYMBOLS])
    covariance = model.covariance if known else np.zeros_like(model.covariance)
    explained = model.estimator.settings.get("belief") == 0.0
    chain, constants = model.vehicle.chain, model.constants
    own = _own(model.noise)
    return Believed(
        *_core.onboard_uncertainty(model.boat, chain, constants, ranges, covariance, own, explained)
    )


def _own(noise: NoiseEntry) -> Array:
    """Noise (11,) as the model file states it."""
    own = NOISE_START.copy()
    own[:2] = noise.position, noise.heading
    own[[*COLOUR, COLOUR_TURN]] = 0.0
    if noise.correlated is not None:
        own[COLOUR[0] :] = correlated_vector(noise.correlated)
    if noise.process is not None:
        p = noise.process
        own[2:6] = p.walk_linear, p.walk_yaw, p.disturbance_linear, p.disturbance_yaw
        own[MEMORY] = p.memory
    return own
