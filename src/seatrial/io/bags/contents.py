# SPDX-License-Identifier: MIT
"""The contents of a bag by topic, before there is a vehicle file."""

import struct
from array import array
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from seatrial.io.bags.bag import DEFINED, Bag, Topic
from seatrial.io.bags.poses import orientation_paths, pose_paths
from seatrial.io.bags.tf import is_tf
from seatrial.recording.clocks import clock_verdicts
from seatrial.recording.timing import STREAM_HEAD, Clock, Stream, describe, stream_cells
from seatrial.util.format import table

COMMAND_TYPES = (
    "sensor_msgs/msg/Joy", "geometry_msgs/msg/Wrench", "geometry_msgs/msg/WrenchStamped",
    "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped", "std_msgs/msg/Float32",
    "std_msgs/msg/Float64", "std_msgs/msg/Float32MultiArray", "std_msgs/msg/Float64MultiArray",
    "std_msgs/msg/Int16MultiArray", "std_msgs/msg/UInt16MultiArray", "mavros_msgs/msg/RCOut",
    "mavros_msgs/msg/RCIn", "mavros_msgs/msg/OverrideRCIn", "mavros_msgs/msg/ManualControl",
)  # fmt: skip
POSITION_TYPES = ("sensor_msgs/msg/NavSatFix",)
NUMBER_TYPES = ("std_msgs/msg/Float32", "std_msgs/msg/Float64")
HEADING_WORDS = ("heading", "compass", "hdg")
COMMAND_WORDS = ("thrust", "command", "cmd", "pwm", "control", "motor", "actuator", "wrench", "tau")
# how fields of any type are named
FIELDS = {"poses": "--pose x=TOPIC/FIELD,...", "commands": "--commands NAME=TOPIC/FIELD,..."}
MOST_TYPES = 4  # in a message
# [bytes] of a header's time: after ROS 1's sequence number, after CDR's first four
STAMP_OFFSET = 4


@dataclass(frozen=True)
class Entry:
    """One topic."""

    topic: Topic
    role: str  # poses, positions, headings, commands, or empty
    stream: Stream


@dataclass(frozen=True)
class Contents:
    """A bag's topics."""

    path: Path
    kind: str
    length: float  # [s] from the first to the last arrival
    entries: tuple[Entry, ...]
    remarks: tuple[str, ...]

    def of(self, role: str) -> list[Entry]:
        """Topics of a role, those with most messages first."""
        found = [e for e in self.entries if e.role == role and e.stream.count > 1]
        return sorted(found, key=lambda e: -e.stream.count)

    def anything_readable(self) -> bool:
        """False: there are topics, and the bag has a definition of none."""
        return not self.entries or any(e.topic.readable for e in self.entries)

    def unreadable(self) -> str:
        """Types that the bag does not define, and what to do; empty: it defines all."""
        types = sorted({e.topic.type for e in self.entries if not e.topic.readable})
        if not types:
            return ""
        more = f" and {len(types) - MOST_TYPES} more types" if len(types) > MOST_TYPES else ""
        shown = ", ".join(types[:MOST_TYPES])
        return f"the bag has no definition of {shown}{more}: their fields can't be read; {DEFINED}"


@dataclass
class _Times:
    stamped: bool
    arrival: "array[int]" = field(default_factory=lambda: array("q"))
    header: "array[int]" = field(default_factory=lambda: array("q"))


def contents(bag: Bag, path: Path) -> Contents:
    """Rates, gaps and clocks of every topic of the bag at a path. Raises RecordingError."""
    times = {name: _Times(_begins_with_header(topic)) for name, topic in bag.topics.items()}
    for name, arrival, raw in bag.messages(times.keys()):
        mine = times[name]
        mine.arrival.append(arrival)
        if mine.stamped and len(raw) >= STAMP_OFFSET + 8:
            order = ">" if bag.topics[name].cdr and raw[1:2] == b"\0" else "<"
            seconds, nanoseconds = struct.unpack_from(f"{order}iI", raw, STAMP_OFFSET)
            mine.header.append(seconds * 10**9 + nanoseconds)
    entries = [_entry(bag, name, found) for name, found in sorted(times.items())]
    begins = [t.arrival[0] for t in times.values() if t.arrival]
    ends = [t.arrival[-1] for t in times.values() if t.arrival]
    length = (max(ends) - min(begins)) * 1e-9 if begins else 0.0
    return Contents(path, bag.kind, length, tuple(entries), bag.remarks)


