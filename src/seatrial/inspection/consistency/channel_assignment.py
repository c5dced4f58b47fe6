# SPDX-License-Identifier: MIT
"""Assignment of unlabelled channels to axes by the t of their gains: a start for a vehicle file."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.util.frames import Array

ASSIGN_T = 8.0  # least t of a clear assignment
RUNNER_UP_SHARE = 0.5  # of that t; another channel above it makes the assignment ambiguous


@dataclass(frozen=True)
class Assignment:
    """The channel that moves an axis."""

    axis: int
    channel: str
    sign: int  # 1: positive values drive forward or to the left (forward-left-up)
    t: float
    trusted: bool  # t above `ASSIGN_T`, and no other channel near it


def assignments(names: tuple[str, ...], t: Array) -> Iterator[Assignment]:
    """Greedy, the largest t first; t (3, channels) of the gains. Each channel and axis once."""
    left = np.abs(t)
    for _ in range(min(t.shape)):
        axis, best = (int(i) for i in np.unravel_index(int(np.argmax(left)), t.shape))
        others = np.delete(np.abs(t[axis]), best)
        clear = abs(t[axis, best]) > ASSIGN_T
        single = float(others.max(initial=0.0)) < RUNNER_UP_SHARE * abs(t[axis, best])
        sign = 1 if t[axis, best] > 0 else -1
        yield Assignment(axis, names[best], sign, float(t[axis, best]), bool(clear and single))
        left[axis], left[:, best] = -1.0, -1.0
