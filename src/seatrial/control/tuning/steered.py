# SPDX-License-Identifier: MIT
"""A boat with one thruster and an angle that turns its thrust, or a rudder, as a linear plant.

`core/include/seatrial/control/steering.hpp` inverts thrust and angle at the boat's speed, so that surge and yaw
accelerations are those commanded, behind the thruster's and the angle's latency and lag.
"""

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.control.allocation.steered import full_accelerations
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array

LEAST_YAW = 1e-6  # [1/m] yaw over surge by full commands: below it the angle has no effect


def steered_authority(model: Model, steering: _core.Steering, fastest: float) -> Array:
    """Accelerations (3,) by full commands at the fastest speed ahead [m/s]. Raises ControlError."""
    found = full_accelerations(steering, fastest)
    if found[2] < LEAST_YAW * found[0]:
        raise ControlError(
            f"{model.name}: the angle gives no yaw at {fastest:.2g} m/s; the controller needs a yaw force of "
            "the angle: forces, and a term such as N_F * F_r in the structure"
        )
    return found


def steered_push(model: Model, steering: _core.Steering, fastest: float) -> Array:
    """Accelerations (3, 2) by full thrust and by full angle at full thrust, at a speed ahead [m/s]."""
    surge, yaw, side = steering.authority(fastest)
    thrust = steering.thrusts[1]
    _, _, across, flow, sway_across, sway_flow = steering.effect(np.array([fastest, 0.0, 0.0]))
    # sway that the angle gives beside its yaw
    sway = (sway_across * thrust + sway_flow) / (across * thrust + flow) * side * yaw
    found = np.zeros((3, 2))
    found[0, steering.thrust] = surge
    found[1:, steering.angle] = sway, side * yaw
    return found


def steered_mix(steering: _core.Steering, fastest: float) -> Array:
    """Commands (2, 3) at axis commands of 1."""
    found = np.zeros((2, 3))
    found[steering.thrust, 0] = 1.0
    found[steering.angle, 2] = steering.authority(fastest)[2]
    return found


def gear_lag(steering: _core.Steering) -> float:
    """[s] of a rate limit: the time for half of the full angle, counted as a lag."""
    return 0.5 * steering.full_angle / steering.angle_rate if steering.angle_rate > 0.0 else 0.0


def steered_shares(steering: _core.Steering, nu: Array, rates: Array) -> Array:
    """Shares (n, 2) of full thrust and of the full angle's sine for accelerations (n, 3) at motions nu (n, 3)."""
    astern, ahead = steering.thrusts
    least = min(steering.sines[1], -steering.sines[0])
    along, turn, across, flow = np.array([steering.effect(row)[:4] for row in nu]).T
    thrust = rates[:, 0] / along
    moment, per = rates[:, 2] - turn * thrust, across * thrust + flow
    sine = np.divide(moment, per, out=np.zeros_like(per), where=np.abs(moment) > 0.0)
    used = np.abs(thrust) / np.where(thrust < 0.0, -astern, ahead)
    return np.column_stack([used, np.abs(sine) / least])
