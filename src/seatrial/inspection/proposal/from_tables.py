# SPDX-License-Identifier: MIT
"""Tables and columns that are the poses and the commands."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from seatrial.inspection.proposal.columns.choice import texts_of
from seatrial.inspection.proposal.columns.clocks import as_long_as
from seatrial.inspection.proposal.columns.names import (
    Grade,
    Kind,
    grade,
    is_measured,
    is_quaternion_part,
    read_name,
)
from seatrial.inspection.proposal.columns.pose import PoseColumns, choose_pose
from seatrial.inspection.proposal.columns.signals import (
    LISTED,
    column_of,
    holding_tables,
    is_validity,
    shown,
)
from seatrial.inspection.proposal.columns.stamps import (
    recognised,
    stamp_columns,
    stamp_of,
)
from seatrial.inspection.proposal.command_sources import by_source, measured_twins, sums_of_sides
from seatrial.inspection.proposal.sources import (
    Ask,
    Choices,
    Entries,
    Recognised,
    Sources,
    Sureness,
    assigned,
    choose,
    named,
)
from seatrial.io.bags.contents import COMMAND_WORDS
from seatrial.io.bags.opening import is_bag
from seatrial.io.columns import ColumnView, Tables, TableSeen, read_tables
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

COMMAND_TABLE_WORDS = (*COMMAND_WORDS, "joy", "stick", "input")  # in the names of tables
NOT_COMMANDS = (("theta",),)  # beside those that are other signals by their names
# last words of columns that are no command
MODES = (("mode",), ("armed",), ("state",), ("status",))
SCALE_WORDS = frozenset(("volt", "voltage", "battery", "rpm", "current"))
SWITCH_VALUES = 2  # of a switch; commands beside it have more than twice as many
MOST_SPARE = 12  # columns in the comment
OWN_TABLE_CHANNELS = 2  # most commands in each of several tables alike, one for each thruster


def of_tables(
    path: Path, name: str, choices: Choices, ask: Ask | None, more: Sequence[Path]
) -> Sources:
    """Columns of the pose and candidates for commands, by name and value. Raises RecordingError.

    `more`: further recordings; a column that changes in one of them counts as changing.
    """
    tables = _changing(read_tables(path), more)
    pose = choose_pose(path, tables, choices, ask)
    driven, chosen = _commands(path, tables, pose, choices, ask)
    table = driven[0]
    stamp = as_long_as(pose.tables[0], pose.stamp, table, stamp_of(table))
    pose = pose.by_clock_of(table, stamp)
    commands: dict[str, Any] = {"file": table.key} if table.key else {}
    commands["stamp"] = stamp.entry
    if chosen:
        channels = {n: _channel(t, c, table) for n, (t, c) in chosen.items()}
        sparse: list[str] = []
        sure, why = Sureness.CHOSEN, "--commands"
    else:
        channels, sparse, sure, why = _channels(path, driven, pose)
    notes = {**pose.notes, "commands": []}
    if sparse:
        notes["commands"] = [f"not used, with empty cells: {', '.join(sparse)}"]
    modes = [c.name for c in table.view.columns if c.changes and _is_mode(c.name)]
    if modes and by_source([*channels]):
        notes["commands"].append(f"{', '.join(modes)}: says which source drives, and when?")
    found = [
        *pose.recognised,
        recognised("stamps of the commands", table, stamp),
        Recognised("commands", _listed(channels, table), why, sure),
    ]
    remarks = dict.fromkeys(r for t in tables for r in t.table.remarks)
    notes["pose"] = [*notes.get("pose", []), *remarks]
    return Sources(
        path, name, choices.axes, 0.0, pose.entries, commands, channels, notes,
        spare=_spare(table, pose, channels), recognised=tuple(found),
    )  # fmt: skip


def _listed(channels: Entries, table: TableSeen) -> str:
    columns = channels.values()
    names = [f"{c['file']}: {c['column']}" if "file" in c else c["column"] for c in columns]
    return shown(table, *names)


def _changing(tables: Tables, more: Sequence[Path]) -> list[TableSeen]:
    """Tables of the first recording; a column changes if it does in any recording."""
    changing = {
        (table.key, column.name)
        for path in more
        if path.exists() and not is_bag(path)
        for table in read_tables(path)
        for column in table.view.columns
        if column.changes
    }

    def over_all(table: TableSeen) -> TableSeen:
        columns = tuple(
            replace(c, changes=c.changes or (table.key, c.name) in changing)
            for c in table.view.columns
        )
        return replace(table, view=replace(table.view, columns=columns))

    return [over_all(table) for table in tables]


def _commands(
    path: Path, tables: Tables, pose: PoseColumns, choices: Choices, ask: Ask | None
) -> tuple[list[TableSeen], dict[str, tuple[TableSeen, str]]]:
    """Tables of the commands, and the columns where the user chose them, by name."""
    given = choices.commands
    if given is None:
        return _command_tables(path, tables, pose, ask), {}
    for table in tables:
        if given in (table.key, Path(table.key).stem) and table.key:
            return [table], {}
    pairs = assigned(given, "--commands") or {c.strip(): c.strip() for c in given.split(",")}
    listed = ", ".join(t.key for t in tables if t.key)
    if len(pairs) == 1 and "=" not in given and not holding_tables(tables, given.strip()):
        where = f"table {given}" if listed else f"column {given}"
        there = listed or ", ".join(c.name for t in tables for c in t.view.columns[:LISTED])
        raise RecordingError(f"{path}: no {where} (--commands); there are {there}")
    columns = [column_of(path, tables, text, "--commands") for text in pairs.values()]
    names = named((name, {}) for name in pairs)
    return [columns[0][0]], dict(zip(names, columns, strict=True))


def _command_tables(
    path: Path, tables: Tables, pose: PoseColumns, ask: Ask | None
) -> list[TableSeen]:
    """The table of the commands: by name, else with columns named so, else the other, else the same."""
    apart = [t for t in tables if all(t is not own for own in pose.tables)]
    others = [t for t in apart if not t.table.only_poses]
    likely = [t for t in others if any(w in t.key.lower() for w in COMMAND_TABLE_WORDS)]
    if not likely:
        holding = [t for t in others if _named_commands(_able(t, pose))]
        likely = holding or others
    alike = {tuple(t.table.names) for t in likely}
    if len(likely) > 1 and len(alike) == 1 and len(_able(likely[0], pose)) <= OWN_TABLE_CHANNELS:
        return likely
    if not likely and pose.tables[0].table.only_poses:
        raise RecordingError(
            f"{path}: has poses alone, and no commands: put it in a folder with the table of the commands "
            "(commands.csv), and give the folder"
        )
    if not likely:
        return [pose.tables[0]]
    keys = [t.key for t in likely]
    return [likely[keys.index(choose(path, "commands", keys, ask))]]


def _able(table: TableSeen, pose: PoseColumns) -> list[ColumnView]:
    """Columns that may be commands: they change, and are no other signal."""
    taken = stamp_columns(table) | pose.names_in(table)
    same = any(table is own for own in pose.tables)
    return [
        c
        for c in table.view.columns
        if c.name and c.name not in taken and c.changes and c.least is not None
        and not is_validity(c) and not _is_mode(c.name)
        and not (same and _is_other_signal(c.name))
    ]  # fmt: skip


def _is_mode(name: str) -> bool:
    """Whether a column says who drives, or whether anybody may: no command."""
    return read_name(name).words[-1:] in MODES


def _is_other_signal(name: str) -> bool:
    """Whether a column beside the poses is measured rather than commanded."""
    if is_quaternion_part(name) is not None or read_name(name).words in NOT_COMMANDS:
        return True
    if is_measured(name) or grade(name, Kind.COMMAND) is not None:
        return is_measured(name)
    motion = (Kind.HEADING, Kind.COURSE, Kind.YAW_RATE, Kind.LATITUDE, Kind.LONGITUDE)
    return any(grade(name, kind) is Grade.WHOLE for kind in motion)


def _named_commands(columns: Sequence[ColumnView]) -> list[ColumnView]:
    return [c for c in columns if grade(c.name, Kind.COMMAND) is not None]


def _commanded(table: TableSeen, columns: Sequence[ColumnView]) -> list[ColumnView]:
    """Without what only measures a command, sums of others, and switches beside commands of many sizes."""
    measured = measured_twins(c.name for c in columns)
    rest = [c for c in columns if c.name not in measured]
    values = np.column_stack([table.numbers(c.name) for c in rest]) if rest else np.empty((0, 0))
    sums = sums_of_sides([c.name for c in rest], values)
    rest = [c for c in rest if c.name not in sums]
    sizes = {c.name: len(np.unique(_finite(table.numbers(c.name)))) for c in rest}
    most = max(sizes.values(), default=0)
    return [c for c in rest if sizes[c.name] != SWITCH_VALUES or most <= 2 * SWITCH_VALUES]


def _finite(values: Array) -> Array:
    return np.asarray(values[np.isfinite(values)])


def _channels(
    path: Path, driven: Tables, pose: PoseColumns
) -> tuple[Entries, list[str], Sureness, str]:
    """Channels by name, columns left out for empty cells, and how sure they are commands."""
    first = driven[0]
    if len(driven) > 1:
        pairs = [(t, c.name) for t in driven for c in _able(t, pose)]
        found = named((f"{Path(t.key).stem}_{c}", _channel(t, c, first)) for t, c in pairs)
        sparse: list[str] = []
    else:
        able = _able(first, pose)
        if not able:
            raise RecordingError(
                f"{first.view.path}: no column besides poses and stamps changes, so there are no commands"
                f"{texts_of([first])}"
            )
        merged = any(first is own for own in pose.tables)
        likely = (_named_commands(able) if merged else []) or able
        full, sparse = _equally_filled(first, _commanded(first, likely))
        found = named((c.name, {"column": c.name}) for c in full)
    if not found:
        raise RecordingError(f"{path}: no column of {', '.join(t.key for t in driven)} changes")
    if all(grade(str(c["column"]), Kind.COMMAND) is not None for c in found.values()):
        return found, sparse, Sureness.LIKELY, "names; they change"
    if len(driven) == 1 and any(w in first.key.lower() for w in COMMAND_TABLE_WORDS):
        return found, sparse, Sureness.LIKELY, "name of the table; they change"
    return found, sparse, Sureness.GUESS, "they change, and are no other signal"


def _channel(table: TableSeen, name: str, main: TableSeen) -> dict[str, Any]:
    """A channel's entry; `file` and `stamp` where they are not those of all commands."""
    entry: dict[str, Any] = {"column": name}
    if table is not main:
        entry["file"] = table.key
        own = stamp_of(table).entry["column"]
        if own != stamp_of(main).entry["column"]:
            entry["stamp"] = own
    return entry


