# SPDX-License-Identifier: MIT
"""A virtual boat from commands, and the velocity with which a holonomic carrier follows it.

The core (`core/include/seatrial/simulation/mimic.hpp`) computes it, here and in the ROS nodes.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from pathlib import Path

import msgspec
from numpy.typing import ArrayLike

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.model_file import model_of
from seatrial.boat.schema import NotNegative, Positive, Strict
from seatrial.onboard.predictor import row_of
from seatrial.util.errors import MimicError
from seatrial.util.frames import POSE, Array, freeze


class MimicHealth(enum.Flag):
    """Conditions of a velocity; `advice` states what to do."""

    NO_POSE = 1
    SPEED_LIMITED = 2
    ACCELERATION_LIMITED = 4
    LOST = 8
    COMMAND_SILENCE = 16
    DIVERGED = 32

    @property
    def names(self) -> tuple[str, ...]:
        """The flags that are raised."""
        return tuple(str(flag.name) for flag in MimicHealth if flag in self)

    @property
    def advice(self) -> tuple[str, ...]:
        """One sentence for each flag that is raised."""
        return tuple(words for bit, words in _core.mimic_words() if MimicHealth(bit) in self)


class Carrier(Strict, frozen=True):
    """Limits and tracking gains of the carrier; the defaults are the core's.

    speed: [m/s] most, in any direction
    yaw_rate: [rad/s]
    acceleration: [m/s^2]
    yaw_acceleration: [rad/s^2]
    lag: [s] delay plus time constant, compensated
    gain: [1/s] on the pose error to the virtual boat
    pose_timeout: [s] open-loop after this long without a carrier pose
    lost: [m] from the virtual boat at which it is stopped
    """

    speed: Positive | None = None
    yaw_rate: Positive | None = None
    acceleration: Positive | None = None
    yaw_acceleration: Positive | None = None
    lag: NotNegative | None = None
    gain: NotNegative | None = None
    pose_timeout: Positive | None = None
    lost: Positive | None = None

    @property
    def core(self) -> _core.Carrier:
        """The core's carrier. Raises MimicError."""
        made = _core.Carrier()
        for name, value in msgspec.structs.asdict(self).items():
            if value is not None:
                _set(made, name, value)
        name, got, expected, advice = made.fault()
        if name:
            raise MimicError(f"carrier: {name} is {got:g}; expected {expected}: {advice}")
        return made


@dataclass(frozen=True)
class Motion:
    """Commanded velocity of the carrier, and the state; forward-left-up.

    time: [s]
    velocity: (3,) for the carrier: forward, left [m/s], yaw [rad/s]
    asked: (3,) velocity before the carrier's limits
    pose: (3,) of the virtual boat: x, y [m], psi [rad], in the carrier's odometry frame
    nu: (3,) of the virtual boat: u, v [m/s], r [rad/s]
    mismatch: (3,) boat minus carrier at its last pose, in the carrier's frame [m, m, rad]
    health: whether the carrier follows, and why not
    """

    time: float
    velocity: Array
    asked: Array
    pose: Array
    nu: Array
    mismatch: Array
    health: MimicHealth

    def __post_init__(self) -> None:
        freeze(self, "velocity", "asked", "pose", "nu", "mismatch")


class Mimic:
    """A virtual boat, and the carrier that follows its motion.

    model: a Model or the path of its file. Times are seconds of one clock. The virtual boat starts at rest
    at the carrier's first pose. Its thrusters are off after the vehicle file's `command_timeout`
    without a command. Raises ModelError, MimicError; never on data.
    """

    def __init__(self, model: Model | str | Path, carrier: Carrier | None = None) -> None:
        self.model = model_of(model)
        timeout = self.model.vehicle.file.command_timeout
        self._core = _core.Mimic(
            self.model.boat, self.model.vehicle.chain, self.model.constants,
            (carrier or Carrier()).core, math.inf if timeout is None else timeout,
        )  # fmt: skip

    def command(self, t: float, values: ArrayLike) -> bool:
        """Commands (inputs,) to the boat, stamped t [s]; they act then, or at once where that has passed.

        False, and not used: a number is none or absurdly large, the stamp is before a command that has acted
        or leaps ahead, or too many are under way. Stamps of a clock that was set are used once several agree.
        """
        return self._core.command(t, row_of(values, "command", self.model.vehicle.inputs))

    def pose(self, t: float, eta: ArrayLike) -> bool:
        """The carrier's pose (3,) at t [s] by its own odometry; False where it is not used, as of `command`."""
        return self._core.pose(t, row_of(eta, "pose", POSE))

    def at(self, t: float) -> Motion:
        """The carrier's motion from t [s] on; t increases from call to call.

        Where it falls, or leaps by more than a minute, the clock was set: the virtual boat goes on from where
        it is, after a leap with its thrusters off.
        """
        time, velocity, asked, boat, mismatch, health = self._core.at(t)
        return Motion(
            time, velocity, asked, boat[:3], boat[3:], mismatch, MimicHealth(health)  # type: ignore[arg-type]
        )  # fmt: skip

    @property
    def newest(self) -> float:
        """Newest stamp of all inputs and answers [s]; it falls where the clock was set back."""
        return self._core.newest


def _set(carrier: _core.Carrier, name: str, value: object) -> None:
    try:
        setattr(carrier, name, value)
    except TypeError:
        raise MimicError(f"carrier: {name} is {value!r}; expected a number") from None
