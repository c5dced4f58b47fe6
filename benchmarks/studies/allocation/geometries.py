# SPDX-License-Identifier: MIT
"""What `fewest-crossings` makes of thrusters here and there."""

import msgspec
import numpy as np

import seatrial
from benchmarks.harness.markdown import table
from seatrial.boat.schema import AllocationEntry, ChainGroup, DeadZone, ThrusterEntry
from seatrial.boat.vehicle import Vehicle

ZONE = ChainGroup(dead_zone=DeadZone(0.08, 0.08))
BOATS = {  # x, y [m], angle of push [deg]
    "MallARD's corners": [(0.2, 0.2, 135), (0.2, -0.2, -135), (-0.2, 0.2, 45), (-0.2, -0.2, -45)],
    "corners, stern pair at 30°, half as far out": [
        (0.2, 0.2, 135), (0.2, -0.2, -135), (-0.2, 0.1, 30), (-0.2, -0.1, -30),
    ],
    "two astern, two across": [(-0.5, 0.2, 0), (-0.5, -0.2, 0), (0.4, 0, 90), (-0.4, 0, 90)],
    "three around a circle": [(0.2, 0, 90), (-0.1, 0.17, 210), (-0.1, -0.17, 330)],
    "two astern, one bow thruster": [(-0.5, 0.2, 0), (-0.5, -0.2, 0), (0.5, 0, 90)],
    "four along, one across": [
        (0.5, 0.3, 0), (0.5, -0.3, 0), (-0.5, 0.2, 0), (-0.5, -0.2, 0), (0, 0, 90),
    ],
    "six around a circle": [
        (0.3 * np.cos(a), 0.3 * np.sin(a), np.rad2deg(a) + 90 + 30 * (-1) ** i)
        for i, a in enumerate(np.arange(6) * np.pi / 3)
    ],
}  # fmt: skip


def boat(places: list[tuple[float, float, float]]) -> Vehicle:
    """MallARD's file with other thrusters, a dead zone of 0.08 and a limit of 1."""
    file = seatrial.load_vehicle("mallard-mp").file
    thrusters = {f"{i + 1}": ThrusterEntry(*place) for i, place in enumerate(places)}
    allocation = AllocationEntry("moore-penrose", 0.0, 1.0)
    return Vehicle(
        msgspec.structs.replace(file, thrusters=thrusters, allocation=allocation, chain=[ZONE])
    )


def table_of_boats() -> str:
    """Sides, those that switch, idle power and authority."""
    rows = []
    for name, places in BOATS.items():
        allocator = seatrial.Allocator(boat(places), "fewest-crossings")
        sides = " ".join({1.0: "+", -1.0: "−", 0.0: "0"}[s] for s in allocator.sides.tolist())
        free = seatrial.Allocator(boat(places), "moore-penrose")
        share = 100 * allocator.reach(np.eye(3)) / free.reach(np.eye(3))
        rows.append([
            name, sides, allocator.scheme.value, f"{allocator.idle_power:.3f}",
            ", ".join(f"{x:.0f}" for x in share),
        ])  # fmt: skip
    head = ["thrusters", "side of each", "scheme", "idle power", "authority, % of MP's (u, v, r)"]
    return table(head, rows)
