# SPDX-License-Identifier: MIT
"""The operator's sticks as inputs of a boat: by name, or mixed as a radio control does."""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.steering import angle_names
from seatrial.boat.vehicle import WRENCH
from seatrial.util.errors import VehicleError
from seatrial.util.frames import Array

SENSED = 2.0  # [s] of full throttle and full angle, after which the sense of the turn is seen


@dataclass(frozen=True)
class Joypad:
    """Sticks (surge, sway, yaw) of -1..1 to the inputs of a boat.

    weights: (inputs, 3) of the sticks
    sway: whether the sway stick moves the boat
    """

    weights: Array
    sway: bool

    def inputs(self, sticks: Array) -> Array:
        """Commands (inputs,) of sticks (3,), reduced together to -1..1."""
        found = self.weights @ sticks
        return np.asarray(found / max(1.0, float(np.abs(found).max())))


def response(model: Model) -> Array:
    """Accelerations (forces, 3) [m/s^2, rad/s^2] of the boat at rest under full thrust: Eq. (12)."""
    n = len(model.structure.forces)
    full = np.vstack([np.eye(n), np.zeros((1, n))])
    found = _core.accelerations(
        model.structure.compiled, model.coefficients, np.zeros((n + 1, 3)), full
    )
    return np.asarray(found[:-1] - found[-1])


def joypad_of(model: Model) -> Joypad:
    """Sticks that are the inputs F_u, F_v, F_r by name; else the least commands for an acceleration in each axis.

    An angle turns with the yaw stick. Raises VehicleError where the inputs do not move the boat in surge and yaw.
    """
    vehicle = model.vehicle
    if set(vehicle.inputs) == set(WRENCH):
        by_name = [[float(name == own) for own in WRENCH] for name in vehicle.inputs]
        return Joypad(np.array(by_name), sway=True)
    angles = [vehicle.inputs.index(name) for name in angle_names(vehicle.file.chain)]
    # what each thrust accelerates at rest, each axis beside its largest
    reach = response(model).T @ vehicle.mix
    reach[:, angles] = 0.0
    largest = np.abs(reach).max(axis=1, keepdims=True)
    reach = np.divide(reach, largest, out=np.zeros_like(reach), where=largest > 0.0)
    sway = not angles and bool(np.linalg.matrix_rank(reach) == 3)
    moved = [axis for axis, moves in enumerate((True, sway, not angles)) if moves]
    independent = np.linalg.matrix_rank(reach[moved]) == len(moved)
    reach[[axis for axis in range(3) if axis not in moved]] = 0.0
    # the least commands for each axis alone, the largest of them full
    weights = np.linalg.pinv(reach)
    most = np.abs(weights).max(axis=0)
    weights = np.divide(weights, most, out=np.zeros_like(weights), where=most > 0.0)
    for angle in angles:
        weights[angle, 2] = _sense(model, weights[:, 0], angle)
    if not (independent and weights[:, 2].any()):
        raise VehicleError(
            f"{vehicle.source}: the inputs {', '.join(vehicle.inputs)} do not move the boat in surge and yaw by "
            "themselves, so the simulated operator can't drive it; check forces and structure"
        )
    return Joypad(weights, sway)


def default_plan(model: Model | None) -> str:
    """The bundled plan for a boat: paper-like, or lake where it has no thrust in sway."""
    return "paper-like" if model is None or joypad_of(model).sway else "lake"


def _sense(model: Model, ahead: Array, angle: int) -> float:
    """1 where the boat ahead turns to port by an angle's positive command; -1 to starboard, 0 not at all."""
    turned = []
    for size in (0.0, 1.0):
        plant = _core.Plant(model.boat, model.vehicle.chain, model.constants)
        plant.state = np.zeros(6)
        plant.command(0.0, np.where(np.arange(len(ahead)) == angle, size, ahead))
        plant.advance_to(SENSED)
        turned.append(float(plant.state[5]))
    return float(np.sign(turned[1] - turned[0]))
