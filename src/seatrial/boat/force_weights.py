# SPDX-License-Identifier: MIT
"""Generalised forces as a vehicle file states them: weights of the actuators, and of rudders in the flow."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.boat.actuators import ChainReader
from seatrial.boat.schema import ForceEntry
from seatrial.util.errors import VehicleError
from seatrial.util.frames import Array, Axes


@dataclass(frozen=True)
class ForceWeights:
    """The entries of `forces:`, read into forward-left-up axes."""

    forces: Mapping[str, ForceEntry]
    reader: ChainReader
    axes: Axes  # that the file is in
    source: str  # for errors

    def mix(self, actuator_signs: Array) -> Array:
        """T (forces, actuators): F = T f. `actuator_signs`: as of the vehicle. Raises VehicleError."""
        mix = self._zeros()
        for row, (name, force) in zip(mix, self.forces.items(), strict=True):
            if not force.of and not force.deflection:
                raise VehicleError(
                    f"{self.source}: force '{name}' is of no actuator: give of: {{…}}"
                )
            if not name.startswith("F_"):
                raise VehicleError(f"{self.source}: force '{name}': names begin with F_")
            for actuator, weight in force.of.items():
                k = self.reader.place(actuator, f"force {name}")
                # the reader has already flipped a wrench input
                row[k] = self._sign(force) * weight * actuator_signs[k]
        return mix

    def deflection(self, angles: Sequence[str]) -> Array:
        """D (forces, actuators): F += D sin(angle). `angles`: actuators that are one. Raises VehicleError."""
        found = self._zeros()
        for row, (name, force) in zip(found, self.forces.items(), strict=True):
            for actuator, weight in force.deflection.items():
                if actuator not in angles:
                    raise VehicleError(
                        f"{self.source}: force {name}: deflection names '{actuator}'; angles of the "
                        f"chain's steered entries are {', '.join(angles) or 'none'}"
                    )
                row[self.reader.place(actuator, f"force {name}")] = self._sign(force) * weight
        return found

    def _zeros(self) -> Array:
        return np.zeros((len(self.forces), len(self.reader.actuators)))

    def _sign(self, force: ForceEntry) -> float:
        """-1 where the axes of the file have the opposite sign."""
        return 1.0 if force.axis == "surge" else self.axes.lateral_sign
