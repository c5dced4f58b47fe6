# SPDX-License-Identifier: MIT
"""Edits of a vehicle file's columns: units, order, signs."""

from dataclasses import dataclass

import msgspec
import numpy as np

from seatrial.boat.schema import Column, PoseSource, VehicleFile
from seatrial.boat.vehicle import Vehicle, as_column
from seatrial.util.frames import Array

LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}  # [m]
ANGLES = {"rad": 1.0, "deg": float(np.pi / 180.0)}  # [rad]
POSE = ("x", "y", "psi")
Unit = str | None  # None: as the file states


@dataclass(frozen=True)
class Repair:
    """Edits of a vehicle file's columns, in the file's own terms and axes."""

    units: tuple[str | None, str | None, str | None] = (
        None,
        None,
        None,
    )  # of x, y, psi; None: as is
    exchanged: bool = False  # x and y change places, before the signs
    pose_signs: tuple[int, int, int] = (1, 1, 1)  # of x, y, psi
    order: tuple[int, ...] = ()  # input i reads the column of input order[i]
    input_signs: tuple[int, ...] = ()

    @property
    def plane(self) -> Array:
        """Matrix (2, 2) of the edits on (x, y) of the file."""
        turned = np.eye(2)[::-1] if self.exchanged else np.eye(2)
        return np.asarray(np.diag(self.pose_signs[:2]) @ turned)

    @property
    def matrix(self) -> Array:
        """Matrix (n, n) of the edits on the file's inputs: a signed permutation."""
        return np.asarray(np.diag(self.input_signs) @ np.eye(len(self.order))[list(self.order)])

    @property
    def pose_edits(self) -> int:
        """Number of edits of the poses' order and signs."""
        return int(self.exchanged) + sum(sign < 0 for sign in self.pose_signs)

    @property
    def edits(self) -> int:
        """Number of edits of orders and signs; a cycle of n inputs is n - 1 exchanges."""
        return self.pose_edits + edits_of(self.order, self.input_signs)


def edits_of(order: tuple[int, ...], signs: tuple[int, ...]) -> int:
    """Exchanges and negations in a signed permutation."""
    return len(order) - len(cycles(order)) + sum(sign < 0 for sign in signs)


def cycles(order: tuple[int, ...]) -> list[list[int]]:
    """Cycles of the permutation, those of one element included."""
    left, found = set(range(len(order))), []
    while left:
        cycle = [min(left)]
        while order[cycle[-1]] != cycle[0]:
            cycle.append(order[cycle[-1]])
        left -= set(cycle)
        found.append(cycle)
    return found


def apply_repair(vehicle: Vehicle, repair: Repair) -> Vehicle:
    """The vehicle with its pose and command columns corrected.

    x and y of a bag's pose message have no entry in the file and can't be exchanged here.
    """
    file, names = vehicle.file, vehicle.inputs
    entries = [as_column(file.commands.inputs[names[i]]) for i in repair.order]
    inputs: dict[str, str | Column] = {
        name: _signed(entry, sign)
        for name, entry, sign in zip(names, entries, repair.input_signs, strict=True)
    }
    commands = msgspec.structs.replace(file.commands, inputs=inputs)
    changed: VehicleFile = msgspec.structs.replace(
        file, pose=_repaired_pose(file.pose, repair), commands=commands
    )
    return Vehicle(changed, vehicle.source)


def _repaired_pose(pose: PoseSource, repair: Repair) -> PoseSource:
    columns = [as_column(entry) for entry in (pose.x, pose.y, pose.psi)]
    columns = [
        column if unit is None else msgspec.structs.replace(column, unit=unit)
        for column, unit in zip(columns, repair.units, strict=True)
    ]
    if repair.exchanged:
        columns[:2] = columns[1::-1]
    x, y, psi = (_signed(c, s) for c, s in zip(columns, repair.pose_signs, strict=True))
    return msgspec.structs.replace(pose, x=x, y=y, psi=psi)


def _signed(column: Column, sign: int) -> Column:
    return column if sign > 0 else msgspec.structs.replace(column, sign=-column.sign)
