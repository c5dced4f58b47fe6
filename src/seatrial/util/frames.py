# SPDX-License-Identifier: MIT
"""Axes and frames. Inside, everything is forward-left-up (REP-103); files state their own axes.

Between forward-left-up and forward-right-down (SNAME, Fossen) the components v, r, y, psi, F_v
and F_r change sign; `docs/conventions.md` derives what follows for coefficients.
"""

from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from seatrial import _core

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]  # [ns]
Index = NDArray[np.int64]  # places in an array, or numbers of segments
NS_PER_S = 1_000_000_000  # [ns/s]
Mask = NDArray[np.bool_]

AXES = ("surge", "sway", "yaw")
SYMBOLS = ("u", "v", "r")
SPEED_UNITS = ("m/s", "m/s", "rad/s")
# of velocity errors as they are shown, and the factor from SI
ERROR_UNITS = (("cm/s", 100.0), ("cm/s", 100.0), ("rad/s", 1.0))
POSE, POSE_UNITS = ("x", "y", "psi"), ("m", "m", "rad")


class Axes(str, Enum):
    """Body axes of a file, seen from the boat."""

    FLU = "forward-left-up"  # REP-103; psi counter-clockwise from above
    FRD = "forward-right-down"  # SNAME, Fossen; psi clockwise from above

    @property
    def lateral_sign(self) -> float:
        """Of y, psi, v, r, F_v and F_r between these axes and forward-left-up, either way."""
        return -1.0 if self is Axes.FRD else 1.0

    @property
    def signs(self) -> Array:
        """Of [x, y, psi], [u, v, r], [F_u, F_v, F_r]: (3,) between these axes and forward-left-up, either way."""
        return np.array([1.0, self.lateral_sign, self.lateral_sign])


def body_velocity(psi: Array, eta_dot: Array) -> Array:
    """nu = R(psi)^T eta_dot, the inverse of Eq. (1). psi (n,) [rad]; eta_dot, nu (n, 3)."""
    return _core.rotate(np.ascontiguousarray(psi), np.ascontiguousarray(eta_dot), True)


def earth_offset(psi: Array, ahead: float, left: float) -> Array:
    """R(psi) (ahead, left): (n, 2) [m] in earth axes, of a point given in body axes. psi (n,) [rad]."""
    point = np.tile([ahead, left, 0.0], (len(psi), 1))
    return np.asarray(_core.rotate(np.ascontiguousarray(psi), point, False)[:, :2])


def frozen_array(values: ArrayLike, dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """A read-only, contiguous copy."""
    array: NDArray[Any] = np.array(values, dtype=dtype, order="C")
    array.setflags(write=False)
    return array


def freeze(data: object, *fields: str, dtype: DTypeLike = np.float64) -> None:
    """Replace array fields of frozen data by read-only copies; for its `__post_init__`."""
    for name in fields:
        object.__setattr__(data, name, frozen_array(getattr(data, name), dtype))
