# SPDX-License-Identifier: MIT
"""MATLAB files as tables: vectors of one length, structs with a time, Simulink's signals."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from seatrial.io.tables.base import LISTED_COLUMNS, Table
from seatrial.io.tables.mat_files import Tree, read_variables
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

TIMES = ("t", "time", "times", "tout", "timestamp", "stamp", "utc", "secs", "datenum")
# names of fields that hold a signal, and say nothing of it
CARRIERS = ("signals", "values", "data")
SERIES = {"time", "t", *CARRIERS, "name", "label", "units", "dimensions", "blockname", "title"}
MOST_PARTS = 32  # columns of a matrix
# behind the name of a matrix: a variable with the names of its columns
LABELS = ("_label", "_labels", "_names", "_columns")
LEAST_ROWS = 3
DATENUM_OF_1970 = 719_529.0  # [days] MATLAB's serial date
DATENUMS = (693_962.0, 766_645.0)  # [days] the years 1900 to 2099
DAY = 86_400.0  # [s]
SAME_TIME = 1e-9  # largest relative difference of two time vectors that are one

Column = Array | list[str]


class MatTable(Table):
    """Vectors of one length out of a MATLAB file."""

    def __init__(self, path: Path, name: str, columns: dict[str, Column]) -> None:
        super().__init__(path, name)
        self._columns = {key: self._dated(key, column) for key, column in columns.items()}
        self.names = list(self._columns)

    def _texts(self, name: str) -> list[str] | None:
        column = self._columns[name]
        return column if isinstance(column, list) else None

    def _numbers(self, name: str) -> Array:
        return np.asarray(self._columns[name])

    def _dated(self, name: str, column: Column) -> Column:
        """MATLAB's serial dates as seconds since 1970."""
        if isinstance(column, list) or name.rpartition(".")[2].lower() not in TIMES:
            return column
        given = column[np.isfinite(column)]
        if len(given) == 0 or not (DATENUMS[0] < given.min() and given.max() < DATENUMS[1]):
            return column
        if np.ptp(given) > 366.0 or np.median(np.abs(np.diff(given))) > 1 / 24:
            return column
        self.remarks.append(f"'{name}' has MATLAB's serial dates, read as seconds since 1970")
        return (column - DATENUM_OF_1970) * DAY


def mat_tables(path: Path) -> list[Table]:
    """The tables of a MATLAB file. Raises RecordingError."""
    remarks: list[str] = []
    found = _Found({}, set())
    tree = read_variables(path, remarks)
    _gather(tree, (), found)
    found.join_series()
    tables = [
        MatTable(path, name, columns) for name, columns in found.tables.items()
        if any(isinstance(column, np.ndarray) for column in columns.values())
    ]  # fmt: skip
    if not tables:
        held = [f"{name} ({' x '.join(map(str, shape))})" for name, shape in _shapes(tree)]
        able = ", ".join(held[:LISTED_COLUMNS]) or "none"
        more = (
            f": {remarks[0]}"
            if remarks
            else f"; of its variables those that could be columns: {able}"
        )
        raise RecordingError(
            f"{path}: has no vectors of numbers, {LEAST_ROWS} long at least{more}; save time, positions, "
            "heading and commands as vectors of one length"
        )
    tables[0].remarks += remarks
    return list(tables)


@dataclass
class _Found:
    """Tables by name, and which of them are single signals with their time."""

    tables: dict[str, dict[str, Column]]
    series: set[str]

    def add(self, name: str, columns: dict[str, Column], *, series: bool) -> None:
        """Enter a table under a name of its own."""
        unique, number = name, 1
        while unique in self.tables:
            number += 1
            unique = f"{name}_{number}"
        self.tables[unique] = columns
        if series:
            self.series.add(unique)

    def join_series(self) -> None:
        """Signals with the same time become one table."""
        names = [name for name in self.tables if name in self.series]
        for i, name in enumerate(names):
            for other in names[i + 1 :]:
                if name in self.tables and other in self.tables and self._same_time(name, other):
                    inner = {c: v for c, v in self.tables.pop(other).items() if not _is_time(c)}
                    kept = self.tables[name]
                    kept |= {c if c not in kept else f"{other}.{c}": v for c, v in inner.items()}

    def _same_time(self, name: str, other: str) -> bool:
        both = (self.tables[name], self.tables[other])
        one, two = (next(v for c, v in table.items() if _is_time(c)) for table in both)
        if isinstance(one, list) or isinstance(two, list):
            return one is two
        return len(one) == len(two) and bool(np.allclose(one, two, rtol=SAME_TIME, atol=0.0))


