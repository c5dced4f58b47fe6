# SPDX-License-Identifier: MIT
"""Smoothed velocities: what predictions are compared with, and how well that is known.

The model's fixed-interval smoother, with the noise that is likeliest on the recording itself, never the
model's own: a wrong model needs much process noise to explain the poses, and the smoother then follows the
poses. With wrongly small noise a model would confirm itself.
"""

from typing import Literal

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import COLOUR, COLOURED, OUTLIER, noise_vector
from seatrial.evaluation.filtering import filter_pass, recording_noise, series_for
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion
from seatrial.util.frames import Array

Reference = Literal["smoothed", "stencil"]


def smoothed_motion(model: Model, recording: Recording, noise: Array | None = None) -> Motion:
    """Poses and velocities smoothed over the whole recording, with standard deviations.

    noise: (12,) by default the likeliest of this recording for this model. Raises ModelError where
    the model diverges.
    """
    used = recording_noise(model, [recording], _colour(model)) if noise is None else noise
    series = series_for(model, recording)
    found = filter_pass(model, recording, series, used)
    state, deviation = _core.smoothed(found, series, used, OUTLIER)
    valid = np.asarray(found.weight) > 0.0
    state[~valid], deviation[~valid] = np.nan, np.nan
    return Motion(recording.t, state[:, :3], state[:, 3:6], valid, deviation)


def _colour(model: Model) -> Array | None:
    """Gauss-Markov pose noise (4,) as the model states it: one recording hardly identifies it."""
    own = noise_vector(model.noise)
    if own is None or max(own[COLOUR]) <= _core.NO_COLOUR:
        return None
    return np.asarray(own[COLOURED])
