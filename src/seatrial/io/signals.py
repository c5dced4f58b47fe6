# SPDX-License-Identifier: MIT
"""Signals that a vehicle file names, and the contract of a log that reads them."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from seatrial.boat.schema import TO_SI, Column, CommandSource, PoseSource
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.recording import rising
from seatrial.recording.signal import Signal
from seatrial.recording.timing import Stream
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Mask, Stamps
from seatrial.util.quaternion import yaw

Spec = PoseSource | CommandSource


@dataclass(frozen=True)
class Request:
    """Columns of one role that have one place in the log, and so one stamp."""

    role: str  # poses, headings, yaw rates, commands, scales
    place: str  # topic or table
    names: tuple[str, ...]  # x, y, psi; or names of inputs
    columns: tuple[Column, ...]
    wheres: tuple[str, ...]  # places in the vehicle file, for messages
    spec: Spec  # which states the defaults
    paths: tuple[str, ...]  # columns of a table or fields of messages, quaternions spelled out


@dataclass(frozen=True)
class Rows:
    """Rows of one request, in the order of the log."""

    stamps: Stamps  # (n,) [ns]
    values: Array  # (n, names) raw; of a quaternion its yaw [rad]
    stream: Stream
    marked_valid: Mask | None = None  # (n,)
    paused: tuple[int, ...] = ()  # [ns] stamps of rows that stand for a pause of the recorder


class Signals(ABC):
    """A log as signals; one class each for tables, bags and logs of autopilots."""

    path: Path
    files: Sequence[Path]
    remarks: Sequence[str] = ()

    @abstractmethod
    def place(self, column: Column, spec: Spec, where: str) -> str:
        """Topic or table of a column. Raises RecordingError where none is named."""

    def path_of(self, column: Column) -> str:
        """The column's path in a message; of a table its name."""
        return field_path(column)

    @abstractmethod
    def read(self, requests: Sequence[Request]) -> list[Rows]:
        """The rows of each request, in one pass. Raises RecordingError."""

    def pose_columns(self, vehicle: Vehicle) -> Mapping[str, Column]:
        """Columns x, y and psi; a bag finds what its usual messages hold."""
        return vehicle.file.pose.columns


def shared_places(requests: Sequence[Request]) -> set[str]:
    """Places with signals of several roles: a row may have numbers of one of them alone."""
    roles: dict[str, set[str]] = {}
    for one in requests:
        roles.setdefault(one.place, set()).add(one.role)
    return {place for place, found in roles.items() if len(found) > 1}


def given_rows(raw: Array) -> Mask:
    """Rows (n,) that have any number of a signal."""
    return np.asarray(~np.isnan(raw).all(axis=1))


def field_path(column: Column) -> str:
    """The path to a column's field in a message."""
    return column.field if column.index is None else f"{column.field}[{column.index}]"


def grouped(
    signals: Signals, role: str, columns: Mapping[str, Column], spec: Spec, where: str
) -> list[Request]:
    """The columns by place, in their order. where: key of the vehicle file above them."""
    found: dict[tuple[str, str], list[str]] = {}
    for name, column in columns.items():
        place = signals.place(column, spec, f"{where}: {name}")
        found.setdefault((place, column.stamp), []).append(name)
    return [
        Request(
            role, place, tuple(names), tuple(columns[n] for n in names),
            tuple(f"{where}: {n}" for n in names), spec,
            tuple(p for n in names for p in columns[n].quaternion or (signals.path_of(columns[n]),)),
        )
        for (place, _), names in found.items()
    ]  # fmt: skip


def in_own_unit(raw: Array, column: Column) -> Array:
    """value = sign (raw - offset) / scale."""
    return np.asarray(column.sign * (raw - column.offset) / column.scale)


def scaled(raw: Array, column: Column) -> Array:
    """The same in SI; none where the raw value means off."""
    with np.errstate(over="ignore", invalid="ignore"):  # NaN is handled later
        values = in_own_unit(raw, column) * TO_SI.get(column.unit or "-", 1.0)
    return values if column.off is None else np.where(raw == column.off, 0.0, values)


def checked_unit(column: Column, where: str, units: Sequence[str] = tuple(TO_SI)) -> None:
    """Raise RecordingError where a value has a unit of another kind."""
    if column.unit is not None and column.unit not in units:
        raise RecordingError(f"{where} has unit '{column.unit}'; use {', '.join(units)}")


def of_columns(raw: Array, columns: Sequence[Column]) -> Array:
    """Raw numbers (n, columns) out of those read, where a quaternion has four; of it the yaw [rad]."""
    found, i = [], 0
    for column in columns:
        width = len(column.quaternion or (column,))
        found.append(yaw(raw[:, i : i + width]) if column.quaternion else raw[:, i])
        i += width
    return np.column_stack(found)


def signal_of(request: Request, rows: Rows) -> Signal:
    """Rows with rising stamps, in command units. Raises RecordingError where the stamps show another clock."""
    keep = rising(rows.stamps)
    values = [scaled(rows.values[keep, i], column) for i, column in enumerate(request.columns)]
    return Signal(request.names, rows.stamps[keep], np.column_stack(values))


def merged(signals: Sequence[Signal], names: tuple[str, ...]) -> Signal:
    """Signals as one, in the order of `names`, from the time when all are known: each value holds."""
    if not signals:
        return Signal((), np.zeros(0, np.int64), np.zeros((0, 0)))
    if len(signals) == 1 and signals[0].names == names:
        return signals[0]
    begin = max(s.stamps[0] for s in signals)
    stamps = np.unique(np.concatenate([s.stamps for s in signals]))
    stamps = stamps[stamps >= begin]
    values = np.empty((len(stamps), len(names)))
    for signal in signals:
        row = np.searchsorted(signal.stamps, stamps, side="right") - 1
        for i, name in enumerate(signal.names):
            values[:, names.index(name)] = signal.values[row, i]
    return Signal(names, stamps, values)
