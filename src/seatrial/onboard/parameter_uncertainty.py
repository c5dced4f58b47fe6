# SPDX-License-Identifier: MIT
"""Noise of the on-board filter, and the principal parameter errors of the model.

Both are computed in the core (`core/include/seatrial/onboard/parameter_uncertainty.hpp`), which derives them.
"""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import FIT_HORIZON, Model
from seatrial.boat.noise_parameters import (
    COLOUR,
    COLOUR_TURN,
    COLOURED,
    MEMORY,
    NOISE_START,
    SWAY_RATIO,
    correlated_vector,
)
from seatrial.boat.schema import NoiseEntry
from seatrial.util.frames import SYMBOLS, Array


@dataclass(frozen=True)
class OnboardUncertainty:
    """Noise and principal parameter errors for the on-board filter."""

    noise: Array  # (12,) of poses and process, in the filter's order
    errors: Array  # (n + m, k) of coefficients and constants: k principal errors of unit variance


def onboard_uncertainty(model: Model) -> OnboardUncertainty:
    """Noise, and the principal parameter errors (Schmidt-Kalman states of the filter).

    Where structure and noise explain the recordings, parameter errors are constant states, ranked by
    their effect on the boat. Under model mismatch, or for a method without that test (the paper's),
    they are added to the process noise. Neither applies without the envelope of identified speeds.
    A model without process noise gets the estimator's start values.
    """
    speeds = model.envelope.speeds
    known = set(SYMBOLS) <= set(speeds)
    ranges = np.array([speeds[name] if known else (-1.0, 1.0) for name in SYMBOLS])
    covariance = model.covariance if known else np.zeros_like(model.covariance)
    explained = model.estimator.settings.get(FIT_HORIZON) == 0.0
    chain, constants = model.vehicle.chain, model.constants
    own = _noise_vector(model.noise)
    return OnboardUncertainty(
        *_core.onboard_uncertainty(model.boat, chain, constants, ranges, covariance, own, explained)
    )


def _noise_vector(noise: NoiseEntry) -> Array:
    """Noise (12,) as the model file states it."""
    own = NOISE_START.copy()
    own[:2] = noise.position, noise.heading
    own[[*COLOUR, COLOUR_TURN]] = 0.0
    if noise.correlated is not None:
        own[COLOURED] = correlated_vector(noise.correlated)
    if noise.process is not None:
        p = noise.process
        own[2:6] = p.walk_linear, p.walk_yaw, p.disturbance_linear, p.disturbance_yaw
        own[MEMORY], own[SWAY_RATIO] = p.memory, p.sway_ratio
    return own
