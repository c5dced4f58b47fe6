# SPDX-License-Identifier: MIT
"""What is wrong, in words: what was seen in the data, and the line of the vehicle file to change."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from seatrial.boat.schema import Column
from seatrial.boat.vehicle import Vehicle, as_column
from seatrial.inspection.consistency.repair import POSE, Repair, cycles
from seatrial.util.format import joined

SPOKEN = {
    "m": "metres",
    "cm": "centimetres",
    "mm": "millimetres",
    "rad": "radians",
    "deg": "degrees",
}


class Wrong(str, Enum):
    """What can be wrong with units, signs and order."""

    CLOCK = "clock of the commands"
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


def clock_finding(offset: float) -> list[Finding]:
    """Of commands that act so much later than their stamps [s]; nothing for 0."""
    if not offset:
        return []
    side = "after" if offset > 0 else "before"
    text = (
        f"commands act about {abs(offset):.1f} s {side} their stamps, by the poses' clock: were the two "
        "stamped by one clock? Put the stamps right"
    )
    return [Finding(Wrong.CLOCK, text)]


def findings(
    vehicle: Vehicle, repair: Repair, seen: Mapping[str, str], speed: float
) -> tuple[Finding, ...]:
    """One sentence for each thing that the repair puts right.

    seen: for each input what it does ("moves sway to the right (t -41)"). speed [m/s]: fast
    for the boat, as the file is now.
    """
    return (
        *_units(repair, speed),
        *_poses(vehicle, repair),
        *_orders(vehicle, repair, seen),
        *_signs(vehicle, repair, seen),
    )


def _units(repair: Repair, speed: float) -> list[Finding]:
    said = []
    *plane, angle = repair.units
    for unit in dict.fromkeys(u for u in plane if u):
        names = [name for name, u in zip(POSE[:2], plane, strict=True) if u == unit]
        verb = "are" if len(names) > 1 else "is"
        text = (
            f"{' and '.join(names)} {verb} in {SPOKEN[unit]}, or else the boat would do "
            f"{speed:.2g} m/s; "
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
        named = _label(columns["x"]) and _label(columns["y"])
        how = (
            f"exchange their entries under pose (x: {_label(columns['y'])}, y: {_label(columns['x'])})"
            if named
            else "under pose name the fields of the message the other way round (of PoseStamped: "
            "x: {field: pose.position.y}, y: {field: pose.position.x})"
        )
        text = f"x and y have changed places: exchanged, the poses fit the heading; {how}"
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
            f"{joined(labels)} are {what}: {'; '.join(f'{n} {seen[n]}' for n in labels)}; "
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
    return _label(column) + (" with sign: -1" if sign * column.sign < 0 else "")


def _label(column: Column) -> str:
    """The column of a table, the field of a message; both where the file serves both."""
    index = "" if column.index is None else f"[{column.index}]"
    field = column.field and f"{column.topic}{' ' if column.topic else ''}{column.field}{index}"
    return " or ".join(dict.fromkeys(part for part in (column.column, field) if part))


def _pose_columns(vehicle: Vehicle) -> dict[str, Column]:
    pose = vehicle.file.pose
    return {n: as_column(c) for n, c in zip(POSE, (pose.x, pose.y, pose.psi), strict=True)}


def _places(names: list[str]) -> str:
    return " and ".join(f"pose: {name}" for name in names)