def _spare(table: TableSeen, pose: PoseColumns, channels: Entries) -> tuple[str, ...]:
    """Columns beside the commands that change and may scale thrust: voltage, speed of a propeller."""
    used = {c["column"] for c in channels.values()} | stamp_columns(table) | pose.names_in(table)
    motion = (Kind.HEADING, Kind.COURSE, Kind.YAW_RATE, Kind.X, Kind.Y)
    return tuple(
        c.name
        for c in table.view.columns
        if c.changes and c.least is not None and c.name and c.name not in used
        and not c.empty and not is_validity(c) and is_quaternion_part(c.name) is None
        and (SCALE_WORDS.intersection(read_name(c.name).words)
             or grade(c.name, Kind.MEASURED) is not Grade.WHOLE)
        and not any(grade(c.name, kind) for kind in motion)
    )[:MOST_SPARE]  # fmt: skip


def _equally_filled(
    table: TableSeen, columns: Sequence[ColumnView]
) -> tuple[list[ColumnView], list[str]]:
    """The largest group of columns filled in the same rows, and the names of the others.

    Where no two are filled in the same rows each is logged on change: all of them.
    """
    groups: dict[bytes, list[ColumnView]] = {}
    for column in columns:
        groups.setdefault(np.isfinite(table.numbers(column.name)).tobytes(), []).append(column)
    chosen = max(groups.values(), key=lambda own: (len(own), -own[0].empty))
    if len(chosen) == 1:
        return list(columns), []
    return chosen, [c.name for c in columns if c not in chosen]