def contents_text(found: Contents) -> str:
    """The topics as a table, and the next step."""
    lines = [f"{found.path}: {found.kind}, {found.length:.1f} s, {len(found.entries)} topics"]
    head = ("topic", "type", *STREAM_HEAD, "stamps", "could be")
    lines.append(table(head, [_row(entry) for entry in found.entries], text=(0, 1, 5, 6)))
    streams = [entry.stream for entry in found.entries if entry.role and entry.stream.count > 1]
    lines += [f"  => {remark}" for remark in (*found.remarks, *clock_verdicts(streams))]
    placed = bool(found.of("poses") or (found.of("positions") and found.of("headings")))
    missing = [*["poses"] * (not placed), *["commands"] * (not found.of("commands"))]
    for role in missing:
        fields = f"init takes fields of any type ({FIELDS[role]}). " * found.anything_readable()
        lines.append(
            f"  => no topic looks like {role} by its type. {fields}docs/recording.md says what to record"
        )
    if missing and found.unreadable():
        lines.append(f"  => {found.unreadable()}")
    return "\n".join(lines)


def contents_json(found: Contents) -> dict[str, Any]:
    """The same as JSON."""
    return {
        "path": str(found.path),
        "kind": found.kind,
        "length": found.length,
        "topics": [
            {**msgspec.to_builtins(e.stream), "role": e.role or None} for e in found.entries
        ],
        "remarks": list(found.remarks),
    }


def _row(entry: Entry) -> tuple[str, ...]:
    stream, delay = entry.stream, entry.stream.delay
    clock = stream.clock.value
    if delay is not None:
        clock += f", {delay}"
    return entry.topic.name, entry.topic.type, *stream_cells(stream), clock, entry.role


def _entry(bag: Bag, name: str, times: _Times) -> Entry:
    topic = bag.topics[name]
    arrival = np.array(times.arrival, dtype=np.int64)
    header = np.array(times.header, dtype=np.int64)
    clock, stamps = Clock.TRANSFORMS if is_tf(topic) else Clock.ARRIVAL, arrival
    if times.stamped and len(header) == len(arrival):
        clock = Clock.HEADER if header.any() else Clock.ZERO
        stamps = header if header.any() else arrival
    role = _role(topic)
    stream = describe(
        role, name, topic.type, clock=clock, stamps=stamps, arrival=arrival,
        publishers=topic.publishers,
    )  # fmt: skip
    return Entry(topic, role, stream)


def _begins_with_header(topic: Topic) -> bool:
    if not topic.readable:
        return False
    fields = topic.wire.definitions[topic.type_name][1]
    return topic.wire.stamped and bool(fields) and fields[0][0] == "header"


def _role(topic: Topic) -> str:
    """The probable role of a topic: that of the first kind it is of."""
    if not topic.readable:
        return ""
    wire = topic.wire
    name = topic.name.lower()
    commanded = any(word in f"{name} {topic.type.lower()}" for word in COMMAND_WORDS)
    compass = topic.type_name in NUMBER_TYPES and any(word in name for word in HEADING_WORDS)
    kinds = (
        (topic.type_name in POSITION_TYPES, "positions"),
        (compass, "headings"),
        (topic.type_name in COMMAND_TYPES, "commands"),
        (is_tf(topic), "" if name.endswith("_static") else "poses"),
        (pose_paths(wire) is not None, "poses"),
        (bool(orientation_paths(wire)), "headings"),
        (commanded and bool(wire.paths()), "commands"),
    )
    return next((role for is_one, role in kinds if is_one), "")
