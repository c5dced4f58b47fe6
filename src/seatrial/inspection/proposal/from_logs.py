# SPDX-License-Identifier: MIT
"""Topics of an autopilot's log that are the poses and the commands, by the messages that it is known to write."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from seatrial.inspection.proposal.from_topics import (
    STAMP,
    LogTopics,
    given_commands,
    given_keys,
    given_pose,
    is_whole,
)
from seatrial.inspection.proposal.log_candidates import (
    LEAST_HEADINGS,
    LEAST_POSITIONS,
    Candidate,
    Found,
)
from seatrial.inspection.proposal.log_motors import as_motors, find_motors, topics_of
from seatrial.inspection.proposal.servo_parameters import Motor, full_angle
from seatrial.inspection.proposal.sources import (
    Ask,
    Choices,
    Recognised,
    Sources,
    Sureness,
    choose,
    named,
)
from seatrial.io.columns import TableSeen
from seatrial.io.formats import open_log
from seatrial.io.formats.known import HEADINGS, POSITIONS, VOLTAGES, YAW_RATES, Known
from seatrial.io.log import LogTopic
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Axes, Stamps
from seatrial.util.progress import stage

LEAST_FALL = 0.02  # of the battery's voltage, 5th to 95th percentile, for a scale
OPENED, READ = 0.15, 0.2  # of the time of `init`


def of_log(path: Path, name: str, choices: Choices, ask: Ask | None) -> Sources:
    """Topics of position, heading, yaw rate and motors. Raises RecordingError, FileError."""
    with stage("messages", OPENED):
        log = open_log(path)
    # 1. All known signals that change, read in one pass.
    with stage("signals", READ):
        found = Found(log)
    # 2. A position, raw before filtered, and a heading; or those that the user names.
    axes = Axes(choices.axes)
    pose, rows, stamps, why = _chosen_pose(found, choices, ask)
    # 3. Motors that the user names, by the parameters, else all outputs that change.
    given = None if choices.commands is None else given_commands(LogTopics(log), choices.commands)
    driven = [] if given else find_motors(log, choices, ask)
    if given:
        commands, channels = {"topic": given[0]}, as_motors(log, *given)
    voltage = _voltage(found)
    if not given:
        channels = named((m.name, {"topic": t.name, **m.column}) for t, m in driven)
        commands = {"topic": driven[0][0].name}
    for column in channels.values():
        if column.get("topic") == commands["topic"]:
            column.pop("topic")
    length = (int(stamps.max()) - int(stamps.min())) * 1e-9
    recognised = (*rows, *_recognised_drive(found, driven, channels if given else {}, voltage))
    return Sources(
        path, name, axes.value, length, pose, commands, channels,
        {"known axes": [_axes_note(axes)], "pose": [why], "commands": [], "scales": _scales(voltage)},
        recognised=recognised, full_angle=full_angle(log),
    )  # fmt: skip


def _chosen_pose(
    found: Found, choices: Choices, ask: Ask | None
) -> tuple[dict[str, Any], tuple[Recognised, ...], Stamps, str]:
    """The pose's entries, how they were recognised, stamps [ns] of the positions, and a note."""
    fields = given_keys(choices.pose)
    topics = LogTopics(found.log)
    if is_whole(fields):
        entries, rows, seen = given_pose(topics, choices, {})
        return entries, rows, _nanoseconds(seen), "--pose"
    position = _position(found, replace(choices, pose=None) if fields else choices, ask)
    heading = _best(found, HEADINGS, "heading", LEAST_HEADINGS)
    rate = next(iter(found.of(YAW_RATES, 1)), None)
    entries = _pose(position, heading, rate, Axes(choices.axes))
    rows = _recognised(found, position, heading, rate)
    if not fields:
        return entries, rows, position.samples.stamps, position.why
    entries, more, seen = given_pose(topics, choices, entries)
    signals = {"position" if r.signal not in {"heading", "yaw rate"} else r.signal for r in more}
    kept = tuple(r for r in rows if r.signal not in signals)
    return entries, (*more, *kept), _nanoseconds(seen), "--pose"


def _nanoseconds(seen: TableSeen) -> Stamps:
    """Stamps (n,) [ns] from the first one on."""
    return np.rint(seen.numbers(STAMP) * 1e9).astype(np.int64)


def _position(found: Found, choices: Choices, ask: Ask | None) -> Candidate:
    able = found.of(POSITIONS, LEAST_POSITIONS)
    if choices.pose is not None:
        for candidate in able:
            if candidate.topic.name == choices.pose:
                return candidate
        listed = "; ".join(c.shown for c in able) or "none"
        raise RecordingError(
            f"{found.log.path}: {choices.pose} is no topic with a position that changes (--pose); "
            f"those are {listed}"
        )
    if not able:
        held = found.counted(POSITIONS)
        what = (
            f"fewer than {LEAST_POSITIONS} different positions, which a boat that is driven has: {held} (no fix?)"
            if held
            else "no message with a position that is known by its name"
        )
        raise RecordingError(
            f"{found.log.path}: {what}; record with a GNSS receiver that has a fix, or with an external position. "
            f"The topics are {topics_of(found.log)}"
        )
    first = able[0].known.what  # the same kind of sensor: the best fix, then the fastest
    alike = [c for c in able if c.known.what == first]
    best = max(alike, key=lambda c: (c.fix, c.rate))
    if ask is not None and len(able) > 1:
        ordered = [best, *(c for c in able if c is not best)]
        texts = [f"{c.topic.name} ({c.why})" for c in ordered]
        return ordered[texts.index(choose(found.log.path, "poses", texts, ask))]
    return best


