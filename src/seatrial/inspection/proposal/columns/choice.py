# SPDX-License-Identifier: MIT
"""The columns of position, heading and stamps: those that the user names, else the best by name and value."""

from collections.abc import Mapping
from pathlib import Path

from seatrial.inspection.proposal.columns.bodies import likeliest_body, refuse_takes
from seatrial.inspection.proposal.columns.names import Grade, Kind, grade
from seatrial.inspection.proposal.columns.signals import (
    LISTED,
    Heading,
    Position,
    column_of,
    headings,
    positions,
    quaternions,
    weighed,
)
from seatrial.inspection.proposal.columns.stamps import (
    StampFound,
    given_stamp,
    stamp_of,
)
from seatrial.inspection.proposal.columns.up import about_y, refuse_steep, refuse_y_up, upright
from seatrial.inspection.proposal.sources import OPTIONS, Ask, Choices, assigned, choose
from seatrial.io.columns import ColumnView, Tables, TableSeen
from seatrial.io.table import is_table
from seatrial.util.errors import RecordingError

COORDINATE_KEYS = {
    "x": Kind.X, "y": Kind.Y, "east": Kind.EAST, "north": Kind.NORTH,
    "lat": Kind.LATITUDE, "latitude": Kind.LATITUDE, "lon": Kind.LONGITUDE, "longitude": Kind.LONGITUDE,
}  # fmt: skip
HEADING_KEYS = ("heading", "psi", "yaw")
CHOICE_KEYS = (*COORDINATE_KEYS, *HEADING_KEYS, "stamp", "yaw_rate")
EXAMPLE = "--pose x=COLUMN,y=COLUMN,heading=COLUMN"


def pose_signals(
    path: Path, tables: Tables, choices: Choices, ask: Ask | None
) -> tuple[dict[str, str], Position, Heading, StampFound]:
    """The columns that `--pose` gives, by key; those of position, heading and stamps."""
    given = assigned(choices.pose or "", "--pose", CHOICE_KEYS)
    if any(key in given for key in COORDINATE_KEYS):
        position = _given_position(path, tables, given)
    else:
        named = [] if given or choices.pose is None else [_table(path, tables, choices.pose)]
        position = _position(path, named or tables, ask)
    heading = _heading(path, tables, position, given, ask)
    return given, position, heading, _stamp(path, position.table, given)


def _table(path: Path, tables: Tables, name: str) -> TableSeen:
    for table in tables:
        if table.key and name in (table.key, Path(table.key).stem, table.table.name):
            return table
    listed = ", ".join(t.key for t in tables if t.key) or "only one; name columns: " + EXAMPLE
    raise RecordingError(f"{path}: no table {name} ({OPTIONS['poses']}); there are {listed}")


def _position(path: Path, own: Tables, ask: Ask | None) -> Position:
    """The best position by name and value; a question where several tables have one."""
    found = positions(own)
    if not found:
        raise RecordingError(_nothing(path, own, "position"))
    turning = {h.table.key for h in headings(own)}
    whole = [p for p in found if p.table.key in turning]
    best = whole or found
    best = [p for p in best if p.grade >= min(best[0].grade, Grade.PREFIXED)]
    tables = list({p.table.key: p.table for p in best}.values())
    body = tables[0] if len(tables) == 1 else likeliest_body(tables)
    if body is None and ask is None:
        refuse_takes(path, tables)
    key = body.key if body else choose(path, "poses", [t.key for t in tables], ask)
    position = upright(next(p for p in best if p.table.key == key), headings(own))
    if position.still and ask is not None:
        return _asked_position(position, ask)
    if position.still:
        refuse_y_up(position)
    return position


def _given_position(path: Path, tables: Tables, given: Mapping[str, str]) -> Position:
    chosen = {COORDINATE_KEYS[k]: v for k, v in given.items() if k in COORDINATE_KEYS}
    kinds = tuple(chosen)
    for pair in ((Kind.X, Kind.Y), (Kind.EAST, Kind.NORTH), (Kind.LATITUDE, Kind.LONGITUDE)):
        if set(kinds) == set(pair):
            columns = [column_of(path, tables, chosen[kind], "--pose") for kind in pair]
            (table, first), (other, second) = columns
            if table is not other:
                raise RecordingError(
                    f"{path}: --pose: {first} is in {table.key} and {second} in {other.key}; both "
                    "coordinates are columns of one table"
                )
            found = weighed(table, pair, (first, second), chosen=True)
            assert found is not None
            return found
    raise RecordingError(
        f"{path}: --pose has {', '.join(k.value for k in kinds)}; give x and y, east and north, or lat and lon"
    )


