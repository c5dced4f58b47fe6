# SPDX-License-Identifier: MIT
"""What can be wrong in a vehicle file's signals, and the file with it put right."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import msgspec
import numpy as np

from seatrial.frames import Array
from seatrial.schema import Column, PoseSource, VehicleFile
from seatrial.vehicle import Vehicle, as_column

LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}  # [m]
ANGLES = {"rad": 1.0, "deg": float(np.pi / 180.0)}  # [rad]
SPOKEN = {"m": "metres", "cm": "centimetres", "mm": "millimetres", "rad": "radians", "deg": "degrees"}
POSE = ("x", "y", "psi")


class Wrong(str, Enum):
    """What can be wrong with units, signs and order."""

    LENGTH = "unit of x and y"
    ANGLE = "unit of psi"
    MIRRORED = "sign of a pose coordinate"
    EXCHANGED = "x and y exchanged"
    HANDED = "poses and commands of opposite axes"
    NEGATED = "sign of an input"
    PERMUTED = "order of the inputs"


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong."""

    kind: Wrong
    text: str  # what was seen in the data, and the line to change


@dataclass(frozen=True)
class Repair:
    """Edits of a vehicle file's columns, in the file's own terms and axes."""

    units: tuple[str | None, str | None, str | None] = (None, None, None)  # of x, y, psi; None: as is
    exchanged: bool = False  # x and y change places, before the signs
    pose_signs: tuple[int, int, int] = (1, 1, 1)  # of x, y, psi
    order: tuple[int, ...] = ()  # input i reads what input order[i] has read
    input_signs: tuple[int, ...] = ()

    @property
    def plane(self) -> Array:
        """What the edits do to (x, y) of the file: (2, 2)."""
        turned = np.eye(2)[::-1] if self.exchanged else np.eye(2)
        return np.asarray(np.diag(self.pose_signs[:2]) @ turned)

    @property
    def matrix(self) -> Array:
        """What the edits do to the file's inputs: (n, n), a signed permutation."""
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
    """The permutation's cycles, those of one element, too."""
    left, found = set(range(len(order))), []
    while left:
        cycle = [min(left)]
        while order[cycle[-1]] != cycle[0]:
            cycle.append(order[cycle[-1]])
        left -= set(cycle)
        found.append(cycle)
    return found


def mended(vehicle: Vehicle, repair: Repair) -> Vehicle:
    """The vehicle with its pose and command columns put right."""
    file, names = vehicle.file, vehicle.inputs
    entries = [as_column(file.commands.inputs[names[i]]) for i in repair.order]
    inputs: dict[str, str | Column] = {
        name: _signed(entry, sign)
        for name, entry, sign in zip(names, entries, repair.input_signs, strict=True)
    }
    commands = msgspec.structs.replace(file.commands, inputs=inputs)
    changed: VehicleFile = msgspec.structs.replace(
        file, pose=_mended_pose(file.pose, repair), commands=commands
    )
    return Vehicle(changed, vehicle.source)


def _mended_pose(pose: PoseSource, repair: Repair) -> PoseSource:
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


def findings(vehicle: Vehicle, repair: Repair, seen: Mapping[str, str]) -> tuple[Finding, ...]:
    """One sentence for each thing that the repair puts right.

    seen: for each input what it does ("moves sway to the right (t -41)").
    """
    return (
        *_units(repair),
        *_poses(vehicle, repair),
        *_orders(vehicle, repair, seen),
        *_signs(vehicle, repair, seen),
    )


def _units(repair: Repair) -> list[Finding]:
    said = []
    *plane, angle = repair.units
    for unit in dict.fromkeys(u for u in plane if u):
        names = [name for name, u in zip(POSE[:2], plane, strict=True) if u == unit]
        verb = "are" if len(names) > 1 else "is"
        text = (
            f"{' and '.join(names)} {verb} in {SPOKEN[unit]}, by the speeds that follow; "
            f"set unit: {unit} at {_places(names)}"
        )
        said.append(Finding(Wrong.LENGTH, text))
    if angle:
        text = f"psi is in {SPOKEN[angle]}: so read it fits the way that the boat goes; "
        said.append(Finding(Wrong.ANGLE, f"{text}set unit: {angle} at pose: psi"))
    return said


