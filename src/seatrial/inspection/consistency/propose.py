# SPDX-License-Identifier: MIT
"""Which channel of an unlabelled joypad moves which axis: a start for a vehicle file."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.util.frames import Array

SEEN = 8.0  # t from which on a channel may be given an axis,
ALONE = 0.5  # and the largest t of another channel there, as a share


@dataclass(frozen=True)
class Assignment:
    """The channel that moves an axis."""

    axis: int
    channel: str
    sign: int  # 1: positive values push forward or to the left (forward-left-up)
    t: float
    trusted: bool  # it is clear, and no other channel moves the axis nearly as clearly


def assignments(names: tuple[str, ...], t: Array) -> Iterator[Assignment]:
    """Axis by axis, the clearest first; t (3, channels): how clearly each moves each axis."""
    left = np.abs(t)
    for _ in range(min(t.shape)):
        axis, best = (int(i) for i in np.unravel_index(int(np.argmax(left)), t.shape))
        others = np.delete(np.abs(t[axis]), best)
        clear = abs(t[axis, best]) > SEEN
        alone = float(others.max(initial=0.0)) < ALONE * abs(t[axis, best])
        sign = 1 if t[axis, best] > 0 else -1
        yield Assignment(axis, names[best], sign, float(t[axis, best]), bool(clear and alone))
        left[axis], left[:, best] = -1.0, -1.0
