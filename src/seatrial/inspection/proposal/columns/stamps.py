# SPDX-License-Identifier: MIT
"""The column of a table that has its stamps, by name and by value."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from seatrial.inspection.proposal.columns.names import (
    UNITS,
    Grade,
    Kind,
    family,
    grade,
    order,
    read_name,
)
from seatrial.inspection.proposal.columns.signals import LISTED, shown
from seatrial.inspection.proposal.sources import Recognised, Sureness
from seatrial.io.columns import DATE_TIME_UNIT, DAY, SERIAL_DAYS, ColumnView, TableSeen
from seatrial.util.errors import RecordingError
from seatrial.util.format import percent

MOST_REST = 1e9  # [ns] of a second
# share of a clock's steps that go ahead, jumps back included; of a position about half do
LEAST_RISING = 0.8
TIME_UNITS = ("s", "ms", "us", "ns")


@dataclass(frozen=True)
class StampFound:
    """The column with the stamps of a table."""

    entry: dict[str, Any]  # as the vehicle file has it
    why: str
    sure: Sureness
    others: tuple[str, ...]


def find_stamp(table: TableSeen) -> StampFound | None:
    """Seconds and nanoseconds, a named column that rises, dates and times, any column that rises."""
    found: list[tuple[float, dict[str, Any], str, Sureness]] = []
    for column in table.view.columns:
        fit = grade(column.name, Kind.STAMP) if column.name else None
        rest = _rest_of(table, column)
        if rest:
            entry = {"column": column.name, "nanoseconds": rest}
            found.append((50.0, entry, "names; whole seconds and nanoseconds", Sureness.CERTAIN))
        elif fit is not None and column.unit:
            kind = "dates and times" if column.unit == DATE_TIME_UNIT else "it rises"
            sure = Sureness.CERTAIN if fit > Grade.PART else Sureness.LIKELY
            why = f"name; {kind}, {column.rate:.4g} Hz"
            if column.unit == "s.ns":
                why = (
                    "name; it jumps back as seconds, and rises as nanoseconds without leading zeros"
                )
            whole = 0.0 if column.empty else 5.0
            found.append((40.0 + whole + fit + _earliness(column), _stamp(column), why, sure))
        elif fit is not None and fit > Grade.PART and _mostly_rises(table, column):
            why = "name; it does not always rise"
            found.append((20.0 + fit + _earliness(column), _stamp(column), why, Sureness.LIKELY))
        elif (
            column.unit and column.name and grade(column.name, Kind.MEASURED) is None
            and not _counts_rows(table, column)
        ):  # fmt: skip
            why = f"it rises, {column.rate:.4g} Hz"
            found.append((10.0, _stamp(column), why, Sureness.GUESS))
    if not found:
        return None
    found.sort(key=lambda f: -f[0])
    _, entry, why, sure = found[0]
    return StampFound(entry, why, sure, tuple(str(f[1]["column"]) for f in found[1:]))


def stamp_of(table: TableSeen) -> StampFound:
    """The same. Raises RecordingError with the table's columns, and what is wrong with those that could be it."""
    if (stamp := find_stamp(table)) is not None:
        return stamp
    columns = [c for c in table.view.columns if c.name]
    found = [text for c in columns if (text := _why_none(table, c))]
    listed = ", ".join(c.name for c in columns[:LISTED])
    raise RecordingError(
        f"{table.view.path}: no column of stamps; it has {listed}. {''.join(found)}"
        "Name it with --pose stamp=COLUMN"
    )


def _why_none(table: TableSeen, column: ColumnView) -> str:
    """Why a column that is named like stamps, or rises, is none; empty: it is something else."""
    name, rows = column.name, table.view.rows
    if _counts_rows(table, column):
        return (
            f"{name} counts rows and is no time: with a known rate [Hz] write stamp: {{column: {name}, scale: "
            "RATE} in the vehicle file. "
        )
    if not grade(name, Kind.STAMP):
        return ""
    if column.least is None:
        first = next((text for text in table.table.texts(name) or [] if text), "")
        return (
            f"{name} has '{first[:40]}', which is not in a known format of times. " if first else ""
        )
    values = table.numbers(name)
    count = len(np.unique(values[np.isfinite(values)]))
    back = float(np.mean(np.diff(values) < 0.0))
    if back > LEAST_RISING:
        return f"{name} falls from row to row: sort the rows by it. "
    if back > 1.0 - LEAST_RISING:
        return f"{name} goes back in {percent(back)} of the rows: sort them by it. "
    return f"{name} has {count} different values in {rows} rows: it was rounded; write it with more digits. "


