# SPDX-License-Identifier: MIT
"""The shape of a course on which a boat keeps its place."""

from dataclasses import dataclass

import numpy as np

from seatrial.control import Shape
from seatrial.util.frames import Array


@dataclass(frozen=True)
class Still(Shape):
    """A point."""

    @property
    def length(self) -> float:
        """There is nowhere to go."""
        return 1.0

    def at(self, s: float) -> Array:
        """The origin, looking along x."""
        del s
        return np.zeros((3, 3))
