# SPDX-License-Identifier: MIT
"""Forces of thrusters whose places the user gave, in place of those that the recording shows."""

from collections.abc import Sequence
from dataclasses import replace
from math import cos, radians, sin
from pathlib import Path

from seatrial.boat.vehicle import WRENCH
from seatrial.inspection.proposal.inputs import Drive
from seatrial.inspection.proposal.sources import Place, one_each
from seatrial.util.errors import VehicleError
from seatrial.util.format import joined
from seatrial.util.frames import AXES

NO_ARM = 1e-6  # [m], [-] of a thruster that does not act on an axis


def driven_by_places(path: Path, drive: Drive, places: Sequence[Place]) -> Drive:
    """The drive without forces, where `thrusters` of the file has them; with forces where an axis has none.

    Raises VehicleError where places and commands do not go together.
    """
    names = [*drive.inputs]
    sticks = set(names) & set(WRENCH)
    if not sticks:
        one_each(tuple(places), names)
    elif len(sticks) < len(WRENCH):
        raise VehicleError(
            f"{path}: --thrusters: the commands are {joined(names)}. Places are used with sticks of surge, sway "
            "and yaw (an allocation), or with one command for each thruster (--commands)"
        )
    else:
        return drive
    forces = forces_of(names, places)
    whole = len(forces) == len(WRENCH)
    return replace(drive, forces={} if whole else forces, undriven=())


def forces_of(names: Sequence[str], places: Sequence[Place]) -> dict[str, dict[str, object]]:
    """Forces on the axes that thrusters act on, as weighted sums: T of the allocation, row by row."""
    arms = {
        name: (cos(radians(a)), sin(radians(a)), x * sin(radians(a)) - y * cos(radians(a)))
        for name, (x, y, a) in zip(names, places, strict=True)
    }
    found: dict[str, dict[str, object]] = {}
    for i, (force, axis) in enumerate(zip(WRENCH, AXES, strict=True)):
        of = {name: round(arm[i], 4) for name, arm in arms.items() if abs(arm[i]) > NO_ARM}
        if of:
            found[force] = {"axis": axis, "of": of}
    return found
