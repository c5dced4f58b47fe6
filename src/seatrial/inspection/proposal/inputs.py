# SPDX-License-Identifier: MIT
"""Actuation found in the data: which channel drives which axis, with sign, scale and weight."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.inspection.consistency.check import (
    ConsistencyReport,
    Gain,
    check_consistency,
    file_commands,
)
from seatrial.inspection.consistency.gains import read_runs
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.inspection.consistency.own_lags import own_gains
from seatrial.inspection.consistency.repair import ANGLES, later
from seatrial.inspection.consistency.steering_angle import steering_angles
from seatrial.inspection.proposal.actuation import Steered, steered, sticks, thrusters
from seatrial.inspection.proposal.by_name import named_sticks
from seatrial.inspection.proposal.channel_scales import idle_values, off_value, scale_of
from seatrial.inspection.proposal.channels import ALONE, AT_REST, Channels
from seatrial.inspection.proposal.columns.names import steers
from seatrial.inspection.proposal.command_sources import by_source
from seatrial.inspection.proposal.heading_zero import TurnedHeading, turned_heading
from seatrial.inspection.proposal.sources import Entries, Sources, place_of
from seatrial.io.reader import read
from seatrial.recording.delays import at_one_time
from seatrial.recording.recording import Recording
from seatrial.recording.undriven import without_undriven_ends
from seatrial.util.errors import RecordingError
from seatrial.util.format import joined
from seatrial.util.frames import AXES
from seatrial.util.progress import over, stage

MOST_TURNS = 3  # of the heading, one after the other: its sense, its zero, what is left of it
CLOCK_RISES = 0.9  # of the rows, above which a channel is a time or a counter
MOST_CHANNELS = 8  # inputs of a vehicle; of more channels those that change most often


@dataclass(frozen=True)
class Drive:
    """Inputs and forces, and what the data show about each."""

    inputs: Entries  # by name: the column
    remarks: dict[str, str]  # by name: what the data show
    forces: Entries  # empty: the inputs are F_u, F_v, F_r, and all are there
    thrusters: bool  # whether several channels drive an axis together
    undriven: tuple[str, ...]  # axes without a channel that drives them
    pose: dict[str, Any]  # columns, with units corrected
    lever: tuple[float, float] | None  # [m] of the measured point, in the file's axes
    findings: tuple[str, ...]  # corrected units
    sources: tuple[str, ...]  # what else commands the same actuators
    on_change: bool
    # a thrust and its angle; where sure, inputs and forces are theirs
    steered: Steered | None = None


def find_drive(
    sources: Sources, places: int, turns: int = MOST_TURNS, before: TurnedHeading | None = None
) -> Drive:
    """Inputs, signs, scales and units from the recording itself.

    places: how many positions are known; turns, before: of the heading, still allowed, and the last one.
    """
    # 1. Channels that change; units of the poses.
    with stage("channels", 0.4):
        names, disarmed = _changing_channels(sources)
        sources = replace(sources, channels={**sources.channels, **disarmed})
    with stage("sources", 0.2):
        names, others = _one_source(sources, names)
    with stage("units and signs", 0.4):
        pose, corrected, report = _units(sources, names)
    draft = _draft(sources, pose, names)
    with stage("scales"):
        recordings = _read(sources, draft)
    # 2. Offsets, scales and gains of the channels.
    channels = _channels(sources, draft, recordings, report.table)
    angle = 0.0 if before is None else before.angle
    turned = turned_heading(pose, channels, report, angle) if turns else None
    if turned is not None and turned.pose != pose:
        sources = replace(sources, pose=turned.pose)
        found = find_drive(sources, places, turns - 1, turned)
        # an angle is stated once, with what was left of it
        own = () if turned.angle else (turned.text,)
        return replace(found, findings=(*own, *corrected, *found.findings))
    told = [each.text for each in (before if angle else None, turned) if each is not None]
    corrected = [*told, *corrected]
    # 3. Inputs and forces: sums of thrusters, one stick an axis, or a thrust and its angle; by their names without
    # any motion.
    if channels.shared:
        channels = _with_own_gains(channels, draft, recordings, report)
    parts = (thrusters if channels.shared else sticks)(channels)
    steer = None if places else steered(channels)
    is_steered = steer is not None and steer.sure
    if steer is not None and is_steered:
        parts = steer.parts
    if not parts[0] and places == len(channels.names):
        parts = dict(channels.columns), dict.fromkeys(channels.names, "thruster, as given"), {}
    inputs, remarks, forces = parts if parts[0] else named_sticks(recordings, channels)
    # 4. Axes without a drive; commands that are written only on change.
    # the force across of an angle turns the boat, too
    driven = set(AXES) if is_steered else {f["axis"] for f in forces.values()}
    on_change = any(s.on_change for r in recordings for s in r.streams if s.role == "commands")
    return Drive(
        inputs, remarks, forces if channels.shared or len(forces) < len(AXES) else {},
        channels.shared, tuple(axis for axis in AXES if axis not in driven), pose,
        None if is_steered else channels.lever, tuple(corrected), others, on_change, steer,
    )  # fmt: skip


def _one_source(sources: Sources, names: list[str]) -> tuple[list[str], tuple[str, ...]]:
    """Channels of the source that moves the boat more, where a pilot and an autopilot command the same
    actuators; and a comment on the other one. Both where they take turns: their sum is the command."""
    groups = by_source(names)
    if not groups or _take_turns(sources, names, groups):
        return names, ()
    t = [_largest_t(sources, group) for group in groups]
    most, least = (0, 1) if t[0] >= t[1] else (1, 0)
    other = [name for name in groups[least] if name not in groups[most]]
    places = ",".join("/".join(place_of(sources.channels[name])) for name in groups[least])
    return list(groups[most]), (
        f"check: {joined(other)} command the same actuators, and move the boat no more (t {t[least]:.0f} against "
        f"{t[most]:.0f}):",
        "leave out the seconds in which they drive, --without NAME=FROM-TO; or propose them,",
        f"--commands {places}",
    )


def _take_turns(sources: Sources, names: Sequence[str], groups: Sequence[Sequence[str]]) -> bool:
    """Whether each source is at rest while the other one drives."""
    draft = _draft(sources, sources.pose, names)
    recordings = _read(sources, draft)
    driven = _channels(sources, draft, recordings, ()).driven
    pairs = (groups, groups[::-1])
    own = [[n in group and n not in other for n in names] for group, other in pairs]
    first, second = (driven[:, mask].any(axis=1) for mask in own)
    return bool((first & second).mean() < ALONE)


def _largest_t(sources: Sources, names: Sequence[str]) -> float:
    """Of the gains of these channels alone, over all axes."""
    table = _units(sources, names)[2].table
    return max((abs(gain.t) for gain in table), default=0.0)


def _units(
    sources: Sources, names: Sequence[str]
) -> tuple[dict[str, Any], list[str], ConsistencyReport]:
    """The poses' columns with units corrected, remarks on these, and the consistency report."""
    pose = dict(sources.pose)
    draft = _draft(sources, pose, names)
    with stage("", 0.3):
        recordings = _read(sources, draft)
    report = check_consistency(recordings, draft)
    corrected = []
    for key, unit in zip(("x", "y", "psi"), report.repair.units, strict=True):
        if unit is not None and (key in pose or "latitude" not in pose):
            pose[key] = _in_unit(dict(pose.get(key, {})), unit)
            corrected.append(f"{key} is in {unit}, by the motion of the boat")
    if report.repair.late:
        pose["delay"], pose["heading_delay"] = later(draft.delays, report.repair.late)
        corrected.append(
            f"positions and headings are {abs(report.repair.late):.1f} s apart, by the motion of the boat: "
            "delay and heading_delay say so"
        )
    if corrected:
        draft = _draft(sources, pose, names)
        report = check_consistency(_read(sources, draft), draft)
    changed = [f.text for f in report.findings if f.kind is InconsistencyKind.CHANGED]
    return pose, [*corrected, *(f"check: {text}" for text in changed)], report


