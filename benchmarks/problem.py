# SPDX-License-Identifier: MIT
"""What all contenders are given: poses, forces, a start. Needs numpy only.

Sought are the 11 coefficients of Eq. (12) and each recording's initial state, so that the sum of
squares of ((pose - simulated pose) / noise) is least, with the initial state's own spread beside.
"""

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

COEFFICIENTS = (
    "X_u", "X_uu", "X_F", "Y_v", "Y_vv", "Y_F", "N_ud", "N_r", "N_rr", "N_uu", "N_F",
)  # the order of every theta here  # fmt: skip
STEPS = 4  # Runge-Kutta steps between two poses: about 1/60 s


@dataclass(frozen=True)
class Problem:
    """R recordings of n poses each; the actuator chain is known, so that forces are given."""

    h: Array  # (R, n - 1, STEPS) [s] Runge-Kutta steps after each pose; commands change between them
    eta: Array  # (R, n, 3) x, y [m], psi [rad] unwrapped
    nu: Array  # (R, n, 3) u, v [m/s], r [rad/s] differentiated: a guess
    force: Array  # (R, n - 1, STEPS, 3, 3) F at begin, middle and end of each step
    noise: Array  # (3,) of the poses [m, m, rad]
    initial: Array  # (R, 6) guess of the first state
    spread: Array  # (6,) its standard deviations
    theta: Array  # (11,) guess of the coefficients

    def save(self, path: Path) -> None:
        """To one file."""
        np.savez(path, **{f.name: getattr(self, f.name) for f in fields(self)})

    @classmethod
    def load(cls, path: Path) -> "Problem":
        """From its file."""
        with np.load(path) as data:
            return cls(**{f.name: data[f.name] for f in fields(cls)})


@dataclass(frozen=True)
class Solution:
    """What a contender found."""

    theta: Array  # (11,)
    iterations: int
    compiling: float = 0.0  # [s] of its time, where it compiles or builds something first
