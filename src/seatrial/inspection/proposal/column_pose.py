# SPDX-License-Identifier: MIT
"""The pose's columns as the vehicle file has them: position, heading with its zero and sense, stamps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from seatrial.boat.schema import TO_SI, Column
from seatrial.inspection.proposal.column_heading import Psi, psi_of, sense_by_motion
from seatrial.inspection.proposal.column_names import Grade, Kind, grade, read_name
from seatrial.inspection.proposal.column_signals import (
    LEAST_CORRELATION,
    LISTED,
    Heading,
    Position,
    StampFound,
    column_of,
    find_stamp,
    given_stamp,
    headings,
    is_gyro,
    is_validity,
    positions,
    quaternions,
    recognised,
    shown,
    weighed,
    yaw_rates,
)
from seatrial.inspection.proposal.heading_sense import Sense, rate_factor
from seatrial.inspection.proposal.sources import (
    OPTIONS,
    Ask,
    Choices,
    Recognised,
    Sureness,
    assigned,
    choose,
)
from seatrial.io.columns import ColumnView, TableSeen
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Axes

COORDINATE_KEYS = {
    "x": Kind.X, "y": Kind.Y, "east": Kind.EAST, "north": Kind.NORTH,
    "lat": Kind.LATITUDE, "latitude": Kind.LATITUDE, "lon": Kind.LONGITUDE, "longitude": Kind.LONGITUDE,
}  # fmt: skip
HEADING_KEYS = ("heading", "psi", "yaw")
CHOICE_KEYS = (*COORDINATE_KEYS, *HEADING_KEYS, "stamp", "yaw_rate")
EXAMPLE = "--pose x=COLUMN,y=COLUMN,heading=COLUMN"
ORIGIN_DIGITS = 6  # [deg] 0.1 m
RATE_SLACK = 0.3  # of a slope of 1, of a yaw rate in the unit that is tried


@dataclass(frozen=True)
class PoseColumns:
    """Entries of `pose:`, the tables they are from, and how each was recognised."""

    entries: dict[str, Any]
    tables: tuple[TableSeen, ...]  # of the position; of the heading, where it is another
    taken: Mapping[str, frozenset[str]]  # columns of a table, by its key
    recognised: tuple[Recognised, ...]
    notes: Mapping[str, list[str]] = field(default_factory=dict)

    def names_in(self, table: TableSeen) -> frozenset[str]:
        """Columns of the table that belong to the pose."""
        return self.taken.get(table.key, frozenset())


def choose_pose(
    path: Path, tables: Sequence[TableSeen], choices: Choices, ask: Ask | None
) -> PoseColumns:
    """Position, heading, stamps, and a gyro's yaw rate. Raises RecordingError."""
    given, own = _given(path, tables, choices)
    axes = Axes(choices.axes)
    # 1. Columns by name and value.
    position, heading, stamp = _signals(path, own, tables, given, ask)
    # 2. Zero, sense and unit of the heading.
    course = _at_positions(position, heading, stamp)
    psi = psi_of(position, heading, course, axes, ask)
    if any(key in given for key in HEADING_KEYS):
        psi = Psi(psi.entry, psi.values, Sureness.CHOSEN, f"--pose; {psi.why}")
    entries: dict[str, Any] = {"file": position.table.key} if position.table.key else {}
    entries["stamp"] = stamp.entry
    entries |= _coordinates(position, axes)
    entries["psi"] = psi.entry | _elsewhere(heading.table, position.table, stamp)
    found = [
        *_recognised_position(position, positions(tables)),
        _recognised_heading(heading, psi, headings(tables)),
        recognised("stamps of the poses", position.table, stamp),
    ]
    # 3. Yaw rate, and what marks valid poses.
    notes: dict[str, list[str]] = {}
    if position.east_north is not None:
        notes["known axes"] = [
            "x is north and y is east" if axes is Axes.FRD else "x is east and y is north"
        ]
    rate = _yaw_rate(path, tables, heading, psi, given)
    if rate is not None:
        table, name, entry, seen = rate
        found.append(seen)
        if seen.sure is Sureness.GUESS:
            notes["yaw_rate"] = [f"yaw_rate: {name}", seen.why]
        else:
            entries["yaw_rate"] = entry | _elsewhere(table, position.table, stamp)
    marks = [c.name for c in position.table.view.columns if is_validity(c)]
    if marks:
        entries["valid"] = marks[0]
    taken = _taken(position, heading, rate)
    used = (position.table, *([heading.table] if heading.table is not position.table else []))
    return PoseColumns(entries, used, taken, tuple(found), notes)


