# SPDX-License-Identifier: MIT
"""Tables and columns that are the poses and the commands."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from seatrial.inspection.proposal.sources import OPTIONS, Ask, Choices, Sources, choose, named
from seatrial.io.bags.contents import COMMAND_WORDS
from seatrial.io.bags.opening import is_bag
from seatrial.io.columns import ColumnView, TableView, look_at_columns
from seatrial.util.errors import RecordingError

TIME_NAMES = ("t", "time", "stamp", "timestamp", "sec", "seconds", "ms", "us", "ns")
POSE_NAMES = {
    "x": ("x", "pos_x", "position_x", "north", "px"),
    "y": ("y", "pos_y", "position_y", "east", "py"),
    "psi": ("psi", "yaw", "heading", "theta", "hdg"),
}
UNITS = {"x": ("m", "cm", "mm"), "y": ("m", "cm", "mm"), "psi": ("rad", "deg")}
TIME_UNITS = ("s", "ms", "us", "ns")
NOT_COMMANDS = ("z", "phi", "theta", "roll", "pitch", "u", "v", "r", "w", "p", "q")
COMMAND_TABLE_WORDS = (*COMMAND_WORDS, "joy", "stick", "input")  # in the names of tables


def of_tables(
    path: Path, name: str, choices: Choices, ask: Ask | None, more: Sequence[Path] = ()
) -> Sources:
    """Pose columns by name, and candidates for commands. Raises RecordingError.

    `more`: further recordings; a column that changes in one of them counts as changing.
    """
    tables = _changing(look_at_columns(path), more)
    poses = _pose_table(path, tables, choices, ask)
    driven = _command_table(path, tables, poses, choices, ask)
    pose, commands = _files(path, poses), _files(path, driven)
    pose["stamp"], commands["stamp"] = _stamp(poses), _stamp(driven)
    for key, names in POSE_NAMES.items():
        column = _named(poses, names)
        if column is None:
            raise RecordingError(
                f"{poses.path}: no column for {key}, named like {', '.join(names)}"
            )
        unit = _unit(column.name, UNITS[key])
        pose[key] = {"column": column.name} | ({"unit": unit} if unit else {})
    marks = [c.name for c in poses.columns if _is_validity(c)]
    if marks:
        pose["valid"] = marks[0]
    taken = {pose[k]["column"] for k in ("stamp", "x", "y", "psi")} if driven is poses else set()
    taken.add(commands["stamp"]["column"])
    able = [
        c
        for c in driven.columns
        if c.name and c.name not in taken and c.changes and not _is_validity(c)
        and not (driven is poses and c.name.lower() in NOT_COMMANDS)
    ]  # fmt: skip
    if not able:
        raise RecordingError(
            f"{driven.path}: no column besides poses and stamps changes, so there are no commands"
        )
    full, sparse = _equally_filled(able)
    channels = named((c.name, {"column": c.name}) for c in full)
    notes = {"axes": _north(pose), "commands": []}
    if sparse:
        notes["commands"] = [f"not used, with empty cells: {', '.join(sparse)}"]
    return Sources(path, name, choices.axes, 0.0, pose, commands, channels, notes)


def _changing(tables: Sequence[TableView], more: Sequence[Path]) -> list[TableView]:
    """Tables of the first recording; a column changes if it does in any recording."""
    lone = len(tables) == 1
    seen = {
        (None if lone else Path(table.path).name, column.name)
        for path in more
        if path.exists() and not is_bag(path)
        for table in look_at_columns(path)
        for column in table.columns
        if column.changes
    }

    def over_all(table: TableView) -> TableView:
        file = None if lone else Path(table.path).name
        columns = (replace(c, changes=c.changes or (file, c.name) in seen) for c in table.columns)
        return replace(table, columns=tuple(columns))

    return [over_all(table) for table in tables]


def _files(path: Path, table: TableView) -> dict[str, Any]:
    return {"file": Path(table.path).name} if path.is_dir() else {}


def _equally_filled(columns: Sequence[ColumnView]) -> tuple[list[ColumnView], list[str]]:
    """The largest group of columns filled in the same rows, and the names of the others."""
    groups: dict[int, list[ColumnView]] = {}
    for column in columns:
        groups.setdefault(column.empty, []).append(column)
    chosen = max(groups.items(), key=lambda g: (len(g[1]), -g[0]))[1]
    return chosen, [c.name for c in columns if c not in chosen]


def _pose_table(
    path: Path, tables: Sequence[TableView], choices: Choices, ask: Ask | None
) -> TableView:
    if choices.pose is not None:
        return _given(path, tables, choices.pose, "poses")
    found = [t for t in tables if all(_named(t, POSE_NAMES[key]) for key in ("x", "psi"))]
    if not found:
        listed = "; ".join(f"{t.path}: {', '.join(c.name for c in t.columns)}" for t in tables)
        raise RecordingError(
            f"{path}: no table has columns named like x, y and psi (or yaw, heading); rename them, or "
            f"write the vehicle file by hand (docs/vehicle.md). There are {listed[:400]}"
        )
    return _chosen(path, found, "poses", ask)


def _command_table(
    path: Path, tables: Sequence[TableView], poses: TableView, choices: Choices, ask: Ask | None
) -> TableView:
    """The table of the commands: by name, else the other table, else the same."""
    if choices.commands is not None:
        return _given(path, tables, choices.commands, "commands")
    others = [t for t in tables if t is not poses]
    likely = [t for t in others if any(w in Path(t.path).name.lower() for w in COMMAND_TABLE_WORDS)]
    return _chosen(path, likely or others or [poses], "commands", ask)


def _given(path: Path, tables: Sequence[TableView], name: str, role: str) -> TableView:
    for table in tables:
        if name in (Path(table.path).name, Path(table.path).stem):
            return table
    listed = ", ".join(Path(t.path).name for t in tables)
    raise RecordingError(f"{path}: no table {name} ({OPTIONS[role]}); there are {listed}")


def _chosen(path: Path, found: Sequence[TableView], role: str, ask: Ask | None) -> TableView:
    names = [Path(t.path).name for t in found]
    return found[names.index(choose(path, role, names, ask))]


def _named(table: TableView, names: Sequence[str]) -> ColumnView | None:
    """The column with the first of these names, whatever its case and unit."""
    for spelled in (str.lower, _without_unit):
        found = {spelled(c.name): c for c in reversed(table.columns) if c.least is not None}
        for name in names:
            if name in found:
                return found[name]
    return None


def _without_unit(name: str) -> str:
    """The name without its unit: x [mm], x (mm), x_mm."""
    return re.sub(r"\s*[\[(_ ](m|cm|mm|rad|deg|s|ms|us|ns)[\])]?$", "", name.strip().lower())


def _unit(name: str, units: Sequence[str]) -> str:
    """The unit in a column's name; empty for the default unit."""
    found = re.search(r"[\[(_ ](\w+)[\])]?$", name.strip().lower())
    return found[1] if found and found[1] in units[1:] else ""


def _is_validity(column: ColumnView) -> bool:
    """Whether a column marks valid poses."""
    return "valid" in column.name.lower() and (column.least, column.most) in ((0, 1), (1, 1))


def _north(pose: dict[str, Any]) -> list[str]:
    """A note on the axes from the names of the columns."""
    if any(_without_unit(pose[key]["column"]) in ("north", "east") for key in ("x", "y")):
        return ["columns named north and east mean forward-right-down (--axes)"]
    return []


def _stamp(table: TableView) -> dict[str, Any]:
    rising = [c for c in table.columns if c.unit]
    column = _named(table, TIME_NAMES) or (rising[0] if rising else None)
    if column is None:
        raise RecordingError(
            f"{table.path}: no column of stamps; it has {', '.join(c.name for c in table.columns)}"
        )
    name = column.name.strip().lower()
    unit = name if name in TIME_UNITS[1:] else _unit(column.name, TIME_UNITS) or column.unit or "s"
    return {"column": column.name} | ({"unit": unit} if unit != "s" else {})
