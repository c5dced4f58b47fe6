# SPDX-License-Identifier: MIT
"""The paper's boat in plain Python, written without the core."""

from collections.abc import Mapping

import numpy as np

from seatrial.util.frames import Array


def rates(c: Mapping[str, float], state: Array, forces: Array) -> list[float]:
    """Of x, y, psi, u, v, r in a state of these, under F_u, F_v, F_r; c: coefficients by name."""
    psi, u, v, r = state[2:6]
    du = v * r + (c["X_u"] + c["X_uu"] * abs(u)) * u + c["X_F"] * forces[0]
    dv = -u * r + (c["Y_v"] + c["Y_vv"] * abs(v)) * v + c["Y_F"] * forces[1]
    dr = (
        c["N_ud"] * du + (c["N_r"] + c["N_rr"] * abs(r)) * r + c["N_uu"] * abs(u) * u + c["N_F"] * forces[2]
    )  # fmt: skip
    cos, sin = np.cos(psi), np.sin(psi)
    return [cos * u - sin * v, sin * u + cos * v, r, du, dv, dr]
