# SPDX-License-Identifier: MIT
"""The pose's columns as the vehicle file has them: position, heading with its zero and sense, stamps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from seatrial.inspection.proposal.columns.choice import HEADING_KEYS, pose_signals
from seatrial.inspection.proposal.columns.clocks import by_clock_of, stamp_beside
from seatrial.inspection.proposal.columns.heading import Psi, psi_of, sense_by_motion
from seatrial.inspection.proposal.columns.heading_sense import Sense
from seatrial.inspection.proposal.columns.names import Kind
from seatrial.inspection.proposal.columns.signals import (
    Heading,
    Position,
    headings,
    is_validity,
    positions,
    shown,
    stated_unit,
)
from seatrial.inspection.proposal.columns.stamps import StampFound, recognised
from seatrial.inspection.proposal.columns.yaw_rate import YawRate, find_yaw_rate, seconds_of
from seatrial.inspection.proposal.sources import Ask, Choices, Recognised, Sureness
from seatrial.io.columns import Tables, TableSeen
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Axes

STAMPS = "stamps of the poses"
ORIGIN_DIGITS = 6  # [deg] 0.1 m
FEET = round(1 / 0.3048, 9)  # in a metre


@dataclass(frozen=True)
class PoseColumns:
    """Entries of `pose:`, the tables they are from, and how each was recognised."""

    entries: dict[str, Any]
    tables: tuple[TableSeen, ...]  # of the position; of the heading, where it is another
    taken: Mapping[str, frozenset[str]]  # columns of a table, by its key
    recognised: tuple[Recognised, ...]
    stamp: StampFound
    notes: Mapping[str, list[str]] = field(default_factory=dict)

    def by_clock_of(self, commands: TableSeen, stamp: StampFound) -> "PoseColumns":
        """With stamps by the clock of the commands, where the table of the poses has several."""
        table = self.tables[0]
        own = by_clock_of(table, self.stamp, commands, stamp)
        if own is self.stamp or len(self.tables) > 1:
            return self
        rest = [r for r in self.recognised if r.signal != STAMPS]
        seen = (*rest, recognised(STAMPS, table, own))
        entries = self.entries | {"stamp": own.entry}
        return replace(self, entries=entries, recognised=seen, stamp=own)

    def names_in(self, table: TableSeen) -> frozenset[str]:
        """Columns of the table that belong to the pose."""
        return self.taken.get(table.key, frozenset())


def choose_pose(path: Path, tables: Tables, choices: Choices, ask: Ask | None) -> PoseColumns:
    """Position, heading, stamps, and a gyro's yaw rate. Raises RecordingError."""
    axes = Axes(choices.axes)
    # 1. Columns by name and value.
    given, position, heading, stamp = pose_signals(path, tables, choices, ask)
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
        recognised(STAMPS, position.table, stamp),
    ]
    # 3. Yaw rate, and what marks valid poses.
    notes = _axes_notes(position, axes)
    rate = find_yaw_rate(path, tables, heading, psi, given)
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
    return PoseColumns(entries, used, taken, tuple(found), stamp, notes)


def _axes_notes(position: Position, axes: Axes) -> dict[str, list[str]]:
    """What is known of the axes of the poses."""
    if position.east_north is not None:
        first, second = ("north", "east") if axes is Axes.FRD else ("east", "north")
        return {"known axes": [f"x is {first} and y is {second}"]}
    if not position.right_handed:
        return {}
    up, captured = "y" if position.y_up else "z", "motion capture has right-handed axes"
    if axes is Axes.FLU:
        return {"known axes": [f"known: {captured}, here with {up} up"]}
    return {"pose": [f"check axes: {captured}; with {up} up they are {Axes.FLU.value}"]}


def heading_and_sense(
    path: Path, tables: Tables, choices: Choices
) -> tuple[Position, Heading, Sense | None]:
    """Position, heading, and the sense in which the heading follows the motion. Raises RecordingError."""
    _, position, heading, stamp = pose_signals(path, tables, choices, None)
    course = _at_positions(position, heading, stamp)
    return position, heading, sense_by_motion(position, heading, course)


def _at_positions(position: Position, heading: Heading, stamp: StampFound) -> Array:
    """The heading (n,) as written at the rows of the positions, from its own table or rows by its stamps."""
    values: Array = heading.values
    own: StampFound | None = stamp
    if heading.table is position.table:
        beside = np.isfinite(values)[np.isfinite(position.values).all(axis=0)]
        if 2 * beside.sum() >= len(beside):
            return values
    else:
        own = stamp_beside(heading.table, position.table, stamp)
    if own is None:
        raise RecordingError(
            f"{heading.table.view.path}: no column of stamps for {heading.names[0]}"
        )
    there, here = seconds_of(heading.table, own), seconds_of(position.table, stamp)
    good = np.isfinite(values)
    order = np.argsort(there[good], kind="stable")
    at = np.searchsorted(there[good][order], here).clip(0, max(0, int(good.sum()) - 1))
    return values[good][order][at] if good.any() else np.full(len(here), np.nan)


def _coordinates(position: Position, axes: Axes) -> dict[str, Any]:
    """x and y, or latitude, longitude and origin."""
    first, second = (_coordinate(position, i) for i in (0, 1))
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


def _coordinate(position: Position, i: int) -> dict[str, Any]:
    name, scale, offset = position.names[i], position.scale, position.offsets[i]
    unit = stated_unit(position.table, name)
    entry: dict[str, Any] = {"column": name}
    if unit in ("cm", "mm"):
        entry["unit"] = unit
    elif unit == "ft":
        scale = FEET
    stated = {"sign": position.signs[i], "offset": offset, "scale": scale}
    usual = {"sign": 1, "offset": 0.0, "scale": 1.0}
    return entry | {key: value for key, value in stated.items() if value != usual[key]}


def _elsewhere(table: TableSeen, main: TableSeen, stamp: StampFound) -> dict[str, Any]:
    """`file` and `stamp` of a signal in another table than the position's."""
    if table is main:
        return {}
    own = stamp_beside(table, main, stamp)
    entry: dict[str, Any] = {"file": table.key}
    if own is not None and own.entry["column"] != stamp.entry["column"]:
        entry["stamp"] = own.entry["column"]
    return entry


def _taken(position: Position, heading: Heading, rate: YawRate | None) -> dict[str, frozenset[str]]:
    """Columns of the pose by table."""
    found: dict[str, set[str]] = {}
    coordinates = (*position.names, *([position.height] if position.height else []))
    for table, names in ((position.table, coordinates), (heading.table, heading.names)):
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
    columns = shown(heading.table, *heading.names) + unit
    return Recognised("heading", columns, psi.why, psi.sure, tuple(rest))
