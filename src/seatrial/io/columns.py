# SPDX-License-Identifier: MIT
"""The columns of a table, before there is a vehicle file."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from seatrial.io.table import CsvTable
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.frames import Array

PER_SECOND = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
UNIX_TIMES = (9.5e8, 4.1e9)  # [s] the years 2000 to 2100
SLOWEST_RATE = 0.5  # [Hz] least plausible rate of a log


@dataclass(frozen=True)
class ColumnView:
    """The numbers of one column."""

    name: str
    least: float | None  # None: no numbers
    most: float | None
    empty: int  # cells without a number
    unit: str  # of time, where the column is monotonic; else empty
    rate: float  # [Hz] then
    changes: bool

    @property
    def text(self) -> str:
        """One line."""
        if self.least is None:
            return "no numbers"
        text = f"{self.least:.6g} to {self.most:.6g}" + (
            f", {self.empty} without a number" if self.empty else ""
        )
        if self.unit:
            return f"{text}; monotonic: stamps in {self.unit}? {self.rate:.4g} Hz"
        return text if self.changes else f"{text}; constant"


@dataclass(frozen=True)
class TableView:
    """The columns of one table."""

    path: str
    rows: int
    columns: tuple[ColumnView, ...]


def look_at_columns(path: Path) -> list[TableView]:
    """Every numeric column of a table, or of the tables in a folder."""
    if not path.exists():
        raise FileError(f"{path}: no such file or folder")
    tables = sorted(path.glob("*.csv")) if path.is_dir() else [path]
    if not tables:
        raise FileError(f"{path}: no .csv file and no bag in this folder")
    return [_view(CsvTable(table)) for table in tables]


def columns_text(tables: Sequence[TableView]) -> str:
    """Name and range of every column."""
    lines = []
    for table in tables:
        width = max(len(column.name) for column in table.columns)
        lines.append(f"{table.path}: {table.rows} rows")
        lines += [f"  {column.name:<{width}}  {column.text}" for column in table.columns]
    where = Path(tables[0].path).parent if len(tables) > 1 else tables[0].path
    return "\n".join(
        [*lines, f"  => seatrial init {where} -o vehicle.yaml writes a vehicle file to start from"]
    )


def columns_json(path: Path, tables: Sequence[TableView]) -> dict[str, Any]:
    """The same as JSON."""
    return {"path": str(path), "kind": "tables", "tables": msgspec.to_builtins(list(tables))}


def _view(table: CsvTable) -> TableView:
    try:
        values = table.columns(table.names)
    except RecordingError:  # a cell is not a number
        values = _numbers(table)
        if not np.isfinite(values).any():
            raise
    columns = zip(table.names, values.T, strict=True)
    return TableView(str(table.path), len(values), tuple(_column(n, c) for n, c in columns))


def _numbers(table: CsvTable) -> Array:
    """All cells (rows, columns); NaN where a cell is missing or not a number."""
    found: list[list[float]] = []
    with table.path.open(encoding="utf-8-sig", newline="", errors="replace") as file:
        try:
            for row in islice(csv.reader(file, delimiter=table.delimiter), 1, None):
                cells = [*row, *[""] * len(table.names)][: len(table.names)]
                if row:
                    found.append([_number(cell) for cell in cells])
        except csv.Error as error:
            raise RecordingError(f"{table.path}: is not a CSV table ({error})") from None
    return np.array(found, dtype=float).reshape(-1, len(table.names))


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")


def _column(name: str, column: Array) -> ColumnView:
    given = column[np.isfinite(column)]
    if len(given) == 0:
        return ColumnView(name, None, None, len(column), "", 0.0, changes=False)
    steps = np.diff(given)
    unit, rate = "", 0.0
    if len(steps) > 2 and np.all(steps >= 0) and np.median(steps) > 0:
        unit = _time_unit(float(given.max()), float(np.median(steps)))
        rate = PER_SECOND[unit] / float(np.median(steps))
    return ColumnView(
        name, float(given.min()), float(given.max()), len(column) - len(given), unit, rate,
        changes=len(np.unique(given)) > 1,
    )  # fmt: skip


def _time_unit(most: float, step: float) -> str:
    """The unit in which stamps are Unix times; else the largest with a plausible rate."""
    for unit, scale in PER_SECOND.items():
        if UNIX_TIMES[0] < most / scale < UNIX_TIMES[1]:
            return unit
    return next((u for u, scale in PER_SECOND.items() if scale / step >= SLOWEST_RATE), "ns")
