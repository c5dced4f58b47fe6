# SPDX-License-Identifier: MIT
"""Messages about inconsistencies: what the data show, and the line of the vehicle file to change.

One function a kind of edit; `inconsistencies` lists them all.
"""

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from math import inf, isfinite

from seatrial.boat.schema import Column, as_column
from seatrial.boat.steering import steered_entries
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.changed_input import InputChange
from seatrial.inspection.consistency.channel_assignment import ASSIGN_T
from seatrial.inspection.consistency.effects import UNCLEAR
from seatrial.inspection.consistency.repair import Repair, cycles, later, repaired_heading
from seatrial.recording.recording import Recording
from seatrial.util.format import joined
from seatrial.util.frames import POSE

UNIT_NAMES = {
    "m": "metres", "cm": "centimetres", "mm": "millimetres", "rad": "radians", "deg": "degrees",
}  # fmt: skip


class InconsistencyKind(str, Enum):
    """Inconsistencies of units, signs, order and clock."""

    CLOCK = "clock of the commands"
    DELAY = "delay of the positions"
    CHANGED = "effect of an input that changes"
    LENGTH = "unit of x and y"
    ANGLE = "unit of psi"
    MIRRORED = "sign of a pose coordinate"
    EXCHANGED = "x and y exchanged"
    HEADING = "zero and sense of psi"
    HANDED = "poses and commands of opposite axes"
    NEGATED = "sign of an input"
    PERMUTED = "order of the inputs"
    STEERED = "order of a thrust and its angle"


@dataclass(frozen=True)
class Part:
    """A part of a recording, in seconds of its file."""

    recording: str
    begin: float = 0.0  # [s]
    end: float = inf  # [s]

    @property
    def span(self) -> str:
        """NAME=FROM-TO, as --without has it."""
        begin = f"{self.begin:.0f}" if self.begin else ""
        return f"{self.recording}={begin}-{f'{self.end:.0f}' if isfinite(self.end) else ''}"


@dataclass(frozen=True)
class Inconsistency:
    """One inconsistency between the vehicle file and the data."""

    kind: InconsistencyKind
    text: str  # what the data show, and the line to change
    leave_out: Part | None = None  # what mends it, where no line does


def clock_inconsistency(offset: float) -> list[Inconsistency]:
    """The clock of commands that act `offset` [s] after their stamps; none for 0."""
    if not offset:
        return []
    side = "after" if offset > 0 else "before"
    text = (
        f"commands act about {abs(offset):.1f} s {side} their stamps on the poses' clock: poses and "
        "commands have different clocks; stamp both by one clock, or correct the stamps (in seconds, of a table: "
        f"'offset: {-offset:.1f}' at commands: stamp)"
    )
    return [Inconsistency(InconsistencyKind.CLOCK, text)]


def delay_inconsistency(vehicle: Vehicle, late: float) -> list[Inconsistency]:
    """Positions that are `late` [s] older than the headings, beyond what the file states; negative: headings."""
    if not late:
        return []
    older, newer = ("positions", "headings") if late > 0 else ("headings", "positions")
    position, heading = later(vehicle.delays, late)
    text = (
        f"{older} are about {abs(late):.1f} s older than the {newer} of the same stamps, as of a slow "
        f"localisation or a filter; set delay: {position:g} and heading_delay: {heading:g} at pose, which "
        "'seatrial identify --effect delay' refines"
    )
    return [Inconsistency(InconsistencyKind.DELAY, text)]


def change_inconsistency(
    change: InputChange | None, recordings: Sequence[Recording]
) -> list[Inconsistency]:
    """An input that moves the boat less in a part of a recording."""
    if change is None:
        return []
    recording = recordings[change.run]
    begin = recording.offset + change.begin if change.begin else 0.0
    part = Part(recording.name, begin, recording.offset + change.end)
    when = f"up to {part.end:.0f} s" if isfinite(part.end) else f"from {begin:.0f} s on"
    text = (
        f"{change.input} moves the boat {change.factor:.2f} times as much {when} in {recording.name} as in the "
        "rest: a thruster that stopped, a fouled propeller, a loose cable? One model does not hold for both; "
        f"leave that part out, --without {shlex.quote(part.span)}"
    )
    return [Inconsistency(InconsistencyKind.CHANGED, text, part)]