def _poses(vehicle: Vehicle, repair: Repair) -> list[Finding]:
    turned = [name for name, sign in zip(POSE, repair.pose_signs, strict=True) if sign < 0]
    columns = _pose_columns(vehicle)
    if turned == ["y", "psi"] and not repair.exchanged:
        return [_handed(vehicle, turned)]
    said = []
    if repair.exchanged:
        text = (
            "x and y have changed places: exchanged, the poses fit the heading; exchange their "
            f"entries under pose (x: {columns['y'].column}, y: {columns['x'].column})"
        )
        said.append(Finding(Wrong.EXCHANGED, text))
    for name in turned:
        source = {"x": "y", "y": "x"}.get(name, name) if repair.exchanged else name
        text = (
            f"{name} has the wrong sign: turned round, the way that the boat goes fits its heading; "
            f"set sign: {-columns[source].sign} at pose: {name}"
        )
        said.append(Finding(Wrong.MIRRORED, text))
    return said


def _handed(vehicle: Vehicle, turned: list[str]) -> Finding:
    columns = _pose_columns(vehicle)
    signs = ", ".join(f"sign: {-columns[name].sign} at pose: {name}" for name in turned)
    return Finding(
        Wrong.HANDED,
        "the poses are mirrored against the commands: one of them is forward-right-down, the other "
        f"forward-left-up; if it is the poses that are not {vehicle.axes.value}, set {signs}; "
        "else turn the commands for sway and yaw round",
    )


def _orders(vehicle: Vehicle, repair: Repair, seen: Mapping[str, str]) -> list[Finding]:
    said = []
    names = vehicle.inputs
    for cycle in (c for c in cycles(repair.order) if len(c) > 1):
        labels = [names[i] for i in cycle]
        what = "swapped" if len(cycle) == 2 else "permuted"
        entries = ", ".join(
            f"{names[i]}: {_entry(vehicle, repair.order[i], repair.input_signs[i])}" for i in cycle
        )
        text = (
            f"{_listed(labels)} are {what}: {'; '.join(f'{n} {seen[n]}' for n in labels)}; "
            f"exchange their entries at commands: inputs ({entries})"
        )
        said.append(Finding(Wrong.PERMUTED, text))
    return said


def _signs(vehicle: Vehicle, repair: Repair, seen: Mapping[str, str]) -> list[Finding]:
    turned = [
        name
        for i, name in enumerate(vehicle.inputs)
        if repair.order[i] == i and repair.input_signs[i] < 0
    ]
    entries = vehicle.file.commands.inputs
    signs = {name: -as_column(entries[name]).sign for name in turned}
    if set(turned) == {"F_v", "F_r"} and repair.pose_edits == 0:
        text = (
            f"the commands are mirrored against the poses: F_v {seen['F_v']}, F_r {seen['F_r']}; one "
            "of them is forward-right-down, the other forward-left-up: "
            f"set sign: {signs['F_v']} at commands: inputs: F_v, sign: {signs['F_r']} at commands: "
            "inputs: F_r; or, if it is the poses, turn y and psi round"
        )
        return [Finding(Wrong.HANDED, text)]
    return [
        Finding(
            Wrong.NEGATED,
            f"{name} {seen[name]}, against the vehicle file; "
            f"set sign: {signs[name]} at commands: inputs: {name}",
        )
        for name in turned
    ]


def _entry(vehicle: Vehicle, source: int, sign: int) -> str:
    """The column that an input is to read, with its sign if that is -1."""
    column = as_column(vehicle.file.commands.inputs[vehicle.inputs[source]])
    return column.column + (" with sign: -1" if sign * column.sign < 0 else "")


def _pose_columns(vehicle: Vehicle) -> dict[str, Column]:
    pose = vehicle.file.pose
    return {n: as_column(c) for n, c in zip(POSE, (pose.x, pose.y, pose.psi), strict=True)}


def _places(names: list[str]) -> str:
    return " and ".join(f"pose: {name}" for name in names)


def _listed(names: list[str]) -> str:
    return ", ".join(names[:-1]) + " and " + names[-1]
