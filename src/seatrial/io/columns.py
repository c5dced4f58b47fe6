# SPDX-License-Identifier: MIT
"""The columns of a table, before there is a vehicle file."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from seatrial.boat.schema import Column
from seatrial.io.kinds import refused
from seatrial.io.table import Table, open_tables
from seatrial.io.tables.stamps import TO_NANOSECONDS, UNPADDED, is_date_time, is_unpadded
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

PER_SECOND = {unit: 1e9 / nanoseconds for unit, nanoseconds in TO_NANOSECONDS.items()}
DAY = 86_400.0  # [s]
SERIAL_DAYS = {"days of Excel": 25569.0, "days of MATLAB": 719529.0}  # number of 1 January 1970
PER_SECOND |= dict.fromkeys(SERIAL_DAYS, 1 / DAY)
UNIX_TIMES = (9.5e8, 4.1e9)  # [s] the years 2000 to 2100
DATE_TIME_UNIT = "date and time"
SLOWEST_RATE = 0.5  # [Hz] least plausible rate of a log


@dataclass(frozen=True)
class ColumnView:
    """The numbers of one column."""

    name: str
    least: float | None  # None: no numbers
    most: float | None
    empty: int  # cells without a number
    unit: str  # of time, where the column is monotonic or has dates; else empty
    rate: float  # [Hz] then
    changes: bool

    @property
    def text(self) -> str:
        """One line."""
        if self.unit == DATE_TIME_UNIT:
            return f"dates and times: stamps? {self.rate:.4g} Hz"
        if self.least is None:
            return "no numbers"
        empty = f", {self.empty} without a number" if self.empty else ""
        text = f"{self.least:.6g} to {self.most:.6g}{empty}"
        if self.unit:
            return f"{text}; monotonic: stamps in {self.unit}? {self.rate:.4g} Hz"
        return text if self.changes else f"{text}; constant"


@dataclass(frozen=True)
class TableView:
    """The columns of one table."""

    path: str
    rows: int
    columns: tuple[ColumnView, ...]


@dataclass(frozen=True)
class TableSeen:
    """A table, its numbers and what they show."""

    key: str  # its name in `pose: file`; of the only table of a file empty
    table: Table
    values: Array  # (n, columns); NaN where a cell is not a number
    view: TableView

    def numbers(self, name: str) -> Array:
        """A column (n,)."""
        return np.asarray(self.values[:, self.table.names.index(name)])


Tables = Sequence[TableSeen]


def read_tables(path: Path) -> list[TableSeen]:
    """The tables of a file or folder with all their numbers. Raises RecordingError, FileError."""
    if error := refused(path):
        raise error
    try:
        tables = open_tables(path)
        several = path.is_dir() or len(tables) > 1
        return [table_seen(path, key if several else "", table) for key, table in tables.items()]
    except RecordingError as error:
        if path.suffix.lower() != ".txt":
            raise
        raise RecordingError(f"{error}. Is it a note? A .txt file is read as a table") from error


def columns_text(tables: Sequence[TableView]) -> str:
    """Name and range of every column."""
    lines = []
    for table in tables:
        width = max(len(column.name) for column in table.columns)
        lines.append(f"{table.path}: {table.rows} rows")
        lines += [f"  {column.name:<{width}}  {column.text}" for column in table.columns]
    return "\n".join(lines)


def table_seen(path: Path, key: str, table: Table) -> TableSeen:
    """A table with all its numbers. Raises RecordingError where it has none."""
    try:
        values = table.columns(table.names)
    except RecordingError:  # a cell is not a number
        values = table.numbers()
        if not np.isfinite(values).any():
            raise
    pairs = zip(table.names, values.T, strict=True)
    columns = tuple(_column(table, name, column) for name, column in pairs)
    shown = f"{path / key}" if path.is_dir() else f"{path}:{key}" if key else str(path)
    return TableSeen(key, table, values, TableView(shown, len(values), columns))


def _column(table: Table, name: str, column: Array) -> ColumnView:
    given = column[np.isfinite(column)]
    if len(given) == 0:
        return _dates(table, name, column)
    with np.errstate(over="ignore", invalid="ignore"):
        steps = np.diff(given)
    unit, rate = "", 0.0
    if len(steps) > 2 and np.median(steps) > 0:
        if np.all(steps >= 0):
            unit = _time_unit(float(given.max()), float(np.median(steps)))
            rate = PER_SECOND[unit] / float(np.median(steps))
        elif name and len(given) == len(column) and is_unpadded(table.texts(name) or []):
            unit, rate = UNPADDED, _rate(table, name, "s.ns")
    return ColumnView(
        name, float(given.min()), float(given.max()), len(column) - len(given), unit, rate,
        changes=bool(np.any(given != given[0])),
    )  # fmt: skip


def _dates(table: Table, name: str, column: Array) -> ColumnView:
    """A column without numbers: dates and times, or other text."""
    unit, rate = "", 0.0
    texts = table.texts(name) if name else None
    if texts and is_date_time(next((text for text in texts if text), "")):
        with suppress(RecordingError):
            rate = _rate(table, name, None)
            unit = DATE_TIME_UNIT
    return ColumnView(name, None, None, len(column), unit, rate, changes=bool(unit))


def _rate(table: Table, name: str, unit: Literal["s.ns"] | None) -> float:
    """[Hz] of a column of stamps."""
    stamps, _ = table.evened(Column(column=name, unit=unit))
    steps = np.diff(stamps)
    usual = float(np.median(steps)) if len(steps) else 0.0
    return 1e9 / usual if usual > 0 else 0.0


def _time_unit(most: float, step: float) -> str:
    """The unit in which stamps are Unix times or serial days; else the largest with a plausible rate."""
    for unit, epoch in SERIAL_DAYS.items():
        if UNIX_TIMES[0] < (most - epoch) * DAY < UNIX_TIMES[1] and step * DAY < 1 / SLOWEST_RATE:
            return unit
    for unit, scale in PER_SECOND.items():
        if UNIX_TIMES[0] < most / scale < UNIX_TIMES[1]:
            return unit
    return next((u for u, scale in PER_SECOND.items() if scale / step >= SLOWEST_RATE), "ns")