def _counts_rows(table: TableSeen, column: ColumnView) -> bool:
    """Whether each row has the next whole number, under a name that is no stamp's."""
    if column.least is None or column.unit != "s" or grade(column.name, Kind.STAMP):
        return False
    values = table.numbers(column.name)
    return bool(np.all(np.diff(values) == 1.0) and values[0] == np.rint(values[0]))


def _mostly_rises(table: TableSeen, column: ColumnView) -> bool:
    """Whether a column is a clock that jumps back at times."""
    if column.least is None:
        return False
    values = table.numbers(column.name)
    steps = np.diff(values[np.isfinite(values)])
    steps = steps[steps != 0.0]
    return len(steps) > 0 and float(np.mean(steps > 0.0)) >= LEAST_RISING


def given_stamp(table: TableSeen, name: str) -> StampFound:
    """The column that the user chose."""
    column = next(c for c in table.view.columns if c.name == name)
    rest = _rest_of(table, column)
    entry = {"column": name, "nanoseconds": rest} if rest else _stamp(column)
    return StampFound(entry, "--pose", Sureness.CHOSEN, ())


def _earliness(column: ColumnView) -> float:
    """Usual names first."""
    return 1.0 / (2.0 + order(column.name, Kind.STAMP))


def _stamp(column: ColumnView) -> dict[str, Any]:
    """Column and unit: by name, else by value."""
    if column.unit in SERIAL_DAYS:
        return {"column": column.name, "offset": SERIAL_DAYS[column.unit], "scale": 1 / DAY}
    name = column.name.strip().lower()
    read = read_name(column.name)
    unit = column.unit or "s"
    if column.unit not in ("s.ns", DATE_TIME_UNIT):
        stated = UNITS.get(name, "")
        stated = stated if stated in TIME_UNITS[1:] else read.unit
        unit = stated if stated in TIME_UNITS else unit
    plain = unit in ("s", DATE_TIME_UNIT)
    return {"column": column.name} | ({} if plain else {"unit": unit})


def _rest_of(table: TableSeen, column: ColumnView) -> str:
    """The column of nanoseconds that belongs to this one of whole seconds."""
    name = column.name if column.least is not None else ""
    if not (name and grade(name, Kind.STAMP)) or grade(name, Kind.NANOSECONDS):
        return ""
    seconds = table.numbers(column.name)
    if not np.all(np.isnan(seconds) | (seconds == np.rint(seconds))):
        return ""
    for other in table.view.columns:
        if (
            other.name != column.name and other.least is not None and other.most is not None
            and grade(other.name, Kind.NANOSECONDS) and family(other.name) == family(column.name)
            and other.least >= 0 and other.most < MOST_REST
        ):  # fmt: skip
            return other.name
    return ""


def stamp_columns(table: TableSeen) -> set[str]:
    """Every column that is a stamp by its name, with its nanoseconds, and the one that is taken as the stamp."""
    taken = find_stamp(table)
    found: set[str] = set() if taken is None else {taken.entry["column"]}
    for column in table.view.columns:
        if column.name and grade(column.name, Kind.STAMP) in (Grade.WHOLE, Grade.PREFIXED):
            found.add(column.name)
            found.add(_rest_of(table, column) or column.name)
        elif column.name and grade(column.name, Kind.NANOSECONDS):
            found.add(column.name)
    return found


def recognised(signal: str, table: TableSeen, found: StampFound) -> Recognised:
    """A stamp as the table of signals shows it."""
    entry = found.entry
    names = [entry["column"], *([entry["nanoseconds"]] if "nanoseconds" in entry else [])]
    unit = f" [{entry['unit']}]" if "unit" in entry else ""
    return Recognised(signal, shown(table, *names) + unit, found.why, found.sure, found.others)
