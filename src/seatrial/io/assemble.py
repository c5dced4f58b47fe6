# SPDX-License-Identifier: MIT
"""A recording from the signals of any log: positions, headings, yaw rates, commands, scales."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.boat.schema import Column
from seatrial.boat.vehicle import Vehicle, as_column
from seatrial.io.poses import POSE_UNITS, heading_of, in_plane, of_origin
from seatrial.io.signals import (
    Answer,
    Asked,
    Signals,
    checked_unit,
    grouped,
    merged,
    scaled,
    signal_of,
)
from seatrial.recording.averaging import with_enough_poses
from seatrial.recording.beside import Poses, joined
from seatrial.recording.bursts import on_even_clock
from seatrial.recording.delays import stamps_of_headings
from seatrial.recording.recording import Recording, Signal, Source, make_recording
from seatrial.recording.resolution import coarse_position
from seatrial.recording.yaw_rate import with_yaw_rate
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Axes

GEOGRAPHIC = ("latitude", "longitude")
HEADING = "psi"


def assemble(signals: Signals, vehicle: Vehicle, name: str) -> Recording:
    """A recording in forward-left-up axes. Raises RecordingError."""
    # 1. What the vehicle file asks, by topic or table.
    asked = questions(signals, vehicle)
    # 2. All of it in one pass.
    answers = signals.answer(asked)
    found = list(zip(asked, answers, strict=True))
    driven, factors = _by_role(found, "commands"), _by_role(found, "scales")
    # 3. Poses of the boat's origin at the times that they left with, commands and scales as signals.
    given = [*_by_role(found, "poses"), *_by_role(found, "headings")]
    given, bursts = _without_waits(given)
    known, doubts = _poses(given, vehicle, name)
    signs = dict(zip(vehicle.inputs, vehicle.input_signs, strict=True))
    inputs = [_signed(signal_of(*each), signs) for each in driven]
    position, heading = vehicle.delays
    recording = make_recording(
        name, stamps_of_headings(known.stamps, heading), known.eta,
        merged(inputs, vehicle.inputs),
        scales=_finite(merged([signal_of(*s) for s in factors], vehicle.scales)) if factors else None,
        marked_valid=given[0][1].marked_valid, timeout=vehicle.file.command_timeout,
        sources=[Source(file) for file in signals.files], streams=[a.stream for a in answers],
        remarks=[*signals.remarks, *bursts], doubts=doubts, position_delay=position - heading, parts=known.parts,
        beside=None if known.beside is None else known.beside.shifted(-round(1e9 * heading)),
    )  # fmt: skip
    recording = with_enough_poses(recording)
    # 4. Yaw rates of a gyro, their bias removed.
    for one, answer in _by_role(found, "yaw rates"):
        r = scaled(answer.values[:, 0], one.columns[0])
        r = -r if vehicle.axes is Axes.FRD else r
        recording = with_yaw_rate(
            recording, stamps_of_headings(answer.stamps, heading), r, one.wheres[0]
        )
    return recording


def questions(signals: Signals, vehicle: Vehicle) -> list[Asked]:
    """What the vehicle file asks of a log: poses, headings, yaw rates, commands, scales. Raises RecordingError."""
    values = [*_asked_commands(signals, vehicle), *_asked_scales(signals, vehicle)]
    return [*_asked_poses(signals, vehicle), *_asked_rates(signals, vehicle), *values]


def _asked_poses(signals: Signals, vehicle: Vehicle) -> list[Asked]:
    """Position and heading: of one place, or the position's before the heading's."""
    spec = vehicle.file.pose
    columns = dict(signals.pose_columns(vehicle))
    if (spec.latitude is None) != (spec.longitude is None):
        raise RecordingError(f"{vehicle.source}: pose: give latitude and longitude, both")
    if spec.latitude is not None and spec.longitude is not None:
        there = zip(GEOGRAPHIC, (spec.latitude, spec.longitude), strict=True)
        columns = {key: as_column(c) for key, c in there} | {HEADING: columns[HEADING]}
    for key, column in columns.items():
        if key in POSE_UNITS:
            checked_unit(column, f"{vehicle.source}: pose: {key}", POSE_UNITS[key])
    found = grouped(signals, "poses", columns, spec, f"{vehicle.source}: pose")
    if len(found) == 1:
        return found
    first, *more = found
    if len(more) != 1 or more[0].names != (HEADING,):
        raise RecordingError(
            f"{vehicle.source}: pose: {first.names[0]} is from {first.place} and {more[0].names[0]} from "
            f"{more[0].place}; name one place for both"
        )
    return [first, _in_role(more[0], "headings")]


def _in_role(asked: Asked, role: str) -> Asked:
    return replace(asked, role=role)


def _asked_rates(signals: Signals, vehicle: Vehicle) -> list[Asked]:
    spec = vehicle.file.pose
    if spec.yaw_rate is None:
        return []
    column = as_column(spec.yaw_rate)
    checked_unit(column, f"{vehicle.source}: pose: yaw_rate", POSE_UNITS["yaw_rate"])
    return grouped(signals, "yaw rates", {"yaw_rate": column}, spec, f"{vehicle.source}: pose")


def _asked_commands(signals: Signals, vehicle: Vehicle) -> list[Asked]:
    spec = vehicle.file.commands
    columns = {name: as_column(c) for name, c in spec.inputs.items()}
    return _asked_values(signals, vehicle, "commands", columns, "commands: inputs")


def _asked_scales(signals: Signals, vehicle: Vehicle) -> list[Asked]:
    columns = {name: as_column(s.column) for name, s in vehicle.file.scales.items()}
    return _asked_values(signals, vehicle, "scales", columns, "scales")


def _asked_values(
    signals: Signals, vehicle: Vehicle, role: str, columns: dict[str, Column], where: str
) -> list[Asked]:
    for name, column in columns.items():
        checked_unit(column, f"{vehicle.source}: {where}: {name}")
    return grouped(signals, role, columns, vehicle.file.commands, f"{vehicle.source}: {where}")


def _by_role(found: Sequence[tuple[Asked, Answer]], role: str) -> list[tuple[Asked, Answer]]:
    return [(asked, answer) for asked, answer in found if asked.role == role]


def _without_waits(
    found: Sequence[tuple[Asked, Answer]],
) -> tuple[list[tuple[Asked, Answer]], list[str]]:
    """Poses and headings with the stamps that they left with, and what was found."""
    changed, texts = [], []
    for asked, answer in found:
        stamps, text = on_even_clock(answer.stamps)
        changed.append((asked, replace(answer, stamps=stamps)))
        texts += [text] if text else []
    return changed, texts


def _poses(
    found: Sequence[tuple[Asked, Answer]], vehicle: Vehicle, name: str
) -> tuple[Poses, list[str]]:
    """Poses of the boat's origin, forward-left-up, at the stamps of the log, and doubts about them."""
    asked, answer = found[0]
    columns, raw = asked.columns, answer.values
    if len(raw) == 0:
        raise RecordingError(f"{asked.place}: no row has a pose")
    if asked.names[0] in GEOGRAPHIC:
        position = in_plane(raw[:, :2], columns[:2], vehicle)
    else:
        position = np.column_stack([scaled(raw[:, i], columns[i]) for i in range(2)])
    doubt = coarse_position(name, position)
    doubts = [doubt] if doubt else []
    if len(found) == 1:
        eta = np.column_stack([position, heading_of(raw[:, 2], columns[2])])
        return Poses(answer.stamps, of_origin(eta, vehicle, answer.stamps)), doubts
    compass, turned = found[1]
    both = joined(
        answer.stamps, position, turned.stamps, heading_of(turned.values[:, 0], compass.columns[0])
    )
    beside = both.beside
    if beside is not None and vehicle.axes is Axes.FRD:
        beside = beside.mirrored()
    eta = of_origin(both.eta, vehicle, answer.stamps)
    return Poses(answer.stamps, eta, both.parts, beside), doubts


def _signed(signal: Signal, signs: dict[str, float]) -> Signal:
    """Commands in forward-left-up axes."""
    own = np.array([signs[name] for name in signal.names])
    return Signal(signal.names, signal.stamps, signal.values * own)


def _finite(signal: Signal) -> Signal:
    """Rows of finite numbers; without the others the previous row holds."""
    good = np.isfinite(signal.values).all(axis=1)
    return Signal(signal.names, signal.stamps[good], signal.values[good])
