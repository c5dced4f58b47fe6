# SPDX-License-Identifier: MIT
"""A table, or a folder of tables, that another program writes: rows as they are added."""

import re
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from seatrial.boat.schema import PoseSource
from seatrial.boat.vehicle import Vehicle
from seatrial.io.signals import Request, of_columns
from seatrial.io.table import Table
from seatrial.io.tables.csv_layout import COMMENTS
from seatrial.io.tables.csv_table import LONGEST_LINE, CsvTable
from seatrial.io.tables.signals import TableSignals, stamp_column
from seatrial.poolside.sources.conversion import Conversion
from seatrial.poolside.sources.source import EventSource, SourceEvent
from seatrial.util.errors import FileError, LiveError, RecordingError, SeatrialError
from seatrial.util.files import readable
from seatrial.util.frames import Array, Mask, Stamps

POLL = 0.05  # [s]
TEXT_TABLES = (".csv", ".txt", ".tsv")
BLOCK = 1 << 20  # [bytes] that are read at once
BEGUN = 3  # lines, without comments, that show a header, its units, and a row
MARKS = tuple(mark.encode() for mark in COMMENTS)
Line = tuple[int, bytes]  # its number in the table, from 1; its text


class GrowingTable:
    """A text table: its beginning, and the lines that are added."""

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self._copy = path, folder / "rows.csv"
        self._read, self._count, self._rest = 0, 0, b""  # bytes and lines, a begun line
        self.more = False  # whether the last block was a whole one
        self._head: list[bytes] = []  # lines before the first row
        self._head_again: set[bytes] = set()
        self._waiting: list[Line] = []  # lines before the head is known
        self.requests: list[Request] = []

    def rows(self) -> list[Line]:
        """Rows since the last call, once the table has begun. Raises FileError, RecordingError."""
        lines = self._lines()
        if not self._head:
            lines = self._begun(lines)
        return [line for line in lines if not self._is_no_row(line[1])]

    def table(self, rows: Sequence[Line]) -> CsvTable:
        """These rows below the table's own header. Raises RecordingError."""
        lines = [*self._head, *(text for _, text in rows), b""]
        self._copy.write_bytes(b"\n".join(lines))
        return CsvTable(self._copy)

    def plain(self, error: SeatrialError, line: int | None = None) -> str:
        """An error about the copied rows, as one about the table; line: that of the only row."""
        place = self.path.name if line is None else f"{self.path.name} line {line}"
        copied = re.escape(str(self._copy)) + ("" if line is None else r"(?: line \d+)?")
        return re.sub(copied, lambda _: place, str(error))

    def _begun(self, lines: list[Line]) -> list[Line]:
        """The rows of lines that complete the beginning; none: it is not complete."""
        self._waiting += lines
        if sum(not text.lstrip().startswith(MARKS) for _, text in self._waiting) < BEGUN:
            return []
        lines, self._waiting = self._waiting, []
        try:
            table = self.table(lines)
            for one in self.requests:
                for name in (*one.paths, stamp_column(one).column):
                    table.find(name)
        except RecordingError as error:
            raise RecordingError(self.plain(error)) from None
        self._head = [text for _, text in lines[: table.skipped]]
        self._head_again = {text.strip() for text in self._head}
        return lines[table.skipped :]

    def _is_no_row(self, text: bytes) -> bool:
        """Whether a line is a comment, or of the header again, as where a logger was started again."""
        plain = text.strip()
        return plain.startswith(MARKS) or plain in self._head_again

    def _lines(self) -> list[Line]:
        """Whole lines that were added, without empty ones."""
        with readable(self.path), self.path.open("rb") as file:
            if file.seek(0, 2) < self._read:
                raise FileError(f"{self.path}: became shorter; a table that is followed only grows")
            file.seek(self._read)
            block = file.read(BLOCK)
        self._read += len(block)
        self.more = len(block) == BLOCK
        *whole, self._rest = (self._rest + block).split(b"\n")
        if len(self._rest) > LONGEST_LINE:
            raise RecordingError(f"{self.path}: a line of more than {LONGEST_LINE} bytes is no row")
        numbered = [*enumerate(whole, self._count + 1)]
        self._count += len(whole)
        return [line for line in numbered if line[1].strip()]


