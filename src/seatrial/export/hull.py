# SPDX-License-Identifier: MIT
"""Mass and size of a boat, for dimensional coefficients."""

from dataclasses import dataclass

import numpy as np

from seatrial.util.errors import ExportError
from seatrial.util.frames import Array


@dataclass(frozen=True)
class Hull:
    """Measured mass and size. Raises ExportError where a number is not positive.

    A model has coefficients per unit mass, X_u = drag / (mass + added mass). Mass and added mass are not
    identifiable separately, so the user gives both.
    """

    mass: float  # [kg] of the boat itself
    inertia: float  # [kg m^2] about the vertical through the origin
    size: tuple[float, float, float]  # [m] length, width, height of a box of the hull's size
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
        """The same with added mass (3,): the denominator of the coefficients."""
        return np.asarray(self.rigid + np.array(self.added))
