# SPDX-License-Identifier: MIT
"""Forces under held commands."""

from collections.abc import Sequence

import numpy as np

from seatrial import _core
from seatrial.boat.vehicle import Vehicle
from seatrial.util.frames import Array

STEADY_AFTER = 10.0  # [s] a command acts fully
MOST_COMMANDS = 4000  # of those recorded: enough for their distribution


def usual_commands(recorded: Sequence[Array]) -> Array:
    """Commands (n, inputs) that stand for all recorded (m, inputs): every k-th, about `MOST_COMMANDS`."""
    rows = np.concatenate(recorded)
    return np.ascontiguousarray(rows[:: max(1, len(rows) // MOST_COMMANDS)])


def static_forces(vehicle: Vehicle, commands: Array) -> Array:
    """Forces (n, forces) [-] under held commands (n, inputs), by the chain's start values and reference scales."""
    begin = STEADY_AFTER * np.arange(len(commands), dtype=np.float64)
    scales = np.array([[vehicle.file.scales[name].reference for name in vehicle.scales]])
    steady = _core.ThrustTrace(
        vehicle.chain, vehicle.constants.values, begin, np.ascontiguousarray(commands), begin[:1],
        scales.reshape(1, len(vehicle.scales)),
    )  # fmt: skip
    return np.asarray(steady.forces(np.asarray(begin + 0.99 * STEADY_AFTER)))
