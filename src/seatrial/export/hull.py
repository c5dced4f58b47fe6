# SPDX-License-Identifier: MIT
"""Mass and size of a boat: what makes a model per unit mass dimensional."""

from dataclasses import dataclass

import numpy as np

from seatrial.util.errors import ExportError
from seatrial.util.frames import Array


@dataclass(frozen=True)
class Hull:
    """What the owner weighs and measures. Raises ExportError where a number is not positive.

    A model holds coefficients per unit mass, and can't tell mass from added mass: X_u is drag over
    (mass + added mass), whatever these are. Both are therefore the owner's to give.
    """

    mass: float  # [kg] of the boat itself
    inertia: float  # [kg m^2] about the vertical through the origin
    size: tuple[float, float, float]  # [m] length, width, height of a box like the hull
    added: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [kg, kg, kg m^2] in surge, sway, yaw

    def __post_init__(self) -> None:
        positive = {"mass": self.mass, "inertia": self.inertia}
        positive |= dict(zip(("length", "width", "height"), self.size, strict=True))
        for name, value in positive.items():
            if not 0 < value < np.inf:
                raise ExportError(f"{name} {value:g}: expected a positive number in SI units")
        if not all(0 <= value < np.inf for value in self.added):
            shown = ", ".join(f"{value:g}" for value in self.added)
            raise ExportError(
                f"added mass {shown}: expected numbers >= 0 in kg, kg and kg m^2, for surge, sway, yaw"
            )

    @property
    def rigid(self) -> Array:
        """Mass, mass and inertia (3,)."""
        return np.array([self.mass, self.mass, self.inertia])

    @property
    def effective(self) -> Array:
        """The same with added mass (3,): what the coefficients are per unit of."""
        return np.asarray(self.rigid + np.array(self.added))