def _in_unit(entry: dict[str, Any], unit: str) -> dict[str, Any]:
    """A column with another unit; the offset of an angle, which is one of its zero, with it."""
    before = ANGLES.get(entry.get("unit", "rad"))
    turned = {}
    if entry.get("offset") and before and unit in ANGLES:
        turned["offset"] = round(entry["offset"] * before / ANGLES[unit], 9)
    return entry | {"unit": unit} | turned


def _read(sources: Sources, draft: Vehicle) -> list[Recording]:
    paths = (sources.path, *sources.more)
    return [read(path, draft, salvage=sources.salvage) for path in over(paths)]


def _draft(sources: Sources, pose: Mapping[str, Any], names: Sequence[str]) -> Vehicle:
    """A provisional vehicle, to read the channels."""
    content = {
        "seatrial": "vehicle 1",
        "name": sources.name,
        "axes": sources.axes,
        "pose": dict(pose),
        "commands": {**sources.commands, "inputs": {n: sources.channels[n] for n in names}},
        "forces": {"F_u": {"axis": "surge", "of": {names[0]: 1.0}}},
        "structure": {"surge": ["X_u * u", "X_F * F_u"], "sway": ["Y_v * v"], "yaw": ["N_r * r"]},
    }
    return vehicle_from(content, f"the draft for {sources.path}")


