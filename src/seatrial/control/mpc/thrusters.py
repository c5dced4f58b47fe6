# SPDX-License-Identifier: MIT
"""A boat with its thrusters as inputs, with their limits and dead zones; one of them may be an angle."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from seatrial import _core
from seatrial.boat.actuators import SHORTEST_LAG
from seatrial.boat.model import Model
from seatrial.boat.schema import AllocationEntry
from seatrial.control.allocation import Allocator
from seatrial.control.allocation.steered import steering_of
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array, freeze

SWAY = 1  # axis


@dataclass(frozen=True)
class Thrusters:
    """Limits and dynamics, thruster by thruster (n,).

    Thrust is the chain's curve of the command; of an angle it is the angle [rad].
    """

    lowest: Array
    highest: Array
    idle: Array  # thrust of zero cost
    unit: Array  # of thrust in the cost: 1, or the full angle [rad]
    lag: Array  # [s]
    rate: Array  # [1/s] limit of thrust, [rad/s] of an angle; 0: none
    latency: float  # [s] of the slowest
    sways: bool  # whether the boat has sway thrust of its own, beside surge and yaw
    steered: bool  # one thruster and the angle that turns its thrust
    invert: Callable[[Array], Array]  # commands (n,) whose steady thrusts these are

    def __post_init__(self) -> None:
        freeze(self, "lowest", "highest", "idle", "unit", "lag", "rate")

    @property
    def limited(self) -> list[int]:
        """Numbers of those with a rate limit."""
        return [k for k, rate in enumerate(self.rate.tolist()) if rate > 0.0]

    def decay(self, h: float) -> Array:
        """Decay factor (n,) over h [s] of a level's distance to its thrust, by the lag."""
        short = self.lag <= SHORTEST_LAG
        return np.where(short, 0.0, np.exp(-h / np.where(short, 1.0, self.lag)))

    def left(self, t: float, length: float) -> Array:
        """What is left (n,) of the distance to the thrust at t [s] in a stage of this length.

        One with a rate limit moves evenly over the stage, as it does at the limit.
        """
        evenly = 1.0 - (1.0 - self.decay(length)) * t / length
        return np.where(self.rate > 0.0, evenly, self.decay(t))

    def commands(self, thrust: Array) -> Array:
        """Commands (n,) for thrusts (n,) within the limits."""
        return self.invert(thrust)


def thrusters_of(model: Model) -> Thrusters:
    """Of a model whose inputs are its thrusters; raises AllocationError where a curve can't be inverted.

    A thruster that the allocator's null-space bias keeps on one side of its dead zone is bounded by its idle
    command there; the others have both directions. One thruster and its angle have all that their curves give.
    """
    steering = steering_of(model, _limit(model))
    if steering is not None:
        return _steered(model, steering)
    allocator, constants = Allocator(model, "fewest-crossings"), model.vehicle.constants
    limits, (forward, astern) = allocator.limits, allocator.idle_commands
    full, reverse = allocator.thrust(limits), allocator.thrust(-limits)
    sides = allocator.sides
    return Thrusters(
        lowest=np.where(sides > 0, allocator.thrust(forward), reverse),
        highest=np.where(sides < 0, allocator.thrust(-astern), full),
        idle=np.where(sides == 0, 0.0, allocator.thrust(allocator.idle)),
        unit=np.ones(len(limits)),
        lag=constants.of_each("lag", model.constants),
        rate=constants.of_each("slew_rate", model.constants),
        latency=_latency(model),
        sways=SWAY in allocator.boat.driven,
        steered=False,
        invert=lambda thrust: np.clip(allocator.commands(thrust), -limits, limits),
    )


def _limit(model: Model) -> float:
    """Of every command."""
    limit = model.vehicle.file.allocation.limit
    return 1.0 if limit is None else limit


def _steered(model: Model, steering: _core.Steering) -> Thrusters:
    """One thruster and the angle that turns its thrust."""
    constants, limit = model.vehicle.constants, _limit(model)
    thrust, angle = steering.thrust, steering.angle
    lowest, highest, idle = np.zeros(2), np.zeros(2), np.zeros(2)
    unit, rate = np.ones(2), constants.of_each("slew_rate", model.constants)
    lowest[thrust], highest[thrust] = steering.thrusts
    lowest[angle], highest[angle] = np.arcsin(steering.sines)
    idle[angle], unit[angle], rate[angle] = steering.trim, steering.full_angle, steering.angle_rate

    def invert(wanted: Array) -> Array:
        return np.clip(steering.commands(wanted[thrust], wanted[angle]), -limit, limit)

    return Thrusters(
        lowest=lowest, highest=highest, idle=idle, unit=unit,
        lag=constants.of_each("lag", model.constants), rate=rate, latency=_latency(model),
        sways=False, steered=True, invert=invert,
    )  # fmt: skip


def _latency(model: Model) -> float:
    """[s] of the slowest actuator."""
    return max(0.0, float(model.vehicle.constants.of_each("latency", model.constants).max()))


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
