# SPDX-License-Identifier: MIT
"""A recording from a bag, or from CSV: one table, or a folder with one table per signal."""

from pathlib import Path

import numpy as np

from seatrial.boat.schema import Column
from seatrial.boat.vehicle import Vehicle, as_column
from seatrial.io.bags.opening import is_bag
from seatrial.io.bags.poses import in_vehicle_terms, pose_columns
from seatrial.io.bags.recording import read_bag, recording_name
from seatrial.io.table import TABLES, CsvTable, Table, checked_unit, scaled
from seatrial.recording.delays import stamps_of_headings
from seatrial.recording.recording import Recording, Signal, Source, make_recording, rising
from seatrial.recording.timing import Clock, describe
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.frames import Mask
from seatrial.util.progress import reach

POSE_FILE = "poses.csv"
COMMAND_FILE = "commands.csv"


def read(path: str | Path, vehicle: Vehicle, *, salvage: bool = False) -> Recording:
    """A recording in forward-left-up axes; with `salvage` the readable part of a damaged bag.

    Raises RecordingError, FileError.
    """
    path = Path(path)
    if not path.exists():
        raise FileError(f"{path}: no such file or folder")
    if is_bag(path):
        return read_bag(path, vehicle, salvage=salvage)
    if path.is_dir():
        if not any(path.iterdir()):
            raise FileError(f"{path}: is an empty folder; expected a bag or .csv tables")
        poses = path / (vehicle.file.pose.file or POSE_FILE)
        commands = path / (vehicle.file.commands.file or COMMAND_FILE)
    elif path.suffix.lower() in TABLES:
        poses = commands = path
    else:
        raise RecordingError(
            f"{path}: expected a bag (.bag, .mcap, .db3, or a folder of ROS 2), a .csv table, or a "
            f"folder of tables, got '{path.suffix}'"
        )
    for part, key in ((poses, "pose"), (commands, "commands")):
        if not part.is_file():
            raise FileError(f"{part}: no such file; name it in the vehicle file under {key}: file")
    sources = [Source(p) for p in dict.fromkeys((poses, commands))]
    return _assemble(path, vehicle, CsvTable(poses), CsvTable(commands), sources)


def _assemble(
    path: Path, vehicle: Vehicle, poses: Table, commands: Table, sources: list[Source]
) -> Recording:
    spec = vehicle.file.pose
    stamp = as_column(spec.stamp)
    columns = pose_columns(vehicle)
    for key, column in zip(("stamp", "x", "y", "psi"), (stamp, *columns), strict=True):
        _check_named(column, f"{vehicle.source}: pose: {key}", poses)
    names = [c.column for c in columns] + ([spec.valid] if spec.valid else [])
    raw = poses.columns(names)
    reach(0.5)  # the commands are to be read
    merged = poses.path == commands.path
    rows: Mask = np.ones(len(raw), dtype=bool)
    if merged:  # merged logs: a row may have no pose
        rows = np.asarray(~np.isnan(raw[:, :3]).all(axis=1))
        raw = raw[rows]
    if len(raw) == 0:
        raise RecordingError(f"{poses.path}: no row has a pose")
    stamps = poses.stamps(stamp, rows)
    driven = _commands(vehicle, commands, merged=merged)
    streams = [
        describe(role, table.path.name, "table", clock=Clock.COLUMN, stamps=s)
        for role, table, s in (("poses", poses, stamps), ("commands", commands, driven.stamps))
    ]
    position, heading = vehicle.delays
    return make_recording(
        recording_name(path), stamps_of_headings(stamps, heading),
        in_vehicle_terms(raw[:, :3], vehicle, stamps), driven,
        scales=_scales(vehicle, commands, merged=merged),
        marked_valid=raw[:, 3] > 0.5 if spec.valid else None,
        timeout=vehicle.file.command_timeout, sources=sources, streams=streams,
        position_delay=position - heading,
    )  # fmt: skip


def _check_named(column: Column, where: str, table: Table) -> None:
    if not column.column:
        raise RecordingError(
            f"{where} has no column; {table.path} has {', '.join(table.names[:20])}"
        )


def _commands(vehicle: Vehicle, table: Table, *, merged: bool) -> Signal:
    spec = vehicle.file.commands
    columns = {name: as_column(c) for name, c in spec.inputs.items()}
    signal = _signal(vehicle, table, columns, "commands: inputs", merged=merged)
    return Signal(signal.names, signal.stamps, signal.values * vehicle.input_signs)


def _scales(vehicle: Vehicle, table: Table, *, merged: bool) -> Signal | None:
    if not vehicle.scales:
        return None
    columns = {name: as_column(s.column) for name, s in vehicle.file.scales.items()}
    return _signal(vehicle, table, columns, "scales", merged=merged)


def _signal(
    vehicle: Vehicle, table: Table, named: dict[str, Column], where: str, *, merged: bool
) -> Signal:
    stamp = as_column(vehicle.file.commands.stamp)
    _check_named(stamp, f"{vehicle.source}: commands: stamp", table)
    for name, column in named.items():
        _check_named(column, f"{vehicle.source}: {where}: {name}", table)
        checked_unit(column, f"{vehicle.source}: {where}: {name}")
    columns = list(named.values())
    raw = table.columns([c.column for c in columns])
    given: Mask = np.ones(len(raw), dtype=bool)
    if merged:  # merged logs: a row may have no command
        given = np.asarray(~np.isnan(raw).all(axis=1))
        raw = raw[given]
    if len(raw) == 0:
        raise RecordingError(f"{table.path}: no row has {', '.join(named)}")
    stamps = table.stamps(stamp, given)
    values = np.column_stack([scaled(raw[:, i], c) for i, c in enumerate(columns)])
    if not np.isfinite(values).all():
        row, which = (int(i) for i in np.argwhere(~np.isfinite(values))[0])
        raise RecordingError(
            f"{table.place(int(np.flatnonzero(given)[row]))}: '{columns[which].column}' is empty or not "
            "finite; write a number, or remove the line"
        )
    keep = rising(stamps)
    return Signal(tuple(named), stamps[keep], values[keep])
