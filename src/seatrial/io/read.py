# SPDX-License-Identifier: MIT
"""A recording from CSV: one table, or a folder with one table per signal."""

from pathlib import Path

import numpy as np

from seatrial.errors import FileError, RecordingError
from seatrial.files import sha256
from seatrial.frames import POSE_SIGNS, Axes
from seatrial.io.table import TO_SI, Table, nanoseconds, scaled
from seatrial.recording import Recording, Signal, Source, make_recording, rising
from seatrial.schema import Column
from seatrial.vehicle import Vehicle, as_column

POSE_FILE = "poses.csv"
COMMAND_FILE = "commands.csv"
ANGLE_UNITS = ("rad", "deg")
LENGTH_UNITS = ("m", "cm", "mm")


def read(path: str | Path, vehicle: Vehicle) -> Recording:
    """A recording in forward-left-up axes. Raises RecordingError, FileError."""
    path = Path(path)
    if not path.exists():
        raise FileError(f"{path}: no such file or folder")
    if path.is_dir():
        poses = path / (vehicle.file.pose.file or POSE_FILE)
        commands = path / (vehicle.file.commands.file or COMMAND_FILE)
    elif path.suffix.lower() in (".csv", ".txt", ".tsv"):
        poses = commands = path
    else:
        raise RecordingError(
            f"{path}: expected a .csv table or a folder of them, got '{path.suffix}'"
        )
    for part, key in ((poses, "pose"), (commands, "commands")):
        if not part.is_file():
            raise FileError(f"{part}: no such file; name it in the vehicle file under {key}: file")
    sources = [Source(p.name, sha256(p)) for p in dict.fromkeys((poses, commands))]
    return _assemble(path, vehicle, Table(poses), Table(commands), sources)


def _assemble(
    path: Path, vehicle: Vehicle, poses: Table, commands: Table, sources: list[Source]
) -> Recording:
    spec = vehicle.file.pose
    columns = [as_column(c) for c in (spec.stamp, spec.x, spec.y, spec.psi)]
    names = [c.column for c in columns] + ([spec.valid] if spec.valid else [])
    raw = poses.columns(names)
    for column, units in zip(columns[1:], (LENGTH_UNITS, LENGTH_UNITS, ANGLE_UNITS), strict=True):
        if column.unit is not None and column.unit not in units:
            raise RecordingError(
                f"{vehicle.source}: pose column '{column.column}' has unit '{column.unit}'; "
                f"use {', '.join(units)}"
            )
    if poses.path == commands.path:  # merged logs: a row without a pose is no pose
        raw = raw[~np.isnan(raw[:, 1:4]).all(axis=1)]
    if len(raw) == 0:
        raise RecordingError(f"{poses.path}: no row has a pose")
    stamps = nanoseconds(raw[:, 0], columns[0], poses.path)
    eta = np.column_stack([scaled(raw[:, i], columns[i]) for i in (1, 2, 3)])
    if vehicle.axes is Axes.FRD:
        eta = eta * POSE_SIGNS
    valid = raw[:, 4] > 0.5 if spec.valid else None
    name = path.resolve().stem if path.is_file() else path.resolve().name
    merged = poses.path == commands.path
    return make_recording(
        name, stamps, eta, _commands(vehicle, commands, merged=merged),
        scales=_scales(vehicle, commands, merged=merged), marked_valid=valid, sources=sources,
    )  # fmt: skip


def _commands(vehicle: Vehicle, table: Table, *, merged: bool) -> Signal:
    spec = vehicle.file.commands
    columns = [as_column(c) for c in spec.inputs.values()]
    signal = _signal(table, as_column(spec.stamp), columns, vehicle.inputs, merged=merged)
    return Signal(signal.names, signal.stamps, signal.values * vehicle.input_signs)


def _scales(vehicle: Vehicle, table: Table, *, merged: bool) -> Signal | None:
    if not vehicle.scales:
        return None
    columns = [as_column(s.column) for s in vehicle.file.scales.values()]
    return _signal(
        table, as_column(vehicle.file.commands.stamp), columns, vehicle.scales, merged=merged
    )


def _signal(
    table: Table, stamp: Column, columns: list[Column], names: tuple[str, ...], *, merged: bool
) -> Signal:
    for column in columns:
        if column.unit is not None and column.unit not in TO_SI:
            raise RecordingError(
                f"{table.path}: column '{column.column}' has unit '{column.unit}'; "
                f"use {', '.join(TO_SI)}"
            )
    raw = table.columns([stamp.column, *(c.column for c in columns)])
    lines = np.arange(len(raw)) + 2  # of the file
    if merged:  # merged logs: a row without a command is no command
        given = ~np.isnan(raw[:, 1:]).all(axis=1)
        raw, lines = raw[given], lines[given]
    if len(raw) == 0:
        raise RecordingError(f"{table.path}: no row has {', '.join(names)}")
    stamps = nanoseconds(raw[:, 0], stamp, table.path)
    values = np.column_stack([scaled(raw[:, i + 1], c) for i, c in enumerate(columns)])
    if not np.isfinite(values).all():
        row, which = (int(i) for i in np.argwhere(~np.isfinite(values))[0])
        raise RecordingError(
            f"{table.path} line {lines[row]}: '{columns[which].column}' is empty or not finite; "
            "write a number, or remove the line"
        )
    keep = rising(stamps)
    return Signal(names, stamps[keep], values[keep])
