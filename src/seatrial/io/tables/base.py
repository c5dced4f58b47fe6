# SPDX-License-Identifier: MIT
"""A table of a recording: columns of numbers and stamps by name, whatever the file's format."""

import difflib
import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.schema import Column
from seatrial.io.tables.stamps import (
    TO_NANOSECONDS,
    UNPADDED,
    from_date_times,
    from_numbers,
    from_two_columns,
    from_unpadded,
    is_date_time,
    is_unpadded,
    refuse_empty,
    spread_evenly,
)
from seatrial.util.errors import RecordingError, printable
from seatrial.util.frames import Array, Mask, Stamps

Rows = NDArray[np.intp]
MOST_NUMBERS = 1 << 27  # of a file that are read at once: 1 GB
LONGEST_REASON = 120  # characters of a library's error
LISTED_COLUMNS = 20  # in an error message
NO_ROWS = "but no rows; record while the boat is driven"
NO_VALUE = ("", "na", "n/a", "#n/a", "null", "none")  # of a cell, beside nan
NO_DIGITS = re.compile(r"[-.:]+")  # -, --.-- of QGroundControl
NAN_OF_WINDOWS = re.compile(r"-?1\.#[A-Z]+0*")  # -1.#IND00, 1.#QNAN, 1.#INF


def no_value(text: str) -> bool:
    """Whether a cell says that it has no value."""
    cell = text.strip()
    if cell.lower() in NO_VALUE:
        return True
    return any(p.fullmatch(cell) is not None for p in (NO_DIGITS, NAN_OF_WINDOWS))