def heading_and_sense(
    path: Path, tables: Sequence[TableSeen], choices: Choices
) -> tuple[Position, Heading, Sense | None]:
    """Position, heading, and the sense in which the heading follows the motion. Raises RecordingError."""
    given, own = _given(path, tables, choices)
    position, heading, stamp = _signals(path, own, tables, given, None)
    return (
        position,
        heading,
        sense_by_motion(position, heading, _at_positions(position, heading, stamp)),
    )


def _given(
    path: Path, tables: Sequence[TableSeen], choices: Choices
) -> tuple[dict[str, str], Sequence[TableSeen]]:
    """Columns of `--pose`, and the tables that may have the position."""
    given = assigned(choices.pose or "", "--pose", CHOICE_KEYS)
    whole = given or choices.pose is None
    return given, tables if whole else [_table(path, tables, str(choices.pose))]


def _signals(
    path: Path, own: Sequence[TableSeen], tables: Sequence[TableSeen], given: Mapping[str, str],
    ask: Ask | None,
) -> tuple[Position, Heading, StampFound]:  # fmt: skip
    """The columns of position, heading and stamps."""
    position = _position(path, own, tables, given, ask)
    heading = _heading(path, tables, position, given, ask)
    return position, heading, _stamp(path, tables, position, given)


def _table(path: Path, tables: Sequence[TableSeen], name: str) -> TableSeen:
    for table in tables:
        if table.key and name in (table.key, Path(table.key).stem):
            return table
    listed = ", ".join(t.key for t in tables if t.key) or "only one; name columns: " + EXAMPLE
    raise RecordingError(f"{path}: no table {name} ({OPTIONS['poses']}); there are {listed}")


def _position(
    path: Path, own: Sequence[TableSeen], tables: Sequence[TableSeen], given: Mapping[str, str],
    ask: Ask | None,
) -> Position:  # fmt: skip
    """The position: as given, or the best by name and value; a question where several tables have one."""
    chosen = {COORDINATE_KEYS[k]: v for k, v in given.items() if k in COORDINATE_KEYS}
    if chosen:
        return _given_position(path, tables, chosen)
    found = positions(own)
    if not found:
        raise RecordingError(_nothing(path, own, "position"))
    turning = {h.table.key for h in headings(own)}
    whole = [p for p in found if p.table.key in turning]
    best = whole or found
    best = [p for p in best if p.grade >= min(best[0].grade, Grade.PREFIXED)]
    keys = list(dict.fromkeys(p.table.key for p in best))
    key = keys[0] if len(keys) == 1 else choose(path, "poses", keys, ask)
    position = next(p for p in best if p.table.key == key)
    if position.still and ask is not None:
        return _asked_position(position, ask)
    return position


def _given_position(
    path: Path, tables: Sequence[TableSeen], chosen: Mapping[Kind, str]
) -> Position:
    kinds = tuple(chosen)
    for pair in ((Kind.X, Kind.Y), (Kind.EAST, Kind.NORTH), (Kind.LATITUDE, Kind.LONGITUDE)):
        if set(kinds) == set(pair):
            (table, first), (other, second) = (
                column_of(path, tables, chosen[kind], "--pose") for kind in pair
            )
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


def _nothing(path: Path, tables: Sequence[TableSeen], what: str) -> str:
    """What an error says where a signal is not found."""
    listed = "; ".join(
        f"{t.view.path}: {', '.join(c.name for c in _numeric(t)[:LISTED])}" for t in tables
    )
    courses = [c.name for t in tables for c in _numeric(t) if grade(c.name, Kind.COURSE)]
    course = f" {courses[0]} is a course, the direction of the motion." if courses else ""
    return (
        f"{path}: no table has columns named like x, y and psi (or yaw, heading, a quaternion; lat and lon): "
        f"no {what}.{course} Name them with {EXAMPLE}. Columns that change are {listed[:400]}"
    )


