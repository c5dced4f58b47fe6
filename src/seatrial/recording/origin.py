# SPDX-License-Identifier: MIT
"""Poses of the boat's origin through the water, from those of a measured point over ground."""

from dataclasses import replace

import numpy as np

from seatrial.recording.recording import Recording
from seatrial.util.frames import Array


def poses_of_origin(recording: Recording, lever: Array, current: Array | None = None) -> Recording:
    """The recording with poses of the boat's origin instead of the measured point, a lever arm (2,) [m] away,
    and in axes that drift with a current (2,) [m/s, earth-fixed]."""
    if not (lever.any() or (current is not None and current.any())):
        return recording
    ahead, aside = lever
    eta = recording.eta.copy()
    c, s = np.cos(eta[:, 2]), np.sin(eta[:, 2])
    eta[:, :2] -= np.column_stack([c * ahead - s * aside, s * ahead + c * aside])
    if current is not None:
        eta[:, :2] -= recording.t[:, None] * current
    return replace(recording, eta=eta)
