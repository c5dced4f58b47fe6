# SPDX-License-Identifier: MIT
"""A heading whose zero is off by any angle: the axes of a tracker's body were set as the boat happened to lie.

All forces in the plane then lie turned by one angle from where the vehicle file has them.
"""

from dataclasses import replace

import numpy as np

from seatrial.inspection.consistency.gains import Gains
from seatrial.inspection.consistency.hypotheses import (
    LEVER_ALLOWED,
    HypothesisSearch,
    nearest_lever,
)
from seatrial.inspection.consistency.repair import Repair
from seatrial.util.frames import Array

LEAST_ANGLE = 8.0  # [deg] reported; less may be forces that are not along the axes
ANGLE_STEP = 1.0  # [deg] of the grid
LEFT = 0.2  # of chi-square, with a lever arm, at most after the turn


def oblique_angle(search: HypothesisSearch, repair: Repair) -> float:
    """Angle [deg] to add to psi, forward-left-up; 0 where the file fits, or no angle explains the gains."""
    if search.mirrored or search.fits(repair):
        return 0.0
    angles = np.arange(-180.0, 180.0, ANGLE_STEP)
    misfits = with_heading_turned(search, angles).misfits(search.no_edit)
    angle = float(angles[int(np.argmin(misfits))])
    turned = with_heading_turned(search, angle)
    saved = _misfit_of_one_point(search) - _misfit_of_one_point(turned)
    clear = _misfit_of_one_point(turned) < LEFT * _misfit_of_one_point(search)
    return angle if abs(angle) >= LEAST_ANGLE and clear and saved > search.edit_penalty else 0.0


def with_heading_turned(search: HypothesisSearch, angle: float | Array) -> HypothesisSearch:
    """The gains as they are with psi more by an angle [deg], forward-left-up; of h angles, their gains."""
    turn = np.radians(angle)[..., None]
    c, s = np.cos(turn), np.sin(turn)
    surge, sway, yaw = search.gains
    return replace(search, gains=(_sum(surge, c, sway, s), _sum(sway, c, surge, -s), yaw))


def _sum(one: Gains, a: Array, other: Gains, b: Array) -> Gains:
    """Gains of a one + b other, whose errors are independent; a and b: (1,) or (h, 1)."""
    values = a * one.values + b * other.values
    own, others = np.linalg.inv(one.precision), np.linalg.inv(other.precision)
    covariance = a[..., None] ** 2 * own + b[..., None] ** 2 * others
    tiny = np.finfo(float).tiny
    errors = [np.abs(g.values) / np.maximum(np.abs(g.t), tiny) for g in (one, other)]
    error = np.maximum(np.hypot(a * errors[0], b * errors[1]), tiny)
    return Gains(values, values / error, np.linalg.inv(covariance))


def _misfit_of_one_point(search: HypothesisSearch) -> float:
    """Chi-square of the file as it is, with the lever arm that fits best."""
    return search.at_point(*nearest_lever([search], LEVER_ALLOWED)).misfit(search.no_edit)
