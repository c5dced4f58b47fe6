# SPDX-License-Identifier: MIT
"""Signals of tables: one table, or a folder with one table per signal."""

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from seatrial.boat.schema import Column, PoseSource, as_column
from seatrial.boat.vehicle import Vehicle
from seatrial.io.signals import (
    Request,
    Rows,
    Signals,
    Spec,
    given_rows,
    of_columns,
    scaled,
    shared_places,
)
from seatrial.io.table import Table, open_tables
from seatrial.io.tables.base import LISTED_COLUMNS
from seatrial.recording.timing import Clock, describe, regular_period
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.frames import Array, Mask, Stamps
from seatrial.util.progress import over

POSE_FILE = "poses.csv"
COMMAND_FILE = "commands.csv"
# of the rows with a command, below which have all of them where each is logged on change
ON_CHANGE_WHOLE = 0.5
IN_TURN = 1.5  # times as many rows as one channel has, above which channels are written in turn


class TableSignals(Signals):
    """Tables of a recording: a file, a folder of them, or one in memory. Raises RecordingError, FileError."""

    def __init__(self, recording: Path | Table, vehicle: Vehicle) -> None:
        given = recording if isinstance(recording, Table) else None
        self.path = recording.path if isinstance(recording, Table) else recording
        self._source = vehicle.source
        self._folder = given is None and self.path.is_dir()
        self._tables: dict[str, Table] = {}  # of a folder as they are asked for
        if not self._folder:
            self._tables = open_tables(self.path) if given is None else {given.name: given}
        self.files: list[Path] = []
        self.remarks: list[str] = []

    def place(self, column: Column, spec: Spec, where: str) -> str:
        """Name of the column's table."""
        pose = isinstance(spec, PoseSource)
        if not self._folder:
            name = column.file or spec.file
            return name if name in self._tables else next(iter(self._tables))
        name = column.file or spec.file or (POSE_FILE if pose else COMMAND_FILE)
        if name not in self._tables:
            self._open(name, "pose" if pose else "commands")
        return name

    def _open(self, name: str, key: str) -> None:
        """Open a table of the folder, `FILE` or `FILE:TABLE`."""
        file = self.path / name.partition(":")[0]
        if not file.is_file():
            raise FileError(f"{file}: no such file; name it in the vehicle file under {key}: file")
        found = open_tables(self.path, only={file.name})
        whole = {f"{file.name}:{table.name}": table for table in found.values()}
        if name not in whole | found:
            raise FileError(f"{file}: no table {name}; there are {', '.join(found)}")
        self._tables[name] = (whole | found)[name]

    def path_of(self, column: Column) -> str:
        """The column's name."""
        return column.column

    def read(self, requests: Sequence[Request]) -> list[Rows]:
        """The rows of each request."""
        shared = shared_places(requests)
        used = [self._tables[one.place] for one in requests]
        self.files = list(dict.fromkeys(table.path for table in used if table.in_file))
        found = [self._read(one, mixed=one.place in shared) for one in over(requests)]
        self.remarks = [r for table in self._tables.values() for r in table.remarks]
        return found

    def _read(self, request: Request, *, mixed: bool) -> Rows:
        """Rows of one request; in a table of several signals those that have any of its numbers."""
        table = self._tables[request.place]
        stamp = stamp_column(request)
        key = "pose" if isinstance(request.spec, PoseSource) else "commands"
        self._check_named(stamp, f"{self._source}: {key}: stamp", table)
        for column, where in zip(request.columns, request.wheres, strict=True):
            self._check_named(column, where, table)
        valid = None
        if request.role == "poses" and isinstance(request.spec, PoseSource):
            valid = request.spec.valid
        raw = table.columns([*request.paths, *([valid] if valid else [])])
        n = len(request.paths)
        given: Mask = np.ones(len(raw), dtype=bool)
        if mixed:
            given = given_rows(raw[:, :n])
            raw = raw[given]
        if len(raw) == 0:
            what = "a pose" if request.role == "poses" else ", ".join(request.names)
            raise RecordingError(f"{table.path}: no row has {what}")
        values = of_columns(raw[:, :n], request.columns)
        own = np.isfinite(values)
        if request.role in ("commands", "scales"):
            values, known = held_values(values)
            given[np.flatnonzero(given)[~known]] = False
            own = own[known]
            self._check_finite(table, request, values, np.flatnonzero(given))
        stamps = table.stamps(stamp, given)
        shown = stamps_of_one(stamps, own)
        return Rows(
            stamps, values, describe(request.role, table.name, "table", clock=Clock.COLUMN, stamps=shown),
            raw[:, n] > 0.5 if valid else None,
        )  # fmt: skip

    @staticmethod
    def _check_named(column: Column, where: str, table: Table) -> None:
        if not (column.column or column.quaternion):
            names = ", ".join(table.names[:LISTED_COLUMNS])
            raise RecordingError(f"{where} has no column; {table.path} has {names}")

    @staticmethod
    def _check_finite(
        table: Table, request: Request, values: Array, rows: NDArray[np.intp]
    ) -> None:
        """Raise RecordingError where a command has no number: a table says on which line."""
        good = [np.isfinite(scaled(values[:, i], c)) for i, c in enumerate(request.columns)]
        bad = np.argwhere(~np.column_stack(good))
        if len(bad):
            row, which = (int(i) for i in bad[0])
            raise RecordingError(
                f"{table.place(int(rows[row]))}: '{request.columns[which].column}' is empty or not finite; "
                "write a number, or remove the line"
            )


def held_values(values: Array) -> tuple[Array, Mask]:
    """Values (m, k) of channels that are logged on change, and the rows (n,) from which all are known.

    Most rows of (n, k) then have only the channels that changed: an empty cell holds the last value. Other
    values stay as they are.
    """
    given = np.isfinite(values)
    whole = values.shape[1] < 2 or given.all(axis=1).mean() >= ON_CHANGE_WHOLE
    if whole or not given.any(axis=0).all():
        return values, np.ones(len(values), dtype=bool)
    row = np.where(given, np.arange(len(values))[:, None], -1)
    last = np.maximum.accumulate(row, axis=0)
    known = np.asarray((last >= 0).all(axis=1))
    return np.take_along_axis(values, last.clip(0), axis=0)[known], known


def stamps_of_one(stamps: Stamps, given: Mask) -> Stamps:
    """Stamps of one channel's rows, where channels (n, k) are written in turn, each at a rate; else all (n,)."""
    each = [stamps[rows] for rows in given.T]
    in_turn = len(stamps) > IN_TURN * max(map(len, each))
    even = in_turn and all(regular_period(np.diff(own) * 1e-9) is not None for own in each)
    return each[0] if even else stamps


def stamp_column(request: Request) -> Column:
    """The column with the stamps of a request's rows."""
    stamp = as_column(request.spec.stamp)
    if request.columns[0].stamp:
        own = request.columns[0].stamp  # in the unit of the others
        return msgspec.structs.replace(stamp, column=own, nanoseconds="")
    return stamp