def _heading(
    path: Path, tables: Sequence[TableSeen], position: Position, given: Mapping[str, str],
    ask: Ask | None,
) -> Heading:  # fmt: skip
    """The heading: as given, or the best of the position's table, or of another."""
    name = next((given[key] for key in HEADING_KEYS if key in given), None)
    if name is not None:
        table, column = column_of(path, tables, name, "--pose")
        four = next((q for q in quaternions(table) if column in q), None)
        return Heading(table, four or (column,), Grade.WHOLE, 0)
    found = [h for h in headings(tables) if not set(h.names) & set(position.names)]
    beside = [h for h in found if h.table is position.table]
    if beside:
        return beside[0]
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


def _stamp(
    path: Path, tables: Sequence[TableSeen], position: Position, given: Mapping[str, str]
) -> StampFound:
    if "stamp" in given:
        table, name = column_of(path, [position.table], given["stamp"], "--pose")
        return given_stamp(table, name)
    found = find_stamp(position.table)
    if found is None:
        listed = ", ".join(c.name for c in position.table.view.columns[:LISTED])
        raise RecordingError(
            f"{position.table.view.path}: no column of stamps; it has {listed}. Name it with --pose stamp=COLUMN"
        )
    return found


def _at_positions(position: Position, heading: Heading, stamp: StampFound) -> Array:
    """The heading (n,) as written at the rows of the positions, from its own table by its stamps."""
    values = heading.values
    if heading.table is position.table:
        return values
    own = find_stamp(heading.table)
    if own is None:
        raise RecordingError(
            f"{heading.table.view.path}: no column of stamps for {heading.names[0]}"
        )
    there, here = _seconds(heading.table, own), _seconds(position.table, stamp)
    good = np.isfinite(values)
    order = np.argsort(there[good], kind="stable")
    at = np.searchsorted(there[good][order], here).clip(0, max(0, int(good.sum()) - 1))
    return values[good][order][at] if good.any() else np.full(len(here), np.nan)


def _seconds(table: TableSeen, found: StampFound) -> Array:
    """Stamps (n,) [s]; NaN where a row has none."""
    column = Column(**found.entry)
    rows = np.ones(len(table.values), dtype=bool)
    if np.isfinite(table.numbers(column.column)).any():
        rows = np.isfinite(table.numbers(column.column))
    out = np.full(len(rows), np.nan)
    out[rows] = table.table.stamps(column, rows) * 1e-9
    return out


def _coordinates(position: Position, axes: Axes) -> dict[str, Any]:
    """x and y, or latitude, longitude and origin."""
    first, second = (_coordinate(name, position.scale) for name in position.names)
    if position.kinds[0] is not Kind.LATITUDE:
        east_north = position.east_north is not None
        x, y = (second, first) if east_north and axes is Axes.FRD else (first, second)
        return {"x": x, "y": y}
    lat, lon = position.values
    known = np.flatnonzero(np.isfinite(lat) & np.isfinite(lon))
    entry: dict[str, Any] = {"latitude": first, "longitude": second}
    if len(known):
        entry["origin"] = [round(float(v[known[0]]), ORIGIN_DIGITS) for v in (lat, lon)]
    return entry


def _coordinate(name: str, scale: float) -> dict[str, Any]:
    unit = read_name(name).unit
    entry: dict[str, Any] = {"column": name}
    if unit in ("cm", "mm"):
        entry["unit"] = unit
    return entry | ({"scale": scale} if scale != 1.0 else {})


def _elsewhere(table: TableSeen, main: TableSeen, stamp: StampFound) -> dict[str, Any]:
    """`file` and `stamp` of a signal in another table than the position's."""
    if table is main:
        return {}
    own = find_stamp(table)
    entry: dict[str, Any] = {"file": table.key}
    if own is not None and own.entry["column"] != stamp.entry["column"]:
        entry["stamp"] = own.entry["column"]
    return entry


