# SPDX-License-Identifier: MIT
"""Weights of thrusters in a force, from their gains: identical thrusters have equal ones."""

import numpy as np

from seatrial.util.frames import Array, Mask

EQUAL_GAINS = 0.05  # of their mean; gains within it are proposed as equal (identical thrusters)
EQUAL_GAINS_ERRORS = 2.0  # standard errors; the same
LONGEST_LEVER = 1.5  # [m] that gains may show, of the measured point of a small boat


def weights(axis: int, clear: Mask, gains: Array, t: Array) -> Array:
    """Weights (n,) whose magnitudes sum to 1, in the force of an axis; 0 where a thruster does not drive it.

    clear: (3, n) whether a thruster drives an axis; gains: (3, n) [m/s^2], [rad/s^2] per full command, with t.
    """
    own = np.where(clear, gains, 0.0)
    errors = np.abs(own / np.where(clear, t, 1.0))
    return _equalised(_without_lever(axis, clear, own, errors), errors[axis])


def _without_lever(axis: int, clear: Mask, gains: Array, errors: Array) -> Array:
    """Gains (n,) in an axis without what the measured point's lever arm adds, where that explains them.

    Thrusters that turn the boat equally are identical. Then surge and sway gains are equal, and a lever arm a adds
    a times the yaw gain: yaw accelerates the measured point.
    """
    mine: Array = gains[axis]
    own = clear[axis]
    turn = np.where(own, gains[2], 0.0)
    if axis == 2 or not clear[2][own].all() or not _alike(turn, errors[2]):
        return mine
    design = np.column_stack([np.sign(mine), turn])[own]
    (size, lever), *_ = np.linalg.lstsq(design, mine[own], rcond=None)
    left = np.abs(mine[own] - design @ [size, lever]).max()
    if abs(lever) > LONGEST_LEVER or left > EQUAL_GAINS * abs(size):
        return mine
    return np.asarray(np.where(own, np.sign(mine) * size, 0.0))


def _alike(gains: Array, errors: Array) -> bool:
    """Whether magnitudes of the gains (n,) that are not 0 do not differ, by `EQUAL_GAINS` or their errors (n,)."""
    sizes, own = np.abs(gains), gains != 0.0
    mean = float(sizes[own].mean())
    near = np.abs(sizes - mean) < np.maximum(EQUAL_GAINS * mean, EQUAL_GAINS_ERRORS * errors)
    return bool(near[own].all())


def _equalised(gains: Array, errors: Array) -> Array:
    """Weights (n,): equal where the gains do not differ significantly, as thrusters are usually identical."""
    mean = float(np.abs(gains[gains != 0.0]).mean())
    even = np.sign(gains) * mean if _alike(gains, errors) else gains
    return np.asarray(even / np.abs(even).sum())