def _best(found: Found, known: Sequence[Known], what: str, least: int) -> Candidate:
    able = found.of(known, least)
    if not able:
        held = found.counted(known)
        few = f", {least} different values at least" + f" ({held})" * bool(held)
        raise RecordingError(
            f"{found.log.path}: no message with a {what} that changes{few}; record the attitude while the boat is "
            f"driven. The topics are {topics_of(found.log)}"
        )
    return able[0]


# Poses #


def _pose(
    position: Candidate, heading: Candidate, rate: Candidate | None, axes: Axes
) -> dict[str, Any]:
    """The pose as the vehicle file states it."""
    first, second = ({"field": f, **position.known.column} for f in position.known.fields)
    if position.known.geographic:
        pose: dict[str, Any] = {"latitude": first, "longitude": second}
    else:
        pose = {"x": first, "y": second} if axes is Axes.FRD else {"x": second, "y": first}
    psi = _elsewhere(heading, position)
    if len(heading.known.fields) > 1:
        psi["quaternion"] = list(heading.known.fields)
    else:
        psi["field"] = heading.known.fields[0]
    psi |= heading.known.column
    if axes is Axes.FLU:  # from east counter-clockwise
        quarter = 90.0 if psi.get("unit") == "deg" else pi / 2
        psi |= {"sign": -1, "offset": round(quarter * psi.get("scale", 1.0), 9)}
    pose = {"topic": position.topic.name, **pose, "psi": psi}
    if rate is not None:
        turned = {} if axes is Axes.FRD else {"sign": -1}
        own = {"field": rate.known.fields[0], **rate.known.column, **turned}
        pose["yaw_rate"] = _elsewhere(rate, position) | own
    return pose


def _elsewhere(candidate: Candidate, position: Candidate) -> dict[str, Any]:
    same = candidate.topic.name == position.topic.name
    return {} if same else {"topic": candidate.topic.name}


def _axes_note(axes: Axes) -> str:
    if axes is Axes.FRD:
        return "the log's own: x north, y east, psi clockwise from north"
    return "x east, y north; the log's heading is from north clockwise"


# Commands #


def _voltage(found: Found) -> Candidate | None:
    """The battery's voltage, where it falls enough to matter."""
    for candidate in found.of(VOLTAGES, 3):
        low, middle, high = _range(candidate)
        if middle > 0 and (high - low) / middle > LEAST_FALL:
            return candidate
    return None


def _range(voltage: Candidate) -> Array:
    """5th, 50th and 95th percentiles of the voltage as logged, where it is above 0; 0: it never is."""
    values = voltage.samples.values[:, 0]
    values = values[np.isfinite(values) & (values > 0)]
    return np.percentile(values, [5, 50, 95]) if len(values) else np.zeros(3)


def _scales(voltage: Candidate | None) -> list[str]:
    """Lines of the vehicle file that state the battery as a scale."""
    if voltage is None:
        return []
    scale = voltage.known.column.get("scale")
    low, middle, high = _range(voltage) / (scale or 1.0)
    raw = "" if scale is None else f", scale: {scale:g}"
    return [
        f"# The battery's voltage was {low:.3g} to {high:.3g} V; thrust changes about with its square.",
        "scales:",
        f"  battery: {{column: {{topic: {voltage.topic.name}, field: {voltage.known.fields[0]}{raw}}}, "
        f"reference: {middle:.3g}}}",
    ]


# What was recognised #


def _recognised(
    found: Found, position: Candidate, heading: Candidate, rate: Candidate | None
) -> tuple[Recognised, ...]:
    rows = [
        _row(found, "position", position, POSITIONS, LEAST_POSITIONS),
        _row(found, "heading", heading, HEADINGS, LEAST_HEADINGS),
    ]
    if rate is not None:
        rows.append(_row(found, "yaw rate", rate, YAW_RATES, 1))
    return tuple(rows)


def _row(
    found: Found, signal: str, chosen: Candidate, known: Sequence[Known], least: int
) -> Recognised:
    others = [c for c in found.of(known, least) if c is not chosen]
    names = tuple(f"{c.topic.name} ({c.known.what})" for c in others)
    return Recognised(signal, chosen.shown, chosen.why, Sureness.CERTAIN, names)


def _recognised_drive(
    found: Found,
    driven: Sequence[tuple[LogTopic, Motor]],
    given: Mapping[str, dict[str, Any]],
    voltage: Candidate | None,
) -> Iterator[Recognised]:
    for topic, motor in driven:
        sure = Sureness.GUESS if motor.why.startswith("changes") else Sureness.CERTAIN
        shown = f"{topic.name} {motor.column['field']}"
        yield Recognised(motor.name, shown, motor.why, sure)
    for name, column in given.items():
        yield Recognised(name, str(column["field"]), "--commands", Sureness.CHOSEN)
    if voltage is not None:
        yield _row(found, "battery", voltage, VOLTAGES, 3)