def _yaw_rate(
    path: Path, tables: Sequence[TableSeen], heading: Heading, psi: Psi, given: Mapping[str, str]
) -> tuple[TableSeen, str, dict[str, Any], Recognised] | None:
    """A yaw rate that agrees with the heading: of a gyro it is used, another is mentioned."""
    if "yaw_rate" in given:
        pairs = [column_of(path, tables, given["yaw_rate"], "--pose")]
    else:
        pairs = [(t, n) for t in tables for n in yaw_rates(t)]
        pairs.sort(key=lambda pair: not is_gyro(pair[1]))
    stamp = find_stamp(heading.table)
    if stamp is None:
        return None
    for table, name in pairs:
        entry = _rate_entry(table, name, heading, psi, stamp)
        if entry is None and "yaw_rate" not in given:
            continue
        sure, why = Sureness.CERTAIN, "name; it is the derivative of the heading, and of a gyro"
        if "yaw_rate" in given:
            sure, why = Sureness.CHOSEN, "--pose"
        elif not is_gyro(name):
            sure = Sureness.GUESS
            why = "check: of a gyro it adds information; of a filter leave it out"
        others = tuple(n for _, n in pairs if n != name)
        found = Recognised("yaw rate", shown(table, name), why, sure, others)
        return table, name, entry or {"column": name}, found
    return None


def _rate_entry(
    table: TableSeen, name: str, heading: Heading, psi: Psi, stamp: StampFound
) -> dict[str, Any] | None:
    """Sign and unit of a yaw rate by the heading; None where it is not its derivative."""
    at = _seconds(heading.table, stamp)
    values = heading.values * TO_SI[psi.entry.get("unit", "rad")] * psi.entry.get("sign", 1)
    rate = table.numbers(name)
    if table is not heading.table:
        own = find_stamp(table)
        if own is None:
            return None
        there = _seconds(table, own)
        good = np.isfinite(there) & np.isfinite(rate)
        if not good.any() or np.any(np.diff(there[good]) < 0):
            return None
        rate = np.interp(at, there[good], rate[good], left=np.nan, right=np.nan)
    slope, correlation = rate_factor(at, values, rate)
    if abs(correlation) < LEAST_CORRELATION:
        return None
    for unit in ("rad", "deg"):
        if abs(abs(slope) / TO_SI[unit] - 1) < RATE_SLACK:
            entry: dict[str, Any] = {"column": name} | ({"unit": unit} if unit == "deg" else {})
            return entry | ({"sign": -1} if slope < 0 else {})
    return None


def _taken(
    position: Position, heading: Heading, rate: tuple[TableSeen, str, Any, Any] | None
) -> dict[str, frozenset[str]]:
    """Columns of the pose by table."""
    found: dict[str, set[str]] = {}
    for table, names in ((position.table, position.names), (heading.table, heading.names)):
        found.setdefault(table.key, set()).update(names)
    if rate is not None:
        found.setdefault(rate[0].key, set()).add(rate[1])
    return {key: frozenset(names) for key, names in found.items()}


def _recognised_position(position: Position, others: Sequence[Position]) -> list[Recognised]:
    rest = [p for p in others if p.names != position.names or p.table is not position.table]
    return [
        Recognised(
            kind.value, shown(position.table, name), position.why, position.sure,
            tuple(dict.fromkeys(shown(p.table, p.names[i]) for p in rest)),
        )
        for i, (kind, name) in enumerate(zip(position.kinds, position.names, strict=True))
    ]  # fmt: skip


def _recognised_heading(heading: Heading, psi: Psi, others: Sequence[Heading]) -> Recognised:
    rest = [shown(h.table, *h.names) for h in others if h.names != heading.names]
    unit = f" [{psi.entry['unit']}]" if "unit" in psi.entry else ""
    return Recognised(
        "heading", shown(heading.table, *heading.names) + unit, psi.why, psi.sure, tuple(rest)
    )
