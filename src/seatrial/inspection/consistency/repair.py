# SPDX-License-Identifier: MIT
"""Edits of a vehicle file's columns: units, order, signs."""

from dataclasses import dataclass

import msgspec
import numpy as np

from seatrial.boat.schema import TO_SI, Column, PoseSource, as_column
from seatrial.boat.vehicle import Vehicle
from seatrial.io.poses import ANGLE_UNITS, LENGTH_UNITS
from seatrial.util.frames import Array

LENGTHS = {unit: TO_SI[unit] for unit in LENGTH_UNITS}  # [m]
ANGLES = {unit: TO_SI[unit] for unit in ANGLE_UNITS}  # [rad]
REVERSED = 1.5  # edits: likelier than another zero of the heading and one negation
COMPASS = 1  # quarter turn: psi = 90 deg - heading, where x is east
QUARTER_BACK = np.array([[0.0, 1.0], [-1.0, 0.0]])
Unit = str | None  # None: as the file states


@dataclass(frozen=True)
class Repair:
    """Edits of a vehicle file's columns, in the file's own terms and axes."""

    # of x, y, psi; None: as is
    units: tuple[str | None, str | None, str | None] = (None, None, None)
    exchanged: bool = False  # x and y change places, before the signs
    pose_signs: tuple[int, int, int] = (1, 1, 1)  # of x, y, psi
    turn: int = 0  # quarter turns that are added to psi, after its sign
    angle: float = 0.0  # [deg] added to psi, where its zero is off by no quarter turn
    order: tuple[int, ...] = ()  # input i reads the column of input order[i]
    input_signs: tuple[int, ...] = ()
    late: float = 0.0  # [s] by which positions are older than headings; negative: headings

    @property
    def plane(self) -> Array:
        """Matrix (2, 2) of the edits on (x, y) of the file, seen from the boat: psi turns it back."""
        exchanged = np.eye(2)[::-1] if self.exchanged else np.eye(2)
        back = np.linalg.matrix_power(QUARTER_BACK, self.turn % 4)
        return np.asarray(back @ np.diag(self.pose_signs[:2]) @ exchanged)

    @property
    def matrix(self) -> Array:
        """Matrix (n, n) of the edits on the file's inputs: a signed permutation."""
        return np.asarray(np.diag(self.input_signs) @ np.eye(len(self.order))[list(self.order)])

    @property
    def pose_edits(self) -> int:
        """Number of edits of the poses' order, signs and zero; of a compass, zero and sense are one."""
        edits = int(self.exchanged) + sum(sign < 0 for sign in self.pose_signs)
        compass = self.pose_signs[2] < 0 and self.turn % 4 == COMPASS
        return edits + (self.turn % 4 != 0 and not compass) + (self.angle != 0.0)

    @property
    def edits(self) -> float:
        """Number of edits of orders and signs; a cycle of n inputs is n - 1 exchanges."""
        return self.pose_edits + edits_of(self.order, self.input_signs)


def edits_of(order: tuple[int, ...], signs: tuple[int, ...]) -> float:
    """Exchanges and negations in a signed permutation; all inputs reversed are `REVERSED`."""
    negated = sum(sign < 0 for sign in signs)
    return len(order) - len(cycles(order)) + (REVERSED if negated == len(signs) > 1 else negated)


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
    pose = _repaired_pose(file.pose, repair)
    changed = Vehicle(msgspec.structs.replace(file, pose=pose, commands=commands), vehicle.source)
    return changed.with_delays(*later(vehicle.delays, repair.late))


def later(delays: tuple[float, float], late: float) -> tuple[float, float]:
    """Delays [s] of position and heading, of which the position's is longer by `late`; negative: the heading's."""
    position, heading = delays
    return round(position + max(late, 0.0), 3), round(heading + max(-late, 0.0), 3)


def _repaired_pose(pose: PoseSource, repair: Repair) -> PoseSource:
    columns = [
        column if unit is None else msgspec.structs.replace(column, unit=unit)
        for column, unit in zip(pose.columns.values(), repair.units, strict=True)
    ]
    if repair.exchanged:
        columns[:2] = columns[1::-1]
    x, y = (_signed(c, s) for c, s in zip(columns[:2], repair.pose_signs[:2], strict=True))
    psi = repaired_heading(columns[2], repair)
    return msgspec.structs.replace(pose, x=x, y=y, psi=psi)


def repaired_heading(column: Column, repair: Repair) -> Column:
    """The column of psi with its sign and zero corrected."""
    quarters = (repair.turn + 1) % 4 - 1  # -1 to 2
    return turned(_signed(column, repair.pose_signs[2]), 90.0 * quarters + repair.angle)


def turned(column: Column, angle: float) -> Column:
    """A column of headings to which an angle [deg] is added."""
    if angle == 0.0:
        return column
    own = angle * ANGLES["deg"] / ANGLES[column.unit or "rad"]
    offset = column.offset - column.sign * own * column.scale
    return msgspec.structs.replace(column, offset=float(offset))


def _signed(column: Column, sign: int) -> Column:
    return column if sign > 0 else msgspec.structs.replace(column, sign=-column.sign)