class Table(ABC):
    """A table with named columns, which are read on request. Constructors raise RecordingError."""

    EMPTY_STAMP: ClassVar[int] = -(1 << 63)  # of `typed_stamps`

    path: Path  # the file; of a table in memory its name
    in_file: ClassVar[bool] = True
    only_poses: bool = False  # whether no column can be a command
    captured: ClassVar[bool] = False  # whether it is a body of a motion capture
    right_handed: ClassVar[bool] = False  # whether its axes are, by the system that wrote it
    name: str  # of the table: the file's, or the variable's in a .mat
    names: list[str]  # of the columns; of several with one name the second ends in _2
    units: dict[str, str]  # by column, where the file states them
    remarks: list[str]  # renamed columns, rows left out

    def __init__(self, path: Path, name: str) -> None:
        self.path, self.name, self.units, self.remarks = path, name, {}, []

    def columns(self, wanted: Sequence[str]) -> Array:
        """The wanted columns (n, len(wanted)); an empty cell is NaN. Raises RecordingError."""
        for name in wanted:
            self.find(name)
        self._load(wanted)
        return np.column_stack([self._column(name, strict=True) for name in wanted])

    def cells(self, name: str) -> Array | list[str]:
        """A column (n,) as numbers, or as text where it holds dates and times."""
        texts = self.texts(name)
        if texts is not None and is_date_time(next((text for text in texts if text), "")):
            return texts
        return np.asarray(self.columns([name])[:, 0])

    def numbers(self) -> Array:
        """All columns (n, len(names)); NaN where a cell is missing or not a number."""
        self._load(self.names)
        return np.column_stack([self._column(name, strict=False) for name in self.names])

    def _column(self, name: str, *, strict: bool) -> Array:
        """A loaded column (n,) as numbers, times in seconds; not `strict`: NaN where a cell is not a number."""
        stamps = self.typed_stamps(name)
        if stamps is not None:
            return np.where(stamps == self.EMPTY_STAMP, np.nan, stamps * 1e-9)
        texts = self._texts(name)
        return self._numbers(name) if texts is None else self._parsed(name, texts, strict=strict)

    def _load(self, wanted: Sequence[str]) -> None:  # noqa: B027, most have all columns
        """Read columns that are there, of a file that is read on request. Raises RecordingError."""

    @abstractmethod
    def _numbers(self, name: str) -> Array:
        """A loaded column (n,) that has numbers."""

    def texts(self, name: str) -> list[str] | None:
        """A column (n,) as it is written; None where it has numbers. Raises RecordingError where there is none."""
        self.find(name)
        return self._texts(name)

    @abstractmethod
    def _texts(self, name: str) -> list[str] | None:
        """The same of a column that is there."""

    def typed_stamps(self, name: str) -> Stamps | None:
        """A column (n,) that the file types as times [ns], `EMPTY_STAMP` in empty cells."""
        return None

    def place(self, row: int) -> str:
        """A row as an error names it."""
        return f"{self.path} row {row + 1}"

    def _parsed(self, name: str, texts: Sequence[str], *, strict: bool) -> Array:
        """Cells (n,) of text as numbers; NaN: empty, or no number and not `strict`. Raises RecordingError."""
        found = np.full(len(texts), np.nan)
        for row, text in enumerate(texts):
            try:
                found[row] = np.nan if no_value(text) else float(text)
            except ValueError:
                if strict:
                    raise RecordingError(
                        f"{self.place(row)}: column '{name}' has '{text[:40]}', expected a number"
                    ) from None
        return found

    def stamps(self, column: Column, rows: Mask | None = None) -> Stamps:
        """Stamps [ns] of the rows (all of them by default). Raises RecordingError.

        Numbers in the column's unit, seconds with `nanoseconds` in another column, or dates and times. Stamps
        that were cut off are put on an even clock.
        """
        stamps, text = self.evened(column, rows)
        if text and text not in self.remarks:
            self.remarks.append(text)
        return stamps

    def evened(self, column: Column, rows: Mask | None = None) -> tuple[Stamps, str]:
        """The same without a remark on the table: the column may be none of its stamps; and the remark."""
        return spread_evenly(self._read_stamps(column, rows))

    def _read_stamps(self, column: Column, rows: Mask | None) -> Stamps:
        """Stamps as they are written."""
        if column.unit is not None and column.unit not in (*TO_NANOSECONDS, UNPADDED):
            raise RecordingError(
                f"{self.path}: stamp column '{column.column}' has unit '{column.unit}'; use s, ms, us or ns"
            )
        index = None if rows is None else np.flatnonzero(rows)

        def place(i: int) -> str:
            return self.place(i if index is None else int(index[i]))

        if column.nanoseconds:
            parts = self.columns([column.column, column.nanoseconds])
            parts = parts if index is None else parts[index]
            return from_two_columns(parts[:, 0], parts[:, 1], column, place)
        if column.unit == UNPADDED:
            return from_unpadded(self._written(column.column, index), column, place)
        typed = self.typed_stamps(column.column)
        if typed is not None:
            typed = typed if index is None else typed[index]
            refuse_empty(typed == self.EMPTY_STAMP, column.column, place)
            return typed
        cells = self.cells(column.column)
        if isinstance(cells, list):
            chosen = cells if index is None else [cells[i] for i in index.tolist()]
            return from_date_times(chosen, column.column, place)
        stamps = from_numbers(cells if index is None else cells[index], column, place)
        if column.unit in (None, "s") and np.any(np.diff(stamps) < 0):
            self._refuse_unpadded(column.column, index)
        return stamps

    def find(self, name: str) -> int:
        """Index of a column. Raises RecordingError."""
        if name not in self.names:
            near = difflib.get_close_matches(name, self.names, n=1)
            hint = f"; did you mean '{near[0]}'?" if near else "."
            shown = ", ".join(self.names[:LISTED_COLUMNS])
            raise RecordingError(f"{self.path}: no column '{name}'{hint} It has: {shown}")
        return self.names.index(name)

    def _written(self, name: str, index: Rows | None) -> list[str]:
        texts = self.texts(name)
        if texts is None:
            raise RecordingError(
                f"{self.path}: stamp column '{name}' has numbers, and unit {UNPADDED} is for text; use s"
            )
        return texts if index is None else [texts[i] for i in index.tolist()]

    def _refuse_unpadded(self, name: str, index: Rows | None) -> None:
        """Raise RecordingError where the digits after the point are nanoseconds without zeros."""
        texts = self.texts(name)
        if texts is None:
            return
        texts = texts if index is None else [texts[i] for i in index.tolist()]
        if is_unpadded(texts):
            jumps = int((np.diff([float(text) for text in texts]) < 0).sum())
            raise RecordingError(
                f"{self.path}: stamps in column '{name}' jump back {jumps} times as seconds, and rise evenly "
                f"as nanoseconds without leading zeros (12.45 for 12.000000045); write unit: {UNPADDED}"
            )


def unique_names(found: Sequence[str]) -> tuple[list[str], list[str]]:
    """Names of columns, each once, and remarks on those that are renamed."""
    names: list[str] = []
    remarks: list[str] = []
    taken: set[str] = set()
    numbers: dict[str, int] = {}  # the last one of a name
    for name in found:
        number, unique = 1, name
        while name and unique in taken:
            number = numbers[name] = max(number, numbers.get(name, 1)) + 1
            unique = f"{name}_{number}"
        if unique != name:
            remarks.append(
                f"column '{name}' is in the header {number} times; number {number} is read as '{unique}'"
            )
        taken.add(unique)
        names.append(unique)
    return names, remarks


def first_line(error: Exception) -> str:
    """What a library's error says, in one short printable line."""
    line = next(iter(str(error).splitlines()), "") or type(error).__name__
    return printable(line, keep="")[:LONGEST_REASON]
