# SPDX-License-Identifier: MIT
"""Dead zone of the axis commands."""

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.control.allocation import Allocator
from seatrial.control.allocation.steered import steering_of
from seatrial.control.tracking.thrusters import wrench_of
from seatrial.control.tuning.linear import LinearBoat, chords
from seatrial.util.frames import Array

COMMAND_STEPS = 1000  # of an axis command from 0 to 1
LEAST_ACCELERATION = 1e-4  # of the acceleration by a full axis command; below it is none


def dead_zone(model: Model, boat: LinearBoat, allocator: Allocator | None = None) -> Array:
    """Largest command (3,) of a single axis, in either direction, without thrust; 0: no dead zone.

    allocator: used instead of the boat's own allocation.
    """
    found = np.zeros(3)
    if steering_of(model) is not None:
        return found  # its curves are inverted
    for axis in boat.driven:
        for sign in (1.0, -1.0):
            at = np.linspace(0.0, sign, COMMAND_STEPS + 1)
            commands = np.outer(at, np.eye(3)[axis])
            idle = (
                np.abs(acceleration(model, boat, commands, allocator)[:, axis])
                <= LEAST_ACCELERATION
            )
            first = int(np.argmin(idle)) if not idle.all() else len(at)
            found[axis] = max(found[axis], (first - 1) / COMMAND_STEPS)
    return found


def acceleration(
    model: Model, boat: LinearBoat, commands: Array, allocator: Allocator | None = None
) -> Array:
    """Steady accelerations (n, 3) by axis commands (n, 3), over those of full commands, less those of zero."""
    chain, q = model.vehicle.chain, model.constants
    rows = np.vstack([np.zeros((1, 3)), commands]) @ boat.mix.T
    if allocator is None:
        thrusters, _ = _core.allocate(chain, np.ascontiguousarray(rows))
    else:
        allocator.reset()
        thrusters, _, _ = allocator.allot(wrench_of(allocator, rows))
    thrust = np.column_stack(
        [_core.curve(chain, q, k, thrusters) for k in range(thrusters.shape[1])]
    )
    pushed = (thrust / chords(model)) @ boat.actuators.push.T * boat.per_authority
    return np.asarray(pushed[1:] - pushed[0])