def steering_inconsistencies(
    vehicle: Vehicle, surge_t: Mapping[str, float], effects: Mapping[str, str]
) -> list[Inconsistency]:
    """Pairs of chain: steered whose angle moves the boat ahead, and whose thrust does not.

    surge_t: t of the surge gain by input. The cosine of an angle about 0 gives no surge gain.
    """
    pairs = [two for entry in steered_entries(vehicle.file.chain) for two in entry.of]
    return [
        Inconsistency(
            InconsistencyKind.STEERED,
            f"{thrust} and {angle} are swapped at chain: steered: {angle}, the angle, "
            f"{effects.get(angle, UNCLEAR)}; {thrust}, the thrust, {effects.get(thrust, UNCLEAR)}; "
            f"set of: [[{angle}, {thrust}]]",
        )
        for thrust, angle in pairs
        if {thrust, angle} <= set(vehicle.inputs)
        and abs(surge_t[angle]) > max(ASSIGN_T, abs(surge_t[thrust]))
    ]


def inconsistencies(
    vehicle: Vehicle, repair: Repair, effects: Mapping[str, str], speed: float
) -> tuple[Inconsistency, ...]:
    """One message for each edit of the repair.

    effects: by input, its main effect ("moves sway to the right (t 41)"), where that is clear. speed [m/s]: 90th
    percentile with the units that the file states.
    """
    return (
        *_units(repair, speed),
        *_poses(vehicle, repair),
        *_orders(vehicle, repair, effects),
        *_signs(vehicle, repair, effects),
    )


def _units(repair: Repair, speed: float) -> Iterator[Inconsistency]:
    *plane, angle = repair.units
    for unit in dict.fromkeys(u for u in plane if u):
        names = [name for name, u in zip(POSE[:2], plane, strict=True) if u == unit]
        verb, places = "are" if len(names) > 1 else "is", joined([f"pose: {n}" for n in names])
        text = (
            f"{joined(names)} {verb} in {UNIT_NAMES[unit]}: in the unit that the vehicle file "
            f"states the speed is {speed:.2g} m/s; set unit: {unit} at {places}"
        )
        yield Inconsistency(InconsistencyKind.LENGTH, text)
    if angle:
        text = (
            f"psi is in {UNIT_NAMES[angle]}: in this unit the heading agrees with the track; "
            f"set unit: {angle} at pose: psi"
        )
        yield Inconsistency(InconsistencyKind.ANGLE, text)


def _poses(vehicle: Vehicle, repair: Repair) -> Iterator[Inconsistency]:
    negated = [name for name, sign in zip(POSE, repair.pose_signs, strict=True) if sign < 0]
    columns = vehicle.file.pose.columns
    if negated == ["y", "psi"] and not (repair.exchanged or repair.turn):
        yield _handed(vehicle, negated)
        return
    if repair.exchanged:
        named = _label(columns["x"]) and _label(columns["y"])
        how = (
            f"exchange their entries under pose (x: {_label(columns['y'])}, y: {_label(columns['x'])})"
            if named
            else "under pose exchange the fields of the message (PoseStamped: "
            "x: {field: pose.position.y}, y: {field: pose.position.x})"
        )
        text = f"x and y are exchanged: with their columns swapped the track agrees with the heading; {how}"
        yield Inconsistency(InconsistencyKind.EXCHANGED, text)
    if repair.angle:
        yield _oblique(columns["psi"], repair)
    if repair.turn % 4:
        yield _heading(columns["psi"], repair)
        negated = [name for name in negated if name != "psi"]
    for name in negated:
        source = {"x": "y", "y": "x"}.get(name, name) if repair.exchanged else name
        text = (
            f"{name} has the wrong sign: negated, the track agrees with the heading; "
            f"set sign: {-columns[source].sign} at pose: {name}"
        )
        yield Inconsistency(InconsistencyKind.MIRRORED, text)


def _oblique(column: Column, repair: Repair) -> Inconsistency:
    """A zero of the heading that is off by any angle."""
    return Inconsistency(
        InconsistencyKind.HEADING,
        f"the heading's zero is off by {-repair.angle:.0f} deg: the inputs drive the boat in a direction that "
        "far from its heading, as where the axes of a tracker's rigid body do not lie along the boat; "
        f"set offset: {repaired_heading(column, repair).offset:.4g} at pose: psi",
    )


