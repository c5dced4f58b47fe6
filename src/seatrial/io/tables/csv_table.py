# SPDX-License-Identifier: MIT
"""Tables as text: comma, semicolon, tab, bar or spaces between the cells."""

import codecs
import csv
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import islice, takewhile
from pathlib import Path
from typing import TextIO

import numpy as np

from seatrial.io.tables.base import NO_ROWS, Table, no_value, unique_names
from seatrial.io.tables.csv_layout import (
    COMMA_NUMBER,
    COMMENTS,
    MOST_TITLES,
    SPACES,
    given_names,
    header_cells,
    header_line,
    is_comment,
    is_number,
    is_trajectory,
    plain_lines,
    separator,
    without_mark,
)
from seatrial.io.tables.headers import (
    LINES_OF_OPENING,
    JoinedHeader,
    is_whole,
    joined_header,
    layout_of,
)
from seatrial.io.tables.other_texts import refuse_other_text
from seatrial.io.tables.stamps import is_date_time
from seatrial.util.errors import RecordingError
from seatrial.util.files import readable
from seatrial.util.frames import Array

ENCODED = 1 << 16  # [bytes] by which the encoding is found
NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
LONGEST_LINE = 1 << 20  # [characters]
MOST_COMMENTS = 1000  # lines before the header
READ_AHEAD = 24  # columns of numbers that are read at once with those asked for
UNIT_CELL = re.compile(r"[\[(].*[\])]|[A-Za-zµ°%][\w°/^*%.-]{0,7}|-|")


