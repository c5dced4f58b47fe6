# SPDX-License-Identifier: MIT
"""Signals that look wrong in the drive so far, and the lines of the vehicle file that mend them."""

from collections.abc import Iterator
from dataclasses import dataclass

import msgspec

from seatrial.boat.finding_kinds import LACKING
from seatrial.boat.findings import finding_text, most_important
from seatrial.boat.model import Model
from seatrial.boat.physics import backward_forces
from seatrial.boat.schema import Column, as_column
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.advice import implausible_units
from seatrial.inspection.consistency.check import ConsistencyReport, check_consistency
from seatrial.inspection.consistency.effects import CLEAR_T
from seatrial.inspection.consistency.inconsistencies import Inconsistency, InconsistencyKind
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.files import dump_yaml

OF_INPUTS = (
    InconsistencyKind.NEGATED, InconsistencyKind.PERMUTED, InconsistencyKind.STEERED, InconsistencyKind.CHANGED,
)  # fmt: skip
SENDER = (
    "lines carry values after the vehicle file's signs and units: correct the program that sends them (for the "
    "odometry node: the vehicle in its model file), and begin a new session"
)


@dataclass(frozen=True)
class Edit:
    """What looks wrong in one signal."""

    signal: str  # pose, or the name of an input
    text: str  # what the data show
    line: str = ""  # of the vehicle file, as it should be; empty: no line mends it


def edits(recording: Recording, vehicle: Vehicle, *, by_columns: bool = True) -> tuple[Edit, ...]:
    """What looks wrong. by_columns: the vehicle file's columns read the signals."""
    found: list[Edit] = []
    try:
        report = check_consistency([recording], vehicle)
    except RecordingError:  # too little data yet
        return tuple(_of_units(recording, vehicle, by_columns=by_columns))
    lines = _changed_lines(report, vehicle) if by_columns else {}
    for one in report.findings:
        of_sender = not by_columns and one.kind is not InconsistencyKind.CHANGED
        text = f"{one.text.partition('; ')[0]}; {SENDER}" if of_sender else one.text
        found += [Edit(signal, text, lines.get(signal, "")) for signal in _signals(one, vehicle)]
    if not any(one.signal == "pose" for one in found):
        found += _of_units(recording, vehicle, by_columns=by_columns)
    return tuple(found)


def _of_units(recording: Recording, vehicle: Vehicle, *, by_columns: bool) -> Iterator[Edit]:
    """Values that only another unit explains: seconds of a drive show these, and `identify` refuses them."""
    for found, mend in implausible_units(recording, vehicle):
        line = heading_in_degrees(vehicle) if by_columns and "psi" in found else ""
        yield Edit(
            "pose",
            f"{found} {mend}" if by_columns else f"{found} {SENDER[0].upper()}{SENDER[1:]}",
            line,
        )


def backward_inputs(model: Model, *, by_columns: bool = True) -> tuple[Edit, ...]:
    """Inputs that drive their axis backwards by the estimate: minutes before `edits` can check signs."""
    found, inputs = [], model.vehicle.inputs
    for one in backward_forces(model, CLEAR_T):
        text = f"{one.text}. {one.mend}" if by_columns else f"{one.text}; {SENDER}"
        found += [Edit(name, text) for name in ([one.force] if one.force in inputs else inputs)]
    return tuple(found)


def lacking_effect(model: Model) -> str:
    """What the poses show that the model lacks, as a late sensor, by the last thorough search; empty: nothing."""
    found = most_important(model.findings_of(*LACKING))
    return finding_text(found[0]) if found else ""


def heading_in_degrees(vehicle: Vehicle) -> str:
    """The line of the vehicle file by which psi is in degrees."""
    column = msgspec.structs.replace(as_column(vehicle.file.pose.psi), unit="deg")
    return f"pose: {_line('psi', column)}"


def _signals(found: Inconsistency, vehicle: Vehicle) -> tuple[str, ...]:
    if found.kind is InconsistencyKind.CLOCK:
        return vehicle.inputs
    if found.kind in OF_INPUTS:
        head = found.text.partition(":")[0].partition(" moves ")[0].partition(" are ")[0]
        words = head.replace(",", " ").split()
        return tuple(name for name in vehicle.inputs if name in words) or vehicle.inputs
    return ("pose",)


def _changed_lines(report: ConsistencyReport, vehicle: Vehicle) -> dict[str, str]:
    """By signal, the entries of the repaired vehicle file that differ."""
    before, after = vehicle.file, report.repaired(vehicle).file
    lines = {}
    pose = [
        _line(key, getattr(after.pose, key))
        for key in ("x", "y", "psi")
        if as_column(getattr(after.pose, key)) != as_column(getattr(before.pose, key))
    ]
    if pose:
        lines["pose"] = "pose: " + ", ".join(pose)
    for name in vehicle.inputs:
        own, new = (as_column(file.commands.inputs[name]) for file in (before, after))
        if own != new:
            lines[name] = f"commands: inputs: {_line(name, new)}"
    return lines


def _line(key: str, entry: str | Column) -> str:
    """An entry of a vehicle file on one line."""
    content = msgspec.to_builtins(as_column(entry))
    if content.get("column") == content.get("field"):
        content.pop("field", None)
    inside = dump_yaml(content).strip().removeprefix("{").removesuffix("}").replace("\n", ", ")
    return f"{key}: {{{inside}}}"
