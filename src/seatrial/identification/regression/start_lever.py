# SPDX-License-Identifier: MIT
"""A lever arm to start from: with it the weak form leaves the least of the accelerations.

What it adds to the acceleration of the measured point is linear in it but for the drag, and large:
so a few steps of Gauss and Newton find it from 0, however long it is.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.identification.regression.start_values import (
    FINEST,
    STEPS,
    changes,
    evened,
    gathered,
    pieces,
    search,
)
from seatrial.identification.regression.weak_rows import choose_widths
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

PROBE = 0.1  # [m] for the derivative
MOST_STEPS = 5
WORTH = 0.99  # of the accelerations left: less is worth a step


def first_lever(
    recordings: Sequence[Recording], vehicle: Vehicle, free: Sequence[int] = ()
) -> Array:
    """The lever arm (2,) [m], forward and left; `free` as in `start_values`.

    Raises IdentificationError where no recording has a stretch without drop-outs.
    """
    whole = [evened(r) for r in pieces(recordings)]
    widths = choose_widths(whole)

    def left(lever: Array) -> Array:
        """Accelerations (m,) in surge and sway that the best coefficients leave."""
        moved = gathered([of_origin(r, lever) for r in whole], vehicle, FINEST, widths=widths)
        found = search(moved, changes(vehicle, free), STEPS)
        error = found.design.a - found.design.B @ found.theta
        return np.asarray(error[:, :2].ravel())

    lever = np.zeros(2)
    here = left(lever)
    for _ in range(MOST_STEPS):
        slopes = np.column_stack([(left(lever + PROBE * e) - here) / PROBE for e in np.eye(2)])
        further = lever - np.linalg.lstsq(slopes, here, rcond=None)[0]
        there = left(further)
        if np.linalg.norm(there) > WORTH * np.linalg.norm(here):
            break
        lever, here = further, there
    return lever


def of_origin(recording: Recording, lever: Array, current: Array | None = None) -> Recording:
    """The poses of the boat's origin, less a lever arm (2,) [m], and in the water, less a current
    (2,) [m/s] in the world."""
    if not (lever.any() or (current is not None and current.any())):
        return recording
    ahead, aside = lever
    eta = recording.eta.copy()
    c, s = np.cos(eta[:, 2]), np.sin(eta[:, 2])
    eta[:, :2] -= np.column_stack([c * ahead - s * aside, s * ahead + c * aside])
    if current is not None:
        eta[:, :2] -= recording.t[:, None] * current
    return replace(recording, eta=eta)