def _heading(column: Column, repair: Repair) -> Inconsistency:
    """Another zero of the heading, and perhaps another sense: a compass, a camera, another map."""
    angle = {1: 90, 2: 180, 3: -90}[repair.turn % 4]
    mirrored = repair.pose_signs[2] < 0
    changed = repaired_heading(column, repair)
    kind, sign = "has another zero", ""
    what = f"heading {'+' if angle > 0 else '-'} {abs(angle)} deg"
    if mirrored:
        kind, sign = f"{kind} and sense", f"sign: {changed.sign}, "
        what = f"{angle} deg - heading"
    is_compass = mirrored and angle == 90
    compass = " (as a compass: clockwise from north, and x is east)" if is_compass else ""
    return Inconsistency(
        InconsistencyKind.HEADING,
        f"the heading {kind}: with psi = {what} the track agrees with it{compass}; "
        f"set {sign}offset: {changed.offset:.9g} at pose: psi",
    )


def _handed(vehicle: Vehicle, negated: list[str]) -> Inconsistency:
    columns = vehicle.file.pose.columns
    signs = ", ".join(f"sign: {-columns[name].sign} at pose: {name}" for name in negated)
    return Inconsistency(
        InconsistencyKind.HANDED,
        "poses and commands have opposite axes: one is forward-right-down, the other "
        f"forward-left-up; if the poses are not {vehicle.axes.value}, set {signs}; "
        "else negate the commands of sway and yaw",
    )


def _orders(
    vehicle: Vehicle, repair: Repair, effects: Mapping[str, str]
) -> Iterator[Inconsistency]:
    names = vehicle.inputs
    for cycle in (c for c in cycles(repair.order) if len(c) > 1):
        labels = [names[i] for i in cycle]
        what = "swapped" if len(cycle) == 2 else "permuted"
        entries = ", ".join(
            f"{names[i]}: {_entry(vehicle, repair.order[i], repair.input_signs[i])}" for i in cycle
        )
        clear = "; ".join(f"{name} {effects[name]}" for name in labels if name in effects)
        text = (
            f"{joined(labels)} are {what}: {clear or 'exchanged, the boat moves as the vehicle file says'}; "
            f"exchange their entries at commands: inputs ({entries})"
        )
        yield Inconsistency(InconsistencyKind.PERMUTED, text)


def _signs(vehicle: Vehicle, repair: Repair, effects: Mapping[str, str]) -> list[Inconsistency]:
    own = zip(vehicle.inputs, repair.order, repair.input_signs, strict=True)
    negated = [name for i, (name, j, sign) in enumerate(own) if i == j and sign < 0]
    entries = vehicle.file.commands.inputs
    signs = {name: -as_column(entries[name]).sign for name in negated}
    if set(negated) == {"F_v", "F_r"} and repair.pose_edits == 0:
        text = (
            f"commands and poses have opposite axes: F_v {effects.get('F_v', UNCLEAR)}, "
            f"F_r {effects.get('F_r', UNCLEAR)}; one is "
            "forward-right-down, the other forward-left-up: "
            f"set sign: {signs['F_v']} at commands: inputs: F_v, sign: {signs['F_r']} at commands: "
            "inputs: F_r; or, if the poses are wrong, negate y and psi"
        )
        return [Inconsistency(InconsistencyKind.HANDED, text)]
    return [
        Inconsistency(
            InconsistencyKind.NEGATED,
            f"{name} {effects.get(name, 'acts')}, opposite to the vehicle file; "
            f"set sign: {signs[name]} at commands: inputs: {name}",
        )
        for name in negated
    ]


def _entry(vehicle: Vehicle, source: int, sign: int) -> str:
    """The column that an input should read, with its sign if that is -1."""
    column = as_column(vehicle.file.commands.inputs[vehicle.inputs[source]])
    return _label(column) + (" with sign: -1" if sign * column.sign < 0 else "")


def _label(column: Column) -> str:
    """The column of a table or the field of a message; both where the file names both."""
    index = "" if column.index is None else f"[{column.index}]"
    field = column.field and f"{column.topic}{' ' if column.topic else ''}{column.field}{index}"
    return " or ".join(dict.fromkeys(part for part in (column.column, field) if part))