def _changing_channels(sources: Sources) -> tuple[list[str], Entries]:
    """Channels that change, the most active ones; and entries of those that have a value for `off`."""
    changes: dict[str, int] = {}
    disarmed: Entries = {}
    names = [*sources.channels]
    for i in over(range(0, len(names), MOST_CHANNELS)):
        part = _draft(sources, sources.pose, names[i : i + MOST_CHANNELS])
        recordings = _read(sources, part)
        values = np.concatenate([r.commands.values for r in recordings]) * part.input_signs
        for name, raw in zip(part.inputs, values.T, strict=True):
            off = off_value(raw)
            if off is not None:
                scale = scale_of(raw[raw != off], sources.full)
                disarmed[name] = sources.channels[name] | scale | {"off": off}
        for recording in recordings:
            steps = np.diff(recording.commands.values * part.input_signs, axis=0)
            clocks = (steps > 0).sum(axis=0) > CLOCK_RISES * len(steps)
            counts = np.where(clocks, 0, (steps != 0).sum(axis=0))
            for name, count in zip(part.inputs, counts.tolist(), strict=True):
                changes[name] = changes.get(name, 0) + count
    kept = sorted((n for n in names if changes[n]), key=lambda n: -changes[n])[:MOST_CHANNELS]
    if not kept:
        raise RecordingError(
            f"{sources.path}: no command ever changes; record while the boat is driven"
        )
    entries = {name: entry for name, entry in disarmed.items() if name in kept}
    return [name for name in names if name in kept], entries


def _with_own_gains(
    channels: Channels, draft: Vehicle, recordings: Sequence[Recording], report: ConsistencyReport
) -> Channels:
    """The channels with gains at each one's own delay and lag, where these differ: slow is not weak."""
    if report.search is None or report.search.mirrored:
        return channels
    whole = [without_undriven_ends(at_one_time(recording)) for recording in recordings]
    runs = read_runs(whole, [file_commands(draft, r) for r in whole])
    own = own_gains(runs)
    if own is None:
        return channels
    common = np.array([gain.value for gain in report.table]).reshape(own.T.shape).T
    known = common != 0.0
    factor = np.divide(own, common, out=np.ones_like(own), where=known)
    return replace(channels, gains=channels.gains * factor)


def _channels(
    sources: Sources, draft: Vehicle, recordings: Sequence[Recording], table: Sequence[Gain]
) -> Channels:
    signals = [recording.commands for recording in recordings]
    names = signals[0].names
    values = np.concatenate([signal.values for signal in signals])
    raw = values * draft.input_signs
    # an angle has any value at rest
    turns = [steers(" ".join((n, *place_of(sources.channels[n])))) for n in names]
    own_motion = [without_undriven_ends(recording) for recording in recordings]
    idle = np.where(turns, np.nan, idle_values(own_motion) * draft.input_signs).tolist()
    scales = [
        {} if "off" in sources.channels[n] else scale_of(raw[:, i], sources.full, idle[i])
        for i, n in enumerate(names)
    ]
    t, gains = np.zeros((3, len(names))), np.zeros((3, len(names)))
    for gain in table:
        i = names.index(gain.input)
        turn = -1.0 if sources.axes == "forward-right-down" and gain.axis > 0 else 1.0
        t[gain.axis, i] = turn * gain.t
        gains[gain.axis, i] = turn * gain.value
    columns = {n: sources.channels[n] | s for n, s in zip(names, scales, strict=True)}
    sizes = np.array([s.get("scale", 1.0) for s in scales])
    spread = values.std(axis=0) / sizes
    rests = np.array([s.get("offset", 0.0) for s in scales])
    driven = np.abs(raw - rests) > AT_REST * sizes
    # as commands, 0 at rest
    own = [replace(s, values=(s.values * draft.input_signs - rests) / sizes) for s in signals]
    angles = steering_angles(read_runs(recordings, own), t)
    signs = dict(zip(names, draft.input_signs.tolist(), strict=True))
    turn = -1.0 if sources.axes == "forward-right-down" else 1.0
    angles = {
        n: replace(a, t=turn * signs[n] * (1.0 if a.flow else signs[a.thrust]) * a.t)
        for n, a in angles.items()
    }
    return Channels(names, columns, t, gains * sizes, spread, driven, angles)