class CsvTable(Table):
    """A text file with a header of one line, or of several that are joined; columns are read on request."""

    joined: JoinedHeader | None = None  # of a header of several rows

    def __init__(self, path: Path) -> None:
        super().__init__(path, path.name)
        self.encoding = self._encoding()
        self._read_columns: dict[str, Array] = {}
        self._count, self._skipped = 0, 0  # rows, once they are read; lines before the first row
        head, rows = self._beginning()
        self.delimiter = separator(head, rows[0] if rows else "")
        cells_of_head = header_cells(head, rows[0] if rows else "", self.delimiter)
        if self.joined is not None:
            cells_of_head = self.joined.cells
        elif all(is_number(cell) or is_date_time(cell) for cell in cells_of_head):
            self._skipped, rows = self._header_at, [head, *rows]
            cells_of_head, remark = given_names(len(cells_of_head), rows)
            self.remarks.append(remark)
        self.names, renamed = unique_names(self.joined.names if self.joined else cells_of_head)
        self.only_poses = is_trajectory(self.names)
        self._header = cells_of_head
        self._no_rows: set[int] = set()  # lines among the rows
        self.remarks += [] if self.joined else renamed
        cells = [self._split(row) for row in rows[:3]]
        self._numeric: list[str] = []
        if cells:
            self._skip_units(cells)
            self._check_width(cells[0])
            pairs = zip(self.names, cells[0], strict=False)
            self._numeric = [name for name, cell in pairs if name and is_number(cell)]

    def _load(self, wanted: Sequence[str]) -> None:
        if not all(name in self._read_columns for name in wanted):
            self._read(wanted)
        if not self._count:
            raise RecordingError(f"{self.path}: has a header {NO_ROWS}")

    def _column(self, name: str, *, strict: bool) -> Array:
        return self._numbers(name)

    def _numbers(self, name: str) -> Array:
        return self._read_columns[name]

    def numbers(self) -> Array:
        """All columns (n, len(names)); NaN where a cell is missing or not a number."""
        return self._read_rows(range(len(self.names)), strict=False)

    def cells(self, name: str) -> Array | list[str]:
        """A column (n,) as numbers, or as text where its first cell is a date and time."""
        i = self.find(name)
        if name not in self._read_columns and name not in self._numeric:
            first = next((row[i] for row, _ in self._rows() if i < len(row) and row[i].strip()), "")
            if is_date_time(first):
                return self._texts(name)
        return np.asarray(self.columns([name])[:, 0])

    def _texts(self, name: str) -> list[str]:
        i = self.find(name)
        found = [self._checked(row, i, line)[i].strip() for row, line in self._rows()]
        self._check_rows(len(found))
        return found

    def place(self, row: int) -> str:
        """The line of a row; of a file with empty lines, as if it had none."""
        return f"{self.path} line {self._skipped + row + 1}"

    @property
    def skipped(self) -> int:
        """Lines before the first row."""
        return self._skipped

    # The beginning of the file #

    def _encoding(self) -> str:
        """UTF-8, else UTF-16 by its mark, else the Western one of Windows, which has a degree sign as one byte."""
        with readable(self.path, RecordingError), self.path.open("rb") as file:
            begin = file.read(ENCODED)
        if begin.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            return "utf-16"
        try:
            # the last character may be cut off
            codecs.getincrementaldecoder("utf-8")().decode(begin)
        except UnicodeDecodeError:
            if NO_TEXT.search(begin):
                raise RecordingError(f"{self.path}: is not a CSV text file") from None
            self.remarks.append("is not UTF-8, and was read as Windows-1252")
            return "cp1252"
        return "utf-8-sig"

    def _beginning(self) -> tuple[str, list[str]]:
        """Header line, and the first rows."""
        lines = self._first_lines()
        refuse_other_text(self.path, lines)
        self.joined = joined_header(self.path, lines)
        at = header_line(lines) if self.joined is None else self.joined.row
        if at is None:
            raise RecordingError(f"{self.path}: is empty; expected a header and rows of numbers")
        notes = sum(1 for _ in takewhile(is_comment, lines[at + 1 :]))
        self._header_at, self._skipped = at, at + 1 + notes
        head = lines[at].strip("\r\n")
        rows = [line for line in lines[self._skipped :] if line.strip()]
        if self.joined is not None:
            return head, rows
        titles = [i for i in range(at) if lines[i].strip() and not is_comment(lines[i])]
        if titles:
            self.remarks.append(f"{len(titles)} lines above the header are no row: left out")
        if at > 0 or without_mark(head).strip():
            head = without_mark(head)
        return head, rows

    def _first_lines(self) -> list[str]:
        """Lines that reach beyond the header."""
        lines: list[str] = []
        with self._opened() as file:
            while len(lines) < MOST_COMMENTS + 3:
                lines.append(file.readline(LONGEST_LINE))
                plain = layout_of(lines[:LINES_OF_OPENING]) is None and (
                    plain_lines(lines) >= MOST_TITLES + 3
                )
                if not lines[-1] or plain or is_whole(lines):
                    break
        return [line for line in lines if line]

    def _skip_units(self, cells: list[list[str]]) -> None:
        """A first row of units is part of the header."""
        if len(cells) < 2 or len(cells[0]) != len(self.names) or not any(map(str.strip, cells[0])):
            return
        units = [cell.strip() for cell in cells[0]]
        if all(UNIT_CELL.fullmatch(unit) for unit in units) and any(map(is_number, cells[1])):
            if any(map(is_number, units)):
                return
            pairs = zip(self.names, units, strict=True)
            self.units = {name: unit.strip("[]()") for name, unit in pairs if unit}
            if self.joined is None:
                self.remarks.append("the line after the header has units, and counts as no row")
            self._skipped += 1
            del cells[0]

    def _check_width(self, row: Sequence[str]) -> None:
        """Refuse a first row with more cells than names."""
        if any(cell.strip() for cell in row[len(self.names) :]):
            raise RecordingError(
                f"{self.place(0)}: {len(row)} cells, expected {len(self.names)}; name every column in the "
                "header, and write a decimal point where numbers have a comma"
            )

    # Rows #

    def _read(self, wanted: Sequence[str]) -> None:
        """Read these columns, and the others with numbers as far as they cost little."""
        able = self._numeric if len(self._numeric) <= READ_AHEAD else []
        more = [*dict.fromkeys([*wanted, *able])]
        for names in (more, [*dict.fromkeys(wanted)]):
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # an empty table raises in `columns`
                    values = np.loadtxt(
                        self.path, delimiter=None if self.delimiter == SPACES else self.delimiter,
                        skiprows=self._skipped, usecols=[self.find(name) for name in names], ndmin=2,
                        encoding=self.encoding, comments=None, quotechar='"',
                    )  # fmt: skip
            except (ValueError, UnicodeDecodeError):
                continue
            self._keep(names, values)
            return
        self._keep(wanted, self._read_rows([self.find(name) for name in wanted], strict=True))

    def _keep(self, names: Sequence[str], values: Array) -> None:
        self._check_rows(len(values))
        self._read_columns |= dict(zip(names, values.T, strict=True))

    def _check_rows(self, count: int) -> None:
        """Refuse a table that has another number of rows each time it is read."""
        self._count = self._count or count
        if count != self._count:
            raise RecordingError(
                f'{self.path}: has {self._count} or {count} rows, as a quote (") is open or cells have line '
                "breaks; write one line for each row"
            )

    def _read_rows(self, index: Sequence[int], *, strict: bool) -> Array:
        """Row by row: accepts empty cells and decimal commas, and names the line of an error.

        Not `strict`: NaN where a cell is missing or not a number.
        """
        commas = set() if self.delimiter == "," else self._have_commas(index)
        rows = [
            [self._cell(row, i, line, comma=i in commas, strict=strict) for i in index]
            for row, line in self._rows()
        ]
        return np.array(rows, dtype=float).reshape(-1, len(index))

    def _have_commas(self, index: Sequence[int]) -> set[int]:
        """Columns whose numbers have a decimal comma, and none a point."""
        commas: set[int] = set()
        points: set[int] = set()
        for row, _ in self._rows():
            for i in index:
                if i < len(row) and COMMA_NUMBER.fullmatch(row[i]):
                    commas.add(i)
                elif i < len(row) and "." in row[i]:
                    points.add(i)
        return commas - points

    def _rows(self) -> Iterator[tuple[list[str], int]]:
        """Cells of every row that is not empty, and its line."""
        with self._opened() as file:
            lines: Iterator[str] = islice(file, self._skipped, None)
            if self.joined is not None and self.joined.layout.ends_blank:
                lines = takewhile(lambda line: line.strip("\r\n\t ,;"), lines)
            if self.delimiter == SPACES:
                for number, line in enumerate(lines, self._skipped + 1):
                    if line.strip() and not self._is_no_row(line.split(), number):
                        yield line.split(), number
                return
            reader = csv.reader(lines, delimiter=self.delimiter)
            for row in reader:
                number = self._skipped + reader.line_num
                if row and not self._is_no_row(row, number):
                    yield row, number

    def _is_no_row(self, row: list[str], line: int) -> bool:
        """Whether a line among the rows is a comment, or the header again, as where a logger was started again."""
        comment = row[0].lstrip().startswith(COMMENTS)
        if not comment and [cell.strip().strip('"') for cell in row] != self._header:
            return False
        if not self._no_rows:
            self.remarks.append("")
            self._remark = len(self.remarks) - 1
        self._no_rows.add(line)
        self.remarks[self._remark] = (
            f"{len(self._no_rows)} lines among the rows are comments or the header again, and count as no row "
            f"(the first is line {min(self._no_rows)})"
        )
        return True

    @contextmanager
    def _opened(self) -> Iterator[TextIO]:
        with (
            readable(self.path, RecordingError), self._errors(),
            self.path.open(encoding=self.encoding, newline="") as file,
        ):  # fmt: skip
            yield file

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except UnicodeDecodeError:
            raise RecordingError(f"{self.path}: is not a CSV text file") from None
        except csv.Error as error:
            raise RecordingError(f"{self.path}: is not a CSV table ({error})") from None

    def _split(self, line: str) -> list[str]:
        if self.delimiter == SPACES:
            return line.split()
        with self._errors():
            return next(csv.reader([line], delimiter=self.delimiter), [])

    def _checked(self, row: list[str], i: int, line: int) -> list[str]:
        if i >= len(row):
            raise RecordingError(
                f"{self.path} line {line}: {len(row)} cells, expected {len(self.names)}; "
                "is the file cut off? Remove the line to use the rest"
            )
        return row

    def _cell(self, row: list[str], i: int, line: int, *, comma: bool, strict: bool) -> float:
        if i >= len(row) and not strict:
            return float("nan")
        text = self._checked(row, i, line)[i]
        try:
            plain = text.replace(",", ".") if comma else text
            return float("nan") if no_value(text) else float(plain)
        except ValueError:
            if not strict:
                return float("nan")
            hint = ": write a decimal point, not a comma" if COMMA_NUMBER.fullmatch(text) else ""
            raise RecordingError(
                f"{self.path} line {line}: column '{self.names[i]}' has '{text[:40]}', "
                f"expected a number{hint}"
            ) from None
