# SPDX-License-Identifier: MIT
"""Start value of the lever arm: the one with which the weak form has the smallest residual.

Its effect on the acceleration of the measured point is large, and linear but for the drag: a few
Gauss-Newton steps find it from 0, whatever its length.
"""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.identification.regression.start_values import (
    START_CHAIN_STEPS,
    START_GRID_STEP,
    at_even_stamps,
    fit_equations,
    movable_constants,
    spread_pieces,
    window_rows,
)
from seatrial.identification.regression.weak_rows import choose_widths
from seatrial.recording.origin import poses_of_origin
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

LEVER_PROBE = 0.1  # [m] finite difference for the derivative
LEVER_STEPS = 5  # Gauss-Newton steps at most
LEVER_CONVERGED = 0.99  # of the residual: a step that leaves more is the last


def lever_from_poses(
    recordings: Sequence[Recording], vehicle: Vehicle, free: Sequence[int] = ()
) -> Array:
    """The lever arm (2,) [m], forward and left; `free` as in `start_values`.

    Raises IdentificationError where no recording is long enough without drop-outs.
    """
    whole = [at_even_stamps(r) for r in spread_pieces(recordings)]
    widths = choose_widths(whole)

    def residual(lever: Array) -> Array:
        """Residual accelerations (m,) in surge and sway with the best coefficients."""
        moved = window_rows(
            [poses_of_origin(r, lever) for r in whole], vehicle, START_GRID_STEP, widths=widths
        )
        found = fit_equations(moved, movable_constants(vehicle, free), START_CHAIN_STEPS)
        error = found.design.a - found.design.B @ found.theta
        return np.asarray(error[:, :2].ravel())

    lever = np.zeros(2)
    here = residual(lever)
    for _ in range(LEVER_STEPS):
        slopes = np.column_stack(
            [(residual(lever + LEVER_PROBE * e) - here) / LEVER_PROBE for e in np.eye(2)]
        )
        further = lever - np.linalg.lstsq(slopes, here, rcond=None)[0]
        there = residual(further)
        if np.linalg.norm(there) > LEVER_CONVERGED * np.linalg.norm(here):
            break
        lever, here = further, there
    return lever