def _asked_position(position: Position, ask: Ask) -> Position:
    """A coordinate that hardly moves may be a height."""
    table, names = position.table, position.names
    i = names.index(position.still)
    options = [position.still, *(c.name for c in _numeric(table) if c.name not in names)]
    name = ask(f"{position.still} hardly moves. Which column is the other coordinate?", options)
    pair = (name, names[1]) if i == 0 else (names[0], name)
    return weighed(table, position.kinds, pair, chosen=True) or position


def _numeric(table: TableSeen) -> list[ColumnView]:
    return [c for c in table.view.columns if c.name and c.changes and c.least is not None]


def _nothing(path: Path, tables: Tables, what: str) -> str:
    """What an error says where a signal is not found."""
    listed = "; ".join(
        f"{t.view.path}: {', '.join(c.name for c in _numeric(t)[:LISTED])}" for t in tables
    )
    courses = [c.name for t in tables for c in _numeric(t) if grade(c.name, Kind.COURSE)]
    course = f" {courses[0]} is a course, the direction of the motion." if courses else ""
    return (
        f"{path}: no table has columns named like x, y and psi (or yaw, heading, a quaternion; lat and lon): "
        f"no {what}.{course}{_deeper(path)} Name them with {EXAMPLE}. Columns that change are {listed[:400]}"
        f"{texts_of(tables)}"
    )


def _deeper(path: Path) -> str:
    """What an error says of tables in folders below the recording's."""
    below = sorted(path.glob("*/*")) if path.is_dir() else []
    found = [p for p in below if p.is_file() and is_table(p)]
    if not found:
        return ""
    return (
        f" Tables in folders below, such as {found[0].relative_to(path)}, are not read: put all tables of a "
        "recording into one folder."
    )


def texts_of(tables: Tables) -> str:
    """What an error says of columns that hold text in place of numbers; empty: there are none."""
    found = []
    for table in tables:
        for column in table.view.columns:
            if not column.name or column.unit or column.least is not None:
                continue
            first = next((text for text in table.table.texts(column.name) or [] if text), "")
            if first:
                found.append(f"{column.name} ('{first[:20]}')")
    text = ", ".join(found[:LISTED])
    return f". Columns with text, not numbers: {text}; write plain numbers" if text else ""


def _heading(
    path: Path, tables: Tables, position: Position, given: Mapping[str, str], ask: Ask | None
) -> Heading:
    """The heading: as given, or the best of the position's table, or of another."""
    name = next((given[key] for key in HEADING_KEYS if key in given), None)
    if name is not None:
        table, column = column_of(path, tables, name, "--pose")
        four = next((q for q in quaternions(table) if column in q), None)
        return Heading(table, four or (column,), Grade.WHOLE, 0)
    found = [h for h in headings(tables) if not set(h.names) & set(position.names)]
    beside = [h for h in found if h.table is position.table]
    if beside:
        heading = about_y(beside[0], position)
        refuse_steep(heading)
        return heading
    if found:
        best = [h for h in found if h.grade == found[0].grade]
        keys = list(dict.fromkeys(h.table.key for h in best))
        key = keys[0] if len(keys) == 1 else choose(path, "headings", keys, ask)
        return next(h for h in best if h.table.key == key)
    options = [c.name for c in _numeric(position.table) if c.name not in position.names]
    if ask is None or not options:
        raise RecordingError(_nothing(path, tables, "heading"))
    name = ask("Which column is the heading?", options)
    return Heading(position.table, (name,), Grade.PART, 0)


def _stamp(path: Path, table: TableSeen, given: Mapping[str, str]) -> StampFound:
    if "stamp" in given:
        return given_stamp(*column_of(path, [table], given["stamp"], "--pose"))
    return stamp_of(table)
