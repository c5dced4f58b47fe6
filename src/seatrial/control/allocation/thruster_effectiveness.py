# SPDX-License-Identifier: MIT
"""What each thruster gives: from its place and direction, or as a model was identified."""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.allocation import thruster_matrix
from seatrial.boat.model import Model
from seatrial.boat.vehicle import WRENCH, Vehicle
from seatrial.recording.recording import Recording
from seatrial.util.errors import AllocationError
from seatrial.util.frames import AXES, Array


@dataclass(frozen=True)
class Effectiveness:
    """T of a boat: F = T y with thrusts y, in forward-left-up axes."""

    vehicle: Vehicle
    constants: Array  # (m,) of the actuator chain
    T: Array  # (3, n) rows surge, sway, yaw; of norm 1
    scale: Array  # (3,) what made the rows so; m/s^2, m/s^2, rad/s^2 of an identified one
    identified: bool  # T is of coefficients, not of positions and directions

    @property
    def thrusters(self) -> tuple[str, ...]:
        """Names, in the order of commands."""
        return self.vehicle.actuators

    def asked(self, recording: Recording) -> Array:
        """Wrench (m, 3) that each row of a recording's commands asks for."""
        values = recording.commands.values
        if self._by_wrench:
            return np.ascontiguousarray(
                values[:, [self.vehicle.inputs.index(name) for name in WRENCH]]
            )
        thrust = [
            _core.curve(self.vehicle.chain, self.constants, k, np.ascontiguousarray(values))
            for k in range(len(self.thrusters))
        ]
        return np.ascontiguousarray(np.transpose(thrust) @ self.T.T)

    def sent(self, recording: Recording) -> Array:
        """Thruster commands (m, n) that the boat's own allocation made of a recording's commands."""
        values = np.ascontiguousarray(recording.commands.values)
        return np.asarray(_core.allocate(self.vehicle.chain, values)[0])

    @property
    def _by_wrench(self) -> bool:
        return set(self.vehicle.inputs) == set(WRENCH)


def effectiveness(boat: Model | Vehicle) -> Effectiveness:
    """T of a boat. Raises AllocationError where it can't be told.

    A vehicle's thrusters have a place and a direction; without these, a model's coefficients say
    what each actuator gives, and a vehicle must have one force on each axis.
    """
    vehicle = boat.vehicle if isinstance(boat, Model) else boat
    constants = boat.constants if isinstance(boat, Model) else _stated(vehicle)
    if vehicle.file.thrusters:
        T, scale = thruster_matrix(vehicle.thrusters)
        return Effectiveness(vehicle, constants, T, scale, identified=False)
    identified = isinstance(boat, Model) and bool(vehicle.file.forces)
    rows = _of_model(boat) if isinstance(boat, Model) and identified else _of_forces(vehicle)
    scale = np.linalg.norm(rows, axis=1)
    if (idle := [AXES[j] for j in range(3) if scale[j] == 0.0]) or np.linalg.matrix_rank(rows) < 3:
        raise AllocationError(
            f"{vehicle.source}: these actuators can't push in surge, sway and yaw independently"
            + (f" (nothing in {', '.join(idle)})" if idle else "")
            + "; check forces and structure"
        )
    return Effectiveness(vehicle, constants, rows / scale[:, None], scale, identified=identified)


def _stated(vehicle: Vehicle) -> Array:
    if vehicle.estimated:
        raise AllocationError(
            f"{vehicle.source}: leaves {', '.join(vehicle.estimated)} to be estimated; "
            "give the identified model instead"
        )
    return vehicle.constants.values


def _of_model(model: Model) -> Array:
    """Acceleration (3, n) for each actuator's thrust: sum of coefficient times mix."""
    names = [force.name for force in model.structure.forces]
    rows = np.zeros((3, len(model.vehicle.actuators)))
    for term in model.structure.terms:
        if len(term.factors) != 1 or term.factors[0] not in names or term.acceleration is not None:
            continue
        value = term.number * (model.values[term.coefficient] if term.coefficient else 1.0)
        rows[term.axis] += value * model.vehicle.mix[names.index(term.factors[0])]
    return rows


def _of_forces(vehicle: Vehicle) -> Array:
    """A vehicle's own weights, where each axis has one force."""
    axes = [force.axis for force in vehicle.forces]
    if not vehicle.file.forces or sorted(axes) != [0, 1, 2]:
        raise AllocationError(
            f"{vehicle.source}: has no thrusters with positions, and not one force on each of surge, "
            "sway and yaw; give thrusters, or a model, whose coefficients weigh the forces"
        )
    return vehicle.mix[[axes.index(axis) for axis in range(3)]]
