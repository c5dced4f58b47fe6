# SPDX-License-Identifier: MIT
"""A boat with its thrusters as inputs, with their limits and dead zones."""

from dataclasses import dataclass, replace

import msgspec
import numpy as np

from seatrial.boat.actuators import SHORTEST_LAG
from seatrial.boat.model import Model
from seatrial.boat.schema import AllocationEntry
from seatrial.control.allocation import Allocator
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array, frozen_array

SWAY = 1  # axis


@dataclass(frozen=True)
class Thrusters:
    """Limits and dynamics, thruster by thruster (n,); thrust is the chain's curve of the command."""

    lowest: Array
    highest: Array
    idle: Array  # thrust of zero cost
    lag: Array  # [s]
    latency: float  # [s] of the slowest
    allocator: Allocator  # for its sides and curves

    def __post_init__(self) -> None:
        for name in ("lowest", "highest", "idle", "lag"):
            object.__setattr__(self, name, frozen_array(getattr(self, name)))

    def decay(self, h: float) -> Array:
        """Decay factor (n,) over h [s] of a level's distance to its thrust."""
        short = self.lag <= SHORTEST_LAG
        return np.where(short, 0.0, np.exp(-h / np.where(short, 1.0, self.lag)))

    def commands(self, thrust: Array) -> Array:
        """Commands (n,) for thrusts (n,) within the limits."""
        limits = self.allocator.limits
        return np.clip(self.allocator.commands(thrust), -limits, limits)


def thrusters_of(model: Model) -> Thrusters:
    """Of a model whose inputs are its thrusters; raises AllocationError where a curve can't be inverted.

    A thruster that the allocator's null-space bias keeps on one side of its dead zone is bounded by its idle
    command there; the others have both directions.
    """
    allocator, constants = Allocator(model, "fewest-crossings"), model.vehicle.constants
    limits, (forward, astern) = allocator.limits, allocator.idle_commands
    full, reverse = allocator.thrust(limits), allocator.thrust(-limits)
    sides = allocator.sides
    return Thrusters(
        np.where(sides > 0, allocator.thrust(forward), reverse),
        np.where(sides < 0, allocator.thrust(-astern), full),
        np.where(sides == 0, 0.0, allocator.thrust(allocator.idle)),
        constants.of_each("lag", model.constants),
        max(0.0, float(constants.of_each("latency", model.constants).max())),
        allocator,
    )


def by_thrusters(model: Model) -> Model:
    """The same boat with its thrusters' commands as inputs, instead of its allocation.

    One whose file states forces has these inputs already. Raises ControlError where neither is stated.
    """
    file = model.vehicle.file
    if file.forces:
        return model
    if not file.thrusters:
        raise ControlError(
            f"{model.name}: its vehicle names no thrusters and no forces, so limits of thrusters are unknown; "
            "add thrusters: with position and direction of each, or forces:, to the vehicle file"
        )
    inputs: dict[str, str | msgspec.Struct] = {name: name for name in file.thrusters}
    direct = msgspec.structs.replace(
        file,
        allocation=AllocationEntry("direct", limit=file.allocation.limit),
        commands=msgspec.structs.replace(file.commands, inputs=inputs),
    )
    return replace(model, vehicle=replace(model.vehicle, file=direct))


def sways(thrusters: Thrusters) -> bool:
    """Whether the boat has sway thrust of its own, beside surge and yaw."""
    return SWAY in thrusters.allocator.boat.driven