def _gather(tree: Tree, above: tuple[str, ...], found: _Found) -> None:
    """The vectors of a struct by length; structs within it that have a time are tables of their own."""
    own = _own(tree, (), above, found)
    groups: dict[int, dict[str, Column]] = {}
    for name, column in own.items():
        groups.setdefault(len(column), {})[name] = column
    groups = {n: g for n, g in groups.items() if n >= LEAST_ROWS}
    whole = {n: g for n, g in groups.items() if len(g) > 1} or groups
    for columns in whole.values():
        first = next((c for c in columns if _is_time(c)), next(iter(columns)))
        name = ".".join(above) if len(whole) == 1 and above else ".".join((*above, first))
        parts = {key.lower() for key in tree}
        found.add(name, columns, series=bool(above) and parts <= SERIES and _is_time(first))


def _own(
    tree: Tree, inside: tuple[str, ...], above: tuple[str, ...], found: _Found
) -> dict[str, Column]:
    """Vectors of a struct by dotted name, with those of inner structs without a time."""
    columns: dict[str, Column] = {}
    labelled = _labelled(tree)
    for key, value in tree.items():
        if key in labelled:
            _gather(labelled[key], (*above, *inside, key), found)
        elif isinstance(value, dict) and _has_time(value):
            _gather(value, (*above, *inside, key), found)
        elif isinstance(value, dict):
            columns |= _own(value, (*inside, key), above, found)
        elif key.removesuffix(_label_of(key)) not in labelled:
            parts = tuple(p for p in (*inside, key) if p.lower() not in CARRIERS)
            columns |= _vectors(".".join(parts or above[-1:] or (key,)), value)
    return columns


def _labelled(tree: Tree) -> dict[str, Tree]:
    """Matrices whose columns have names in a variable beside them, GPS and GPS_label, as structs of these."""
    found: dict[str, Tree] = {}
    for key, names in tree.items():
        matrix = tree.get(key.removesuffix(_label_of(key)))
        if not (_label_of(key) and isinstance(names, list) and isinstance(matrix, np.ndarray)):
            continue
        if matrix.ndim == 2 and len(names) in matrix.shape and len(set(names)) == len(names):
            rows = matrix if matrix.shape[1] == len(names) else matrix.T
            found[key.removesuffix(_label_of(key))] = dict(zip(names, rows.T, strict=True))
    return found


def _label_of(key: str) -> str:
    """The end of a name that says that names of columns are in it; empty: it is another."""
    return next((end for end in LABELS if key.endswith(end) and key != end), "")


def _has_time(tree: Tree) -> bool:
    """Whether a struct has a time and, somewhere, a vector as long."""
    for key, value in tree.items():
        if _is_time(key) and not isinstance(value, dict) and len(value) >= LEAST_ROWS:
            rows = len(value)
            return any(rows in shape for name, shape in _shapes(tree) if name != key)
    return False


def _shapes(tree: Tree) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Names and shapes of all vectors below a struct."""
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _shapes(value)
        else:
            yield key, np.shape(value) if not isinstance(value, list) else (len(value),)


def _vectors(name: str, value: Array | list[str]) -> dict[str, Column]:
    """Columns of a vector or of a matrix, whose longer side is the rows."""
    if isinstance(value, list) or value.ndim == 1:
        return {name: value}
    rows = value if value.shape[0] >= value.shape[1] else value.T
    if rows.shape[1] > MOST_PARTS:
        return {}
    return {f"{name}_{i + 1}": column for i, column in enumerate(rows.T)}


def _is_time(name: str) -> bool:
    return name.rpartition(".")[2].lower() in TIMES
