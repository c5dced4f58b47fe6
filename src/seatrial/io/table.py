# SPDX-License-Identifier: MIT
"""Numbers from a CSV table, by column name."""

import csv
import difflib
import re
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from seatrial.boat.schema import TO_SI, Column
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

ANGLE_UNITS = ("rad", "deg")
LENGTH_UNITS = ("m", "cm", "mm")
TO_NANOSECONDS = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}
MOST_NANOSECONDS = 9e18  # [ns] below the largest 64-bit integer


class Table:
    """A CSV file with a header line; columns are read on request."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with path.open(encoding="utf-8-sig", newline="") as file:
                first, second = file.readline(1 << 20), file.readline(1 << 20)
        except OSError as error:
            raise RecordingError(f"{path}: can't be read ({error.strerror})") from None
        except UnicodeDecodeError:
            raise RecordingError(f"{path}: is not a CSV text file") from None
        if not first.strip():
            raise RecordingError(f"{path}: is empty; expected a header line and rows of numbers")
        if first.startswith(("seatrial:", "# Proposed by", "%YAML")):
            raise RecordingError(
                f"{path}: is a vehicle or model file, not a recording; give it with --vehicle, or first"
            )
        self.delimiter = max(",;\t", key=first.count)
        self.names = [name.strip().strip('"') for name in first.strip().split(self.delimiter)]
        self._check_width(second)

    def _check_width(self, line: str) -> None:
        """Refuse a first row with more cells than names."""
        try:
            row = next(csv.reader([line], delimiter=self.delimiter), [])
        except csv.Error as error:
            raise RecordingError(f"{self.path}: is not a CSV table ({error})") from None
        if any(cell.strip() for cell in row[len(self.names) :]):
            raise RecordingError(
                f"{self.path} line 2: {len(row)} cells, expected {len(self.names)}; name every column in the "
                "header, and write a decimal point where numbers have a comma"
            )

    def columns(self, wanted: Sequence[str]) -> Array:
        """The wanted columns (n, len(wanted)); an empty cell is NaN."""
        index = [self._find(name) for name in wanted]
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # an empty table raises below
                values = np.loadtxt(
                    self.path, delimiter=self.delimiter, skiprows=1, usecols=index, ndmin=2,
                    encoding="utf-8-sig", comments=None,
                )  # fmt: skip
        except (ValueError, UnicodeDecodeError):
            values = self._read_rows(index)
        if len(values) == 0:
            raise RecordingError(
                f"{self.path}: has a header but no rows; was anything recorded while the boat was driven?"
            )
        return values

    def _find(self, name: str) -> int:
        if self.names.count(name) > 1:
            raise RecordingError(f"{self.path}: column '{name}' is twice in the header")
        if name not in self.names:
            near = difflib.get_close_matches(name, self.names, n=1)
            hint = f"; did you mean '{near[0]}'?" if near else "."
            shown = ", ".join(self.names[:20])
            raise RecordingError(f"{self.path}: no column '{name}'{hint} It has: {shown}")
        return self.names.index(name)

    def _read_rows(self, index: Sequence[int]) -> Array:
        """Row by row: accepts empty cells, and names the line of an error."""
        rows: list[list[float]] = []
        try:
            with self.path.open(encoding="utf-8-sig", newline="") as file:
                reader = csv.reader(file, delimiter=self.delimiter)
                next(reader)
                for row in reader:
                    if row:
                        rows.append([self._cell(row, i, reader.line_num) for i in index])
        except UnicodeDecodeError:
            raise RecordingError(f"{self.path}: is not a CSV text file") from None
        except csv.Error as error:
            raise RecordingError(f"{self.path}: is not a CSV table ({error})") from None
        return np.array(rows, dtype=float).reshape(-1, len(index))

    def _cell(self, row: Sequence[str], i: int, line: int) -> float:
        if i >= len(row):
            raise RecordingError(
                f"{self.path} line {line}: {len(row)} cells, expected {len(self.names)}; "
                "is the file cut off? Remove the line to use the rest"
            )
        try:
            return float(row[i]) if row[i].strip() else float("nan")
        except ValueError:
            comma = re.fullmatch(r"\s*[-+]?\d+,\d+\s*", row[i]) is not None
            hint = ": write a decimal point, not a comma" if comma else ""
            raise RecordingError(
                f"{self.path} line {line}: column '{self.names[i]}' has '{row[i][:40]}', "
                f"expected a number{hint}"
            ) from None


def checked_unit(column: Column, where: str) -> None:
    """Raise RecordingError where a command has a unit of time."""
    if column.unit is not None and column.unit not in TO_SI:
        raise RecordingError(f"{where} has unit '{column.unit}'; use {', '.join(TO_SI)}")


def scaled(raw: Array, column: Column) -> Array:
    """value = sign (raw - offset) / scale, in SI."""
    unit = TO_SI.get(column.unit or "-", 1.0)
    with np.errstate(over="ignore", invalid="ignore"):  # NaN is handled later
        return np.asarray(column.sign * (raw - column.offset) / column.scale * unit)


def nanoseconds(
    raw: Array, column: Column, path: Path
) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Stamps as integer nanoseconds."""
    if not np.isfinite(raw).all():
        row = int(np.flatnonzero(~np.isfinite(raw))[0])
        raise RecordingError(f"{path} line {row + 2}: column '{column.column}' has no stamp")
    if column.unit is not None and column.unit not in TO_NANOSECONDS:
        raise RecordingError(
            f"{path}: stamp column '{column.column}' has unit '{column.unit}'; use s, ms, us or ns"
        )
    with np.errstate(over="ignore"):
        stamps = (
            column.sign * (raw - column.offset) / column.scale * TO_NANOSECONDS[column.unit or "s"]
        )
    if np.abs(stamps).max() > MOST_NANOSECONDS:
        raise RecordingError(
            f"{path}: stamp column '{column.column}' reaches {raw.max():g} {column.unit or 's'}; "
            "is its unit ms, us or ns? Name it in the vehicle file"
        )
    return np.rint(stamps).astype(np.int64)
