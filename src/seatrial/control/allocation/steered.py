# SPDX-License-Identifier: MIT
"""Allocation of one thruster and the angle that turns its thrust, or a rudder: what the two can do.

The core (`core/include/seatrial/control/steering.hpp`) inverts their curves at the boat's speed.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.steering import angle_names
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array

# by the core's fault: what is missing
FAULTS: Final = (
    "",
    "takes one thruster and one angle, each with an input of its own",
    "needs curves of thrust and angle that rise outside their dead zones",
    "needs a thrust ahead that gives surge",
)
SPEED_SHARES = (0.0, 0.5, 1.0)  # of the fastest speed, at which the authority is shown


def steering_of(model: Model, limit: float = 1.0) -> _core.Steering | None:
    """The allocation of thrust and angle; None: the boat has no angle.

    limit: of both commands. Raises ControlError where the boat has other angles than one for one thruster.
    """
    if not (angles := angle_names(model.vehicle.file.chain)):
        return None
    found = _core.Steering(model.boat, model.vehicle.chain, model.constants, limit)
    if found.fault:
        raise ControlError(
            f"{model.name}: {', '.join(angles)} is an angle (chain: steered); a controller "
            f"{FAULTS[found.fault]}. Commands identify, predict, sim and export, and the odometry node, "
            "work with it"
        )
    return found


def full_accelerations(steering: _core.Steering, speed: float) -> Array:
    """Accelerations (3,) by full commands at a speed ahead [m/s]; none in sway."""
    surge, yaw, _ = steering.authority(speed)
    return np.array([surge, 0.0, yaw])


@dataclass(frozen=True)
class SteeredRow:
    """Authority at one speed ahead; yaw to the right and to the left."""

    speed: float  # [m/s]
    surge: tuple[float, float]  # [m/s^2] astern, ahead
    yaw_full: tuple[float, float]  # [rad/s^2] at full thrust
    yaw_held: tuple[float, float]  # [rad/s^2] at the thrust that holds the speed


def _row(model: Model, steering: _core.Steering, speed: float) -> SteeredRow:
    nu = np.array([speed, 0.0, 0.0])
    along, _, across, flow, _, _ = steering.effect(nu)
    astern, ahead = steering.thrusts
    none = np.zeros((1, len(model.structure.forces)))
    drag = _core.accelerations(model.structure.compiled, model.coefficients, nu[None, :], none)
    held = min(-float(drag[0, 0]) / along, ahead)

    def yaw(thrust: float) -> tuple[float, float]:
        right, left = sorted((across * thrust + flow) * sine for sine in steering.sines)
        return right, left

    return SteeredRow(speed, (along * astern, along * ahead), yaw(ahead), yaw(held))


def steered_text(model: Model, steering: _core.Steering, fastest: float) -> str:
    """The table on the terminal."""
    names = model.vehicle.inputs
    thrust, angle = names[steering.thrust], names[steering.angle]
    low, high = (np.degrees(np.arcsin(sine)) for sine in steering.sines)
    rate = f", {np.degrees(steering.angle_rate):.3g} deg/s" if steering.angle_rate else ""
    lines = [
        f"{model.name}: {thrust} and its angle {angle}, {low:.3g} to {high:.3g} deg{rate}",
        "  speed   surge astern, ahead   yaw at full thrust: right, left   at the thrust that holds the speed",
        "  [m/s]   [m/s^2]               [rad/s^2]",
    ]
    for share in SPEED_SHARES:
        row = _row(model, steering, share * fastest)
        pairs = [
            f"{a + 0.0:.3g}, {b + 0.0:.3g}" for a, b in (row.surge, row.yaw_full, row.yaw_held)
        ]
        lines.append(f"  {row.speed:<7.3g} {pairs[0]:<21} {pairs[1]:<33} {pairs[2]}")
    lines.append(
        "Both curves are inverted at the boat's speed. Yaw is served first: where the angle is at its end, "
        "thrust rises. Dead bands are jumped over."
    )
    return "\n".join(lines)
