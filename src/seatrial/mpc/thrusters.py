# SPDX-License-Identifier: MIT
"""A boat that is driven thruster by thruster, for a controller that knows their limits and dead zones."""

from dataclasses import dataclass, replace

import msgspec
import numpy as np

from seatrial.errors import ControlError
from seatrial.frames import Array, frozen_array
from seatrial.model import Model
from seatrial.schema import AllocationEntry


@dataclass(frozen=True)
class Thrusters:
    """Limits and dynamics, thruster by thruster (n,); thrust in units of the chain after its curve."""

    lowest: Array
    highest: Array
    idle: Array  # what costs nothing
    lag: Array  # [s]
    latency: float  # [s] of the slowest

    def __post_init__(self) -> None:
        for name in ("lowest", "highest", "idle", "lag"):
            object.__setattr__(self, name, frozen_array(getattr(self, name)))

    def decay(self, h: float) -> Array:
        """What is left (n,) after h [s] of a level's distance to its thrust."""
        return np.where(self.lag > 0.0, np.exp(-h / np.maximum(self.lag, 1e-9)), 0.0)


def by_thrusters(model: Model) -> Model:
    """The same boat with its thrusters' commands as inputs, whatever allocation it has."""
    file = model.vehicle.file
    if not file.thrusters:
        raise ControlError(
            f"{model.name}: its vehicle names no thrusters, so their limits are not known; write "
            "thrusters: with position and direction of each into the vehicle file"
        )
    inputs: dict[str, str | msgspec.Struct] = {name: name for name in file.thrusters}
    direct = msgspec.structs.replace(
        file,
        allocation=AllocationEntry("direct", limit=file.allocation.limit),
        commands=msgspec.structs.replace(file.commands, inputs=inputs),
    )
    return replace(model, vehicle=replace(model.vehicle, file=direct))


def thrusters_of(model: Model) -> Thrusters:
    """TEMP."""
    chain = model.known_vehicle.file.chain
    k = dict(zip(model.vehicle.constants.names, model.constants.tolist()))
    n = len(model.vehicle.actuators)
    edge = k.get("edge_forward", 0.0)
    t = Thrusters(np.full(n, 0.02), np.ones(n), np.full(n, 0.05), np.full(n, k.get("lag", 0.0)), k.get("latency", 0.0))
    object.__setattr__(t, "command", lambda g: edge + (1 - edge) * g)
    return t
