# SPDX-License-Identifier: MIT
"""Effectiveness matrix T of the thrusters: from positions and directions, or from an identified model."""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.allocation import thruster_matrix
from seatrial.boat.model import Model
from seatrial.boat.steering import refuse_angles
from seatrial.boat.vehicle import WRENCH, Vehicle
from seatrial.recording.recording import Recording
from seatrial.util.arguments import expect
from seatrial.util.errors import AllocationError
from seatrial.util.frames import AXES, Array


@dataclass(frozen=True)
class Effectiveness:
    """T of a boat: F = T y with thrusts y, in forward-left-up axes."""

    vehicle: Vehicle
    constants: Array  # (m,) of the actuator chain
    T: Array  # (3, n) rows surge, sway, yaw; of norm 1, or 0 where an axis has no thrust
    scale: Array  # (3,) norms of the rows before; [m/s^2, m/s^2, rad/s^2] where identified
    identified: bool  # T is from coefficients, not from positions and directions

    @property
    def driven(self) -> tuple[int, ...]:
        """Axes with thrust: all three, or surge and yaw."""
        return tuple(int(i) for i in np.flatnonzero(self.scale))

    @property
    def thrusters(self) -> tuple[str, ...]:
        """Names, in the order of commands."""
        return self.vehicle.actuators

    def requested_wrench(self, recording: Recording) -> Array:
        """Requested wrench (m, 3) of each row of a recording's commands."""
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

    def sent_commands(self, recording: Recording) -> Array:
        """Thruster commands (m, n) of the boat's own allocation for a recording's commands."""
        values = np.ascontiguousarray(recording.commands.values)
        return np.asarray(_core.allocate(self.vehicle.chain, values)[0])

    @property
    def _by_wrench(self) -> bool:
        return set(self.vehicle.inputs) == set(WRENCH)


def effectiveness(boat: Model | Vehicle) -> Effectiveness:
    """T of a boat. Raises AllocationError where it can't be determined.

    A vehicle's thrusters have a position and a direction. Without these, T follows from a model's
    coefficients, and a vehicle must have one force on each axis. A boat whose thrusters do not actuate sway
    independently is allocated in surge and yaw.
    """
    expect(boat, (Model, Vehicle), "boat")
    vehicle = boat.vehicle if isinstance(boat, Model) else boat
    refuse_angles(vehicle.file.chain, vehicle.source, AllocationError)
    constants = boat.constants if isinstance(boat, Model) else _stated(vehicle)
    if vehicle.file.thrusters:
        T, scale = thruster_matrix(vehicle.thrusters)
        return Effectiveness(vehicle, constants, T, scale, identified=False)
    identified = isinstance(boat, Model) and bool(vehicle.file.forces)
    rows = _of_model(boat) if isinstance(boat, Model) and identified else _of_forces(vehicle)
    if np.linalg.matrix_rank(rows) < 3:
        rows = rows * np.array([[1.0], [0.0], [1.0]])
    scale = np.linalg.norm(rows, axis=1)
    if np.linalg.matrix_rank(rows) < 2:
        idle = [AXES[j] for j in (0, 2) if scale[j] == 0.0]
        raise AllocationError(
            f"{vehicle.source}: these actuators can't actuate surge and yaw independently"
            + (f" (no force in {', '.join(idle)})" if idle else "")
            + "; check forces and structure"
        )
    unit = np.divide(rows, scale[:, None], out=np.zeros_like(rows), where=scale[:, None] > 0.0)
    return Effectiveness(vehicle, constants, unit, scale, identified=identified)


def _stated(vehicle: Vehicle) -> Array:
    if vehicle.estimated:
        raise AllocationError(
            f"{vehicle.source}: leaves {', '.join(vehicle.estimated)} to be estimated; "
            "give the identified model"
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
    """A vehicle's own weights, where each axis, or surge and yaw, has one force."""
    axes = [force.axis for force in vehicle.forces]
    if not vehicle.file.forces or sorted(axes) not in ([0, 1, 2], [0, 2]):
        raise AllocationError(
            f"{vehicle.source}: has neither thrusters with positions nor one force on each of surge, "
            "sway and yaw, or surge and yaw; give thrusters, or a model, whose coefficients weight the forces"
        )
    rows = np.zeros((3, len(vehicle.actuators)))
    rows[axes] = vehicle.mix
    return rows
