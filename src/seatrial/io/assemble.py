# SPDX-License-Identifier: MIT
"""A recording from the signals of any log: positions, headings, yaw rates, commands, scales."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from seatrial.boat.schema import Column, as_column
from seatrial.boat.vehicle import Vehicle
from seatrial.io.clock_resets import apart_by_resets
from seatrial.io.copies import without_copies
from seatrial.io.poses import UNITS_OF_POSES, heading_of, in_plane, lengths_of_degrees, of_origin
from seatrial.io.signals import (
    Request,
    Rows,
    Signals,
    checked_unit,
    grouped,
    merged,
    scaled,
    signal_of,
)
from seatrial.recording.asynchronous import Poses, joined
from seatrial.recording.averaging import with_enough_poses
from seatrial.recording.bursts import on_even_clock
from seatrial.recording.delays import stamps_of_headings
from seatrial.recording.faults.interleaved_commands import interleaving_doubt
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording, Source
from seatrial.recording.resolution import coarse_position, interpolated_position
from seatrial.recording.sampled_commands import (
    Stated,
    are_samples,
    sampled_commands,
    taken_halfway,
)
from seatrial.recording.signal import Signal
from seatrial.recording.yaw_rate import with_yaw_rate
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Axes

GEOGRAPHIC = ("latitude", "longitude")
HEADING = "psi"
Read = tuple[Request, Rows]


def assemble(signals: Signals, vehicle: Vehicle, name: str) -> Recording:
    """A recording in forward-left-up axes. Raises RecordingError."""
    # 1. The signals of the vehicle file, by topic or table.
    wanted = requests(signals, vehicle)
    # 2. All of it in one pass; parts of a clock that was set back one after the other; what is written twice once.
    read, resets = apart_by_resets(signals.read(wanted), wanted)
    read, copies = without_copies(read, wanted)
    found = list(zip(wanted, read, strict=True))
    driven, factors = _by_role(found, "commands"), _by_role(found, "scales")
    # 3. Poses of the boat's origin at the times that they left with, commands and scales as signals.
    given = [*_by_role(found, "poses"), *_by_role(found, "headings")]
    given, bursts = _without_waits(given)
    known, doubts = _poses(given, vehicle, name)
    signs = dict(zip(vehicle.inputs, vehicle.input_signs, strict=True))
    inputs = [_signed(signal_of(*each), signs) for each in driven]
    doubts = [*doubts, *(doubt for signal in inputs for doubt in interleaving_doubt(signal))]
    streams = [rows.stream for rows in read]
    position, heading = vehicle.delays
    recording = make_recording(
        name, stamps_of_headings(known.stamps, heading), known.eta,
        merged(inputs, vehicle.inputs),
        scales=_finite(merged([signal_of(*s) for s in factors], vehicle.scales)) if factors else None,
        marked_valid=given[0][1].marked_valid, timeout=vehicle.file.command_timeout,
        sources=[Source(file) for file in signals.files], streams=streams,
        remarks=[*signals.remarks, *resets, *copies, *bursts], doubts=doubts,
        position_delay=position - heading, parts=known.parts,
        paused=[stamp for _, rows in driven for stamp in rows.paused],
        asynchronous=None if known.asynchronous is None else known.asynchronous.shifted(-round(1e9 * heading)),
    )  # fmt: skip
    recording = with_enough_poses(_with_sampled_commands(recording, vehicle.file.commands.sampled))
    # 4. Yaw rates of a gyro, their bias removed.
    for one, rows in _by_role(found, "yaw rates"):
        r = vehicle.axes.lateral_sign * scaled(rows.values[:, 0], one.columns[0])
        stamps = stamps_of_headings(rows.stamps, heading)
        recording = with_yaw_rate(recording, stamps, r, one.wheres[0])
    return recording


def _with_sampled_commands(recording: Recording, stated: Stated) -> Recording:
    """The recording with the period of commands that are samples, or may be."""
    stream = sampled_commands(recording.streams, stated)
    if stream is None:
        return recording
    sampled = are_samples(stream, stated)
    remarks = (*recording.remarks, taken_halfway(stream)) if sampled else recording.remarks
    period = 1.0 / stream.rate
    return replace(recording, remarks=remarks, command_period=period, command_sampled=sampled)


def requests(signals: Signals, vehicle: Vehicle) -> list[Request]:
    """Signals of the vehicle file: poses, headings, yaw rates, commands, scales. Raises RecordingError."""
    inputs, scales = vehicle.file.commands.inputs, vehicle.file.scales
    values = [
        *_requested_values(signals, vehicle, "commands", inputs, "commands: inputs"),
        *_requested_values(
            signals, vehicle, "scales", {n: s.column for n, s in scales.items()}, "scales"
        ),
    ]
    return [*_requested_poses(signals, vehicle), *_requested_rates(signals, vehicle), *values]


def _requested_poses(signals: Signals, vehicle: Vehicle) -> list[Request]:
    """Position and heading: of one place, or the position's before the heading's."""
    spec = vehicle.file.pose
    columns = dict(signals.pose_columns(vehicle))
    if (spec.latitude is None) != (spec.longitude is None):
        raise RecordingError(f"{vehicle.source}: pose: give latitude and longitude, both")
    if spec.latitude is not None and spec.longitude is not None:
        there = zip(GEOGRAPHIC, (spec.latitude, spec.longitude), strict=True)
        columns = {key: as_column(c) for key, c in there} | {HEADING: columns[HEADING]}
    for key, column in columns.items():
        if key in UNITS_OF_POSES:
            checked_unit(column, f"{vehicle.source}: pose: {key}", UNITS_OF_POSES[key])
    found = grouped(signals, "poses", columns, spec, f"{vehicle.source}: pose")
    if len(found) == 1:
        return found
    first, *more = found
    if len(more) != 1 or more[0].names != (HEADING,):
        raise RecordingError(
            f"{vehicle.source}: pose: {first.names[0]} is from {first.place} and {more[0].names[0]} from "
            f"{more[0].place}; name one place for both"
        )
    return [first, replace(more[0], role="headings")]


def _requested_rates(signals: Signals, vehicle: Vehicle) -> list[Request]:
    spec = vehicle.file.pose
    if spec.yaw_rate is None:
        return []
    column = as_column(spec.yaw_rate)
    checked_unit(column, f"{vehicle.source}: pose: yaw_rate", UNITS_OF_POSES["yaw_rate"])
    return grouped(signals, "yaw rates", {"yaw_rate": column}, spec, f"{vehicle.source}: pose")


def _requested_values(
    signals: Signals, vehicle: Vehicle, role: str, entries: Mapping[str, str | Column], where: str
) -> list[Request]:
    columns = {name: as_column(entry) for name, entry in entries.items()}
    for name, column in columns.items():
        checked_unit(column, f"{vehicle.source}: {where}: {name}")
    return grouped(signals, role, columns, vehicle.file.commands, f"{vehicle.source}: {where}")


def _by_role(found: Sequence[Read], role: str) -> list[Read]:
    return [(request, rows) for request, rows in found if request.role == role]


def _without_waits(found: Sequence[Read]) -> tuple[list[Read], list[str]]:
    """Poses and headings with the stamps that they left with, and what was found."""
    changed, texts = [], []
    for request, rows in found:
        stamps, text = on_even_clock(rows.stamps)
        changed.append((request, replace(rows, stamps=stamps)))
        texts += [text] if text else []
    return changed, texts


def _poses(found: Sequence[Read], vehicle: Vehicle, name: str) -> tuple[Poses, list[str]]:
    """Poses of the boat's origin, forward-left-up, at the stamps of the log, and doubts about them."""
    request, rows = found[0]
    columns, raw = request.columns, rows.values
    if len(raw) == 0:
        raise RecordingError(f"{name}: 0 poses: no row of {request.place} has one")
    if request.names[0] in GEOGRAPHIC:
        position = in_plane(raw[:, :2], columns[:2], vehicle)
        written = lengths_of_degrees(raw[:, :2], columns[:2])
    else:
        written = position = np.column_stack([scaled(raw[:, i], columns[i]) for i in range(2)])
    doubt = coarse_position(name, written)
    doubts = [text for text in (doubt, interpolated_position(rows.stamps, position)) if text]
    if len(found) == 1:
        eta = np.column_stack([position, heading_of(raw[:, 2], columns[2])])
        return Poses(rows.stamps, of_origin(eta, vehicle, rows.stamps)), doubts
    compass, turned = found[1]
    psi = heading_of(turned.values[:, 0], compass.columns[0])
    both = joined(rows.stamps, position, turned.stamps, psi)
    asynchronous = both.asynchronous
    if asynchronous is not None and vehicle.axes is Axes.FRD:
        asynchronous = asynchronous.mirrored()
    eta = of_origin(both.eta, vehicle, rows.stamps)
    return Poses(rows.stamps, eta, both.parts, asynchronous), doubts


def _signed(signal: Signal, signs: dict[str, float]) -> Signal:
    """Commands in forward-left-up axes."""
    own = np.array([signs[name] for name in signal.names])
    return Signal(signal.names, signal.stamps, signal.values * own)


def _finite(signal: Signal) -> Signal:
    """Rows of finite numbers; without the others the previous row holds."""
    good = np.isfinite(signal.values).all(axis=1)
    return Signal(signal.names, signal.stamps[good], signal.values[good])
