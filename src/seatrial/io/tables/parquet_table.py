# SPDX-License-Identifier: MIT
"""Parquet files as tables, by pyarrow."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from seatrial.io.tables.base import MOST_NUMBERS, NO_ROWS, Table, first_line
from seatrial.io.tables.stamps import TO_NANOSECONDS
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps

if TYPE_CHECKING:
    import pyarrow as pa

INSTALL = "pip install 'seatrial[parquet]'"
BATCH = 65_536  # rows at a time
DEEPEST = 16  # nested structs
MOST_COLUMNS = 10_000
LONGEST_NAMES = 1 << 24  # [bytes] of the file's own text
MOST_CELL_TEXT = 256  # characters of a cell that may be a date


class ParquetTable(Table):
    """A Parquet file; columns are read on request, structs as dotted names."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, path.name)
        os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")  # reserves no address space
        try:
            import pyarrow.parquet as pq
        except ImportError:
            raise RecordingError(f"{path}: Parquet needs pyarrow: {INSTALL}") from None
        with self._errors():
            self._file = pq.ParquetFile(
                path,
                thrift_string_size_limit=LONGEST_NAMES,
                thrift_container_size_limit=LONGEST_NAMES,
            )
            self._rows = int(self._file.metadata.num_rows)
            self._types = dict(_leaves(self._file.schema_arrow))
        self.names = list(self._types)
        if not self.names:
            raise RecordingError(f"{path}: no column of numbers, times or text")
        self._read_columns: dict[str, Array | Stamps | list[str]] = {}

    def _load(self, wanted: Sequence[str]) -> None:
        self._read(wanted)
        if self._rows == 0:
            raise RecordingError(f"{self.path}: has columns {NO_ROWS}")

    def _texts(self, name: str) -> list[str] | None:
        self._read([name])
        found = self._read_columns[name]
        return found if isinstance(found, list) else None

    def typed_stamps(self, name: str) -> Stamps | None:
        """A column (n,) of times [ns], `EMPTY_STAMP` in empty cells; None of another type."""
        self.find(name)
        if _time_unit(self._types[name]) is None:
            return None
        self._read([name])
        return np.asarray(self._read_columns[name], dtype=np.int64)

    def _numbers(self, name: str) -> Array:
        return np.asarray(self._read_columns[name], dtype=float)

    def _read(self, wanted: Sequence[str]) -> None:
        """Read the columns that are not read yet in batches, with the rows counted."""
        names = [name for name in wanted if name not in self._read_columns]
        if not names:
            return
        if self._rows * len(names) > MOST_NUMBERS:
            raise RecordingError(
                f"{self.path}: {self._rows} rows of {len(names)} columns are more than seatrial reads at once; "
                "keep the columns of the boat, or cut the file"
            )
        parts: dict[str, list[Any]] = {name: [] for name in names}
        rows = 0
        with self._errors():
            for batch in self._file.iter_batches(BATCH, columns=names, use_threads=False):
                rows += batch.num_rows
                if rows > self._rows:
                    break
                for name in names:
                    parts[name].append(_values(_column(batch, name), self._types[name]))
        if rows != self._rows:
            raise RecordingError(f"{self.path}: is damaged: it has {rows} rows, not {self._rows}")
        for name, values in parts.items():
            if values and isinstance(values[0], list):
                self._read_columns[name] = [text for part in values for text in part]
            else:
                self._read_columns[name] = np.concatenate(values) if values else np.zeros(0)

    @contextmanager
    def _errors(self) -> Iterator[None]:
        import pyarrow as pa

        try:
            yield
        except MemoryError:
            raise RecordingError(f"{self.path}: needs more memory than there is") from None
        except OSError as error:
            if error.strerror is None:  # of a damaged head
                raise RecordingError(self._damaged(error)) from None
            raise RecordingError(f"{self.path}: can't be read ({error.strerror})") from None
        except (
            pa.ArrowException, ValueError, KeyError, IndexError, TypeError, OverflowError,
        ) as error:  # fmt: skip
            raise RecordingError(self._damaged(error)) from None

    def _damaged(self, error: Exception) -> str:
        return f"{self.path}: is not a Parquet file, or damaged ({first_line(error)})"


def _leaves(schema: "pa.Schema") -> Iterator[tuple[str, "pa.DataType"]]:
    """Dotted names and types of columns that may be read."""
    import pyarrow as pa

    stack = [(field.name, field.type, 0) for field in reversed(list(schema))]
    count = 0
    while stack:
        name, kind, depth = stack.pop()
        count += 1
        if count > MOST_COLUMNS:
            raise ValueError(f"more than {MOST_COLUMNS} columns")
        if pa.types.is_struct(kind):
            if depth < DEEPEST:
                inner = [kind.field(i) for i in range(kind.num_fields)]
                stack += [(f"{name}.{f.name}", f.type, depth + 1) for f in reversed(inner)]
        elif _is_number(kind) or _time_unit(kind) or _is_text(kind):
            yield name, kind


def _is_number(kind: "pa.DataType") -> bool:
    import pyarrow as pa

    tests = (pa.types.is_integer, pa.types.is_floating, pa.types.is_boolean, pa.types.is_decimal)
    return any(test(kind) for test in tests)


def _is_text(kind: "pa.DataType") -> bool:
    import pyarrow as pa

    inner = kind.value_type if pa.types.is_dictionary(kind) else kind
    return bool(pa.types.is_string(inner) or pa.types.is_large_string(inner))


def _time_unit(kind: "pa.DataType") -> str | None:
    import pyarrow as pa

    timed = pa.types.is_timestamp(kind) or pa.types.is_time(kind) or pa.types.is_duration(kind)
    return str(kind.unit) if timed else None


def _column(batch: "pa.RecordBatch", name: str) -> "pa.Array":
    """A column of a batch by its dotted name."""
    import pyarrow.compute as pc

    for i, field in enumerate(batch.schema):
        if name == field.name:
            return batch.column(i)
    for i, field in enumerate(batch.schema):
        if name.startswith(f"{field.name}."):
            return pc.struct_field(batch.column(i), name[len(field.name) + 1 :].split("."))
    raise KeyError(name)


def _values(column: "pa.Array", kind: "pa.DataType") -> Array | Stamps | list[str]:
    """Numbers with NaN, times [ns], or text."""
    import pyarrow as pa

    unit = _time_unit(kind)
    if unit:
        width = pa.int32() if kind.bit_width == 32 else pa.int64()
        whole = column.view(width).cast(pa.int64())
        given = np.asarray(column.is_valid().to_numpy(zero_copy_only=False))
        raw = whole.fill_null(0).to_numpy(zero_copy_only=False)
        scale = int(TO_NANOSECONDS[unit])
        most = np.iinfo(np.int64).max // scale
        if len(raw) and np.abs(raw // 2).max() > most // 2:
            raise OverflowError("a time is out of range")
        return np.where(given, raw * scale, Table.EMPTY_STAMP)
    if _is_text(kind):
        text = column.cast(pa.string()) if pa.types.is_dictionary(kind) else column
        return [(value or "")[:MOST_CELL_TEXT] for value in text.to_pylist()]
    if pa.types.is_boolean(kind):
        column = column.cast(pa.int8())
    numbers = column.cast(pa.float64(), safe=False)
    return np.asarray(numbers.to_numpy(zero_copy_only=False), dtype=float)