class FollowSource(EventSource):
    """Rows of text tables while they grow, from their beginning. It ends when it is closed.

    A table that is not there yet is waited for. Iteration raises SeatrialError where a table lacks a column, or
    becomes shorter.
    """

    def __init__(self, name: str, path: Path, vehicle: Vehicle) -> None:
        if not path.is_dir() and path.suffix.lower() not in TEXT_TABLES:
            raise LiveError(_not_followed(path))
        if not path.parent.is_dir():
            raise FileError(f"{path}: there is no folder {path.parent}")
        super().__init__(name)
        self._path, self._vehicle = path, vehicle
        self._tables: list[GrowingTable] = []
        self._conversion: Conversion | None = None
        self._wait = ""  # what it waits for

    def __iter__(self) -> Iterator[SourceEvent]:
        """See `EventSource`."""
        with TemporaryDirectory(prefix="seatrial-") as folder:
            open_still = True
            while open_still:
                open_still = not self._closed.wait(POLL)
                if self._conversion is None:
                    self._begin(Path(folder))
                if self._conversion is not None:
                    yield from self._added(self._conversion)

    @property
    def problems(self) -> tuple[str, ...]:
        """See `EventSource`."""
        mistakes = str(self._conversion.mistakes) if self._conversion else ""
        return tuple(text for text in (self._wait, mistakes) if text)

    def _begin(self, copies: Path) -> None:
        """Find the tables of the vehicle file's signals, once they are there."""
        try:
            conversion = Conversion(self._vehicle, TableSignals(self._path, self._vehicle))
        except SeatrialError as error:
            self._wait = f"waiting: {error}"
            return
        self._wait = ""
        places = dict.fromkeys(one.place for one in conversion.wanted)
        for number, place in enumerate(places):
            folder = copies / str(number)
            folder.mkdir()
            table = GrowingTable(self._path / place if self._path.is_dir() else self._path, folder)
            table.requests = [one for one in conversion.wanted if one.place == place]
            self._tables.append(table)
        self._conversion = conversion

    def _added(self, conversion: Conversion) -> Iterator[SourceEvent]:
        """Events of all that is there, a block of each table at a time, whether its rows can be used or not."""
        more = True
        while more:
            parts = []
            for table in self._tables:
                if rows := table.rows():
                    parts += self._parts(table, rows, conversion)
            if parts:
                yield from conversion.events(parts, time.time_ns())
            more = any(table.more for table in self._tables)

    def _parts(
        self, table: GrowingTable, rows: Sequence[Line], conversion: Conversion
    ) -> list[tuple[Request, Stamps, Array]]:
        """Rows by request. Where some can't be used, each half by itself: a bad row costs few tables."""
        mixed = len({one.role for one in table.requests}) > 1
        try:
            known = table.table(rows)
            return [_rows_of(known, one, mixed=mixed) for one in table.requests]
        except RecordingError as error:
            if len(rows) > 1:
                half = len(rows) // 2
                parts = self._parts(table, rows[:half], conversion)
                return parts + self._parts(table, rows[half:], conversion)
            conversion.mistakes.total += 1
            conversion.mistakes.add(table.plain(error, rows[0][0]))
            return []


def _not_followed(path: Path) -> str:
    """Why a file can't be followed, and what to do."""
    tables = ", ".join(TEXT_TABLES)
    return f"{path}: expected a folder, a table as text ({tables}), or a bag (.mcap, .db3, .bag)"


def _rows_of(table: Table, request: Request, *, mixed: bool) -> tuple[Request, Stamps, Array]:
    """Stamps and raw values of a request; of a table of several signals the rows that have any of its numbers."""
    spec = request.spec
    valid = spec.valid if request.role == "poses" and isinstance(spec, PoseSource) else None
    raw = table.columns([*request.paths, *([valid] if valid else [])])
    n = len(request.paths)
    given: Mask = np.ones(len(raw), dtype=bool)
    if mixed:
        given = np.asarray(~np.isnan(raw[:, :n]).all(axis=1))
    if valid:
        given = np.asarray(given & (raw[:, n] > 0.5))
    stamps = table.stamps(stamp_column(request), given)
    return request, stamps, of_columns(raw[given, :n], request.columns)
