# SPDX-License-Identifier: MIT
"""JSON as a table: an object a line, a list of objects, or an object of lists of one length."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from seatrial.io.tables.base import MOST_NUMBERS, Table, first_line, unique_names
from seatrial.util.errors import RecordingError
from seatrial.util.files import readable
from seatrial.util.frames import Array

JSON = (".jsonl", ".ndjson", ".json")
MOST_BYTES = 1 << 28  # of a file: its objects take ten times as much memory
DEEPEST = 16  # objects within objects
MOST_PARTS = 32  # of a list within a row
MOST_COLUMNS = 10_000  # a file with more is hostile
LONGEST_CELL = 256  # characters
LARGEST = 1e300  # a larger number is none


class JsonTable(Table):
    """Objects within a row as dotted names, lists as name[0]; a value that a row lacks is an empty cell."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, path.name)
        with readable(path, RecordingError):
            if path.stat().st_size > MOST_BYTES:
                raise RecordingError(
                    f"{path}: is larger than {MOST_BYTES >> 20} MB; convert it to a CSV table"
                )
            content = path.read_bytes()
        columns: dict[str, list[Any]] = {}
        rows = self._rows(content)
        for i, row in enumerate(rows):
            for name, value in dict(
                _cells(row, "", 0)
            ).items():  # {"a": {"b": 1}, "a.b": 2}: the last
                column = columns.setdefault(name, [])
                column += [None] * (i - len(column)) + [value]
            if len(columns) > MOST_COLUMNS or len(columns) * (i + 1) > MOST_NUMBERS:
                raise RecordingError(f"{path}: has more numbers than seatrial reads at once")
        if not columns:
            raise RecordingError(f"{path}: has no rows of numbers: expected an object for each row")
        self.names, self.remarks = unique_names(list(columns))
        filled = (c + [None] * (len(rows) - len(c)) for c in columns.values())
        self._columns: dict[str, list[Any]] = dict(zip(self.names, filled, strict=True))

    def _texts(self, name: str) -> list[str] | None:
        column = self._columns[name]
        if not any(isinstance(value, str) for value in column):
            return None
        return ["" if value is None else str(value)[:LONGEST_CELL] for value in column]

    def _numbers(self, name: str) -> Array:
        return np.array(self._columns[name], dtype=float)

    def _rows(self, content: bytes) -> list[Any]:
        """The rows, whatever the form. Raises RecordingError."""
        try:
            whole = json.loads(content)
        except (ValueError, RecursionError):
            return self._lines(content)
        if isinstance(whole, dict):
            lists = {k: v for k, v in whole.items() if isinstance(v, list) and len(v) > 1}
            length = max(map(len, lists.values()), default=0)
            lists = {k: v for k, v in lists.items() if len(v) == length}
            return [dict(zip(lists, row, strict=True)) for row in zip(*lists.values(), strict=True)]
        return whole if isinstance(whole, list) else []

    def _lines(self, content: bytes) -> list[Any]:
        rows = []
        for number, line in enumerate(content.splitlines(), 1):
            try:
                rows += [json.loads(line)] if line.strip() else []
            except (ValueError, RecursionError) as error:
                raise RecordingError(
                    f"{self.path} line {number}: is not JSON ({first_line(error)}); is the file cut off? Remove "
                    "the line to use the rest"
                ) from None
        return rows


def _cells(value: object, name: str, depth: int) -> Iterator[tuple[str, Any]]:
    """Numbers, truths and text of a row, by name."""
    if isinstance(value, dict) and depth < DEEPEST:
        for key, inner in value.items():
            yield from _cells(inner, f"{name}.{key}" if name else str(key), depth + 1)
    elif isinstance(value, list) and len(value) <= MOST_PARTS and depth < DEEPEST:
        for i, inner in enumerate(value):
            yield from _cells(inner, f"{name}[{i}]", depth + 1)
    elif name and isinstance(value, str):
        yield name, value
    elif name and isinstance(value, int | float):
        yield name, float(value) if abs(value) < LARGEST else np.nan
