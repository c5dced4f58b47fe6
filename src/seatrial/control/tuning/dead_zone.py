# SPDX-License-Identifier: MIT
"""What a controller alone can't help: commands that the thrusters do not answer."""

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.control.allocation import Allocator
from seatrial.control.tracking.thrusters import wrench_of
from seatrial.control.tuning.linear import LinearBoat, chords
from seatrial.util.frames import Array

STEPS = 1000  # of an axis command from 0 to 1
FELT = 1e-4  # of the acceleration by a full axis command


def dead_zone(model: Model, boat: LinearBoat, allocator: Allocator | None = None) -> Array:
    """Largest command (3,) of each axis, alone and in either direction, that does not push: 0 without one.

    allocator: to thruster commands, instead of the boat's own.
    """
    found = np.zeros(3)
    for axis in range(3):
        for sign in (1.0, -1.0):
            at = np.linspace(0.0, sign, STEPS + 1)
            commands = np.outer(at, np.eye(3)[axis])
            idle = np.abs(acceleration(model, boat, commands, allocator)[:, axis]) <= FELT
            still = int(np.argmin(idle)) if not idle.all() else len(at)
            found[axis] = max(found[axis], (still - 1) / STEPS)
    return found


def acceleration(
    model: Model, boat: LinearBoat, commands: Array, allocator: Allocator | None = None
) -> Array:
    """Steady pushes (n, 3) by axis commands (n, 3), in accelerations of full ones, beyond those of none."""
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
    pushed = (thrust / chords(model)) @ boat.actuators.push.T / boat.authority
    return np.asarray(pushed[1:] - pushed[0])
