# SPDX-License-Identifier: MIT
"""Allocation of axis commands to thrusters, as numbers in a gains file."""

from typing import Annotated, Final

import msgspec
import numpy as np

from seatrial import _core
from seatrial.boat.allocation import Scheme
from seatrial.boat.model import Model
from seatrial.boat.schema import NotNegative, Positive, Strict
from seatrial.control.allocation import Allocator, AllocatorScheme
from seatrial.control.allocation.thruster_effectiveness import effectiveness
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array

VEHICLE: Final = "vehicle"  # the boat's own allocation
ALLOCATIONS: Final = (VEHICLE, *(scheme.value for scheme in AllocatorScheme))
SAME_EFFECTIVENESS = 1e-6  # difference of two effectiveness matrices that counts as equal
Rank = Annotated[int, msgspec.Meta(ge=0, le=2)]
Three = tuple[float, float, float]  # surge, sway, yaw


class ThrusterAllocation(Strict, frozen=True):
    """Parameters of the core's allocator, besides the model's curves; in command units."""

    scheme: str
    rank: tuple[Rank, Rank, Rank]  # of surge, sway, yaw at the limits: 0 is served first
    hysteresis: NotNegative  # of wrench
    effectiveness: list[Three]  # by thruster: the wrench of a thrust of 1
    limits: list[Positive]  # of |command|
    idle_forward: list[NotNegative]  # idle commands
    idle_reverse: list[NotNegative]

    def core(self, model: Model) -> _core.Allocator:
        """The core's allocator for a model. Raises ControlError where it is another boat's."""
        self._check(model)
        core = _core.Allocator(
            model.vehicle.chain, model.constants, np.array(self.effectiveness).T.copy(),
            np.array([self.limits, self.idle_forward, self.idle_reverse]),
            AllocatorScheme(self.scheme).code, True, self.hysteresis, np.array(self.rank, dtype=np.int32),
        )  # fmt: skip
        if core.fault:
            raise ControlError(
                f"allocation {self.scheme}: not possible with the thrusters of {model.name}; tune it"
            )
        return core

    def _check(self, model: Model) -> None:
        expect_thrusters(model)
        known = [scheme.value for scheme in AllocatorScheme]
        if self.scheme not in known:
            raise ControlError(
                f"allocation: scheme '{self.scheme}'; expected one of {', '.join(known)}"
            )
        n = len(model.vehicle.actuators)
        for name in ("effectiveness", "limits", "idle_forward", "idle_reverse"):
            if len(getattr(self, name)) != n:
                raise ControlError(
                    f"allocation: {name} has {len(getattr(self, name))} rows; expected one for each of "
                    f"the thrusters {', '.join(model.vehicle.actuators)}: tune it"
                )
        if not np.allclose(
            np.array(self.effectiveness).T, effectiveness(model).T, atol=SAME_EFFECTIVENESS
        ):
            raise ControlError(
                f"the allocation is for other thrusters than those of {model.name}: tune it"
            )


def allocator_for(model: Model, allocation: str) -> Allocator | None:
    """The allocator of a scheme; None: the boat's own. Raises ControlError, AllocationError."""
    if allocation == VEHICLE:
        return None
    if allocation not in ALLOCATIONS:
        raise ControlError(f"allocation '{allocation}': expected one of {', '.join(ALLOCATIONS)}")
    expect_thrusters(model)
    return Allocator(model, allocation)


def expect_thrusters(model: Model) -> None:
    """Raises ControlError where the boat's inputs are not its thrusters."""
    if model.vehicle.scheme is not Scheme.DIRECT:
        raise ControlError(
            f"{model.name}: its inputs are {', '.join(model.vehicle.inputs)}, and it allocates them "
            f"({model.vehicle.scheme.value}) by itself; expected a vehicle file with an input for each "
            f"of {', '.join(model.vehicle.actuators)} and allocation: {{scheme: direct}}, or leave "
            f"allocation at '{VEHICLE}'"
        )


def as_numbers(allocator: Allocator) -> ThrusterAllocation:
    """An allocator as the entry of a gains file."""
    surge, sway, yaw = allocator.rank
    return ThrusterAllocation(
        allocator.core_scheme.value, (surge, sway, yaw), allocator.hysteresis,
        [three(column) for column in allocator.boat.T.T], allocator.limits.tolist(),
        allocator.idle_commands[0].tolist(), allocator.idle_commands[1].tolist(),
    )  # fmt: skip


def wrench_of(allocator: Allocator, commands: Array) -> Array:
    """Wrenches (n, 3) of commands (n, inputs) for thrust proportional to the command."""
    full = allocator.thrust(np.ones(len(allocator.thrusters)))
    return np.ascontiguousarray((commands * full) @ allocator.boat.T.T)


def three(values: Array) -> Three:
    """Surge, sway and yaw of an array (3,)."""
    surge, sway, yaw = (float(x) for x in values)
    return surge, sway, yaw
