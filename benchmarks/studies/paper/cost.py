# SPDX-License-Identifier: MIT
"""What always-forward costs: authority and idle power, over how far F_os is above the edge."""

import numpy as np

import seatrial
from benchmarks.harness.markdown import table
from benchmarks.studies.paper.trials import ABOVE, boat
from seatrial import _core
from seatrial.boat.vehicle import Vehicle
from seatrial.util.frames import Array

EDGE = 0.08  # of the dead zone
MARGINS = (0.0, 0.01, 0.02, 0.04, 0.08)  # F_os above it
FAR = 100.0  # joypads' stops: the thrusters' limit
POWER = 1.5  # a propeller at rest takes the 3/2 power of its thrust (momentum theory)


def past(commands: Array) -> Array:
    """Thrusts of commands, 1 at full command: linear past the dead zone."""
    return np.asarray(np.sign(commands) * np.maximum(np.abs(commands) - EDGE, 0.0) / (1.0 - EDGE))


def thrusts(vehicle: Vehicle, stick: Array) -> Array:
    """Of the thrusters for a joypad's command (3,)."""
    commands = _core.allocate(vehicle.chain, np.ascontiguousarray(stick[None, :]))[0][0]
    return past(np.asarray(commands))


def authority(vehicle: Vehicle, stick: float) -> Array:
    """Wrench (3,) of each axis alone at so many times the joypad's stop."""
    wrenches = [vehicle.mix @ thrusts(vehicle, stick * e) for e in np.eye(3)]
    return np.array([w[i] for i, w in enumerate(wrenches)])


def page_table() -> str:
    """Rows over the margin; what MP reaches is 100 %."""
    usual = seatrial.load_vehicle("mallard-mp")
    rows = []
    for margin in MARGINS:
        vehicle = boat("AF", EDGE + margin - ABOVE)
        shares = [100.0 * authority(vehicle, s) / authority(usual, s) for s in (1.0, FAR)]
        idle = thrusts(vehicle, np.zeros(3))
        rows.append([
            f"{EDGE + margin:.2f}", *(", ".join(f"{x:.0f}" for x in s) for s in shares),
            f"{100.0 * idle.mean():.1f}", f"{100.0 * np.mean(idle**POWER):.2f}",
        ])  # fmt: skip
    head = [
        "F_os", "wrench at the joypad's stop, % of MP's (u, v, r)", "at the thrusters' limit",
        "thrust of each at rest, % of full",
        "power at rest, % of full",
    ]  # fmt: skip
    return table(head, rows)
