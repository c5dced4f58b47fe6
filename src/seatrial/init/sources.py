# SPDX-License-Identifier: MIT
"""Which topics or columns are the poses and the commands."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from seatrial.errors import RecordingError
from seatrial.io.bags import is_bag
from seatrial.io.channels import number_fields, tf_frames
from seatrial.io.columns import ColumnView, TableView, look_at_columns
from seatrial.io.contents import Contents, Entry, contents
from seatrial.io.from_bag import recording_name
from seatrial.streams import rhythm

Ask = Callable[[str, Sequence[str]], str]
LIKELY_POSES = ("slam", "mocap", "vicon", "qualisys", "optitrack", "vrpn", "amcl", "pose", "odom")
BODY_FRAMES = ("base_link", "base_footprint", "base", "body")
WORLD_FRAMES = ("map", "world", "odom")
PLANAR = {  # the numbers that matter of messages with more
    "geometry_msgs/msg/Wrench": ("force.x", "force.y", "torque.z"),
    "geometry_msgs/msg/WrenchStamped": ("wrench.force.x", "wrench.force.y", "wrench.torque.z"),
    "geometry_msgs/msg/Twist": ("linear.x", "linear.y", "angular.z"),
    "geometry_msgs/msg/TwistStamped": ("twist.linear.x", "twist.linear.y", "twist.angular.z"),
    "mavros_msgs/msg/ManualControl": ("x", "y", "z", "r"),
}
TIME_NAMES = ("t", "time", "stamp", "timestamp", "sec", "seconds", "ms", "ns")
POSE_NAMES = {
    "x": ("x", "pos_x", "position_x", "north", "px"),
    "y": ("y", "pos_y", "position_y", "east", "py"),
    "psi": ("psi", "yaw", "heading", "theta", "hdg"),
}
NOT_COMMANDS = ("z", "phi", "theta", "roll", "pitch", "u", "v", "r", "w", "p", "q")


@dataclass(frozen=True)
class Choices:
    """What the user said already."""

    name: str | None = None
    axes: str = "forward-left-up"
    pose: str | None = None  # topic
    commands: str | None = None  # topic
    parent: str | None = None
    child: str | None = None


@dataclass(frozen=True)
class Sources:
    """Where poses and channels come from, in the vehicle file's terms."""

    path: Path
    name: str
    axes: str
    length: float  # [s]
    pose: dict[str, Any]
    commands: dict[str, Any]  # without inputs
    channels: dict[str, dict[str, Any]]  # by plain name: the column
    notes: dict[str, list[str]] = field(default_factory=dict)  # comments, by key


def find_sources(path: Path, choices: Choices, ask: Ask | None, *, salvage: bool) -> Sources:
    """Poses and commands of a bag or of tables. Raises RecordingError, FileError."""
    name = choices.name or recording_name(path)
    if is_bag(path):
        return _of_bag(path, name, choices, ask, salvage=salvage)
    return _of_tables(path, name, choices)


def _of_bag(path: Path, name: str, choices: Choices, ask: Ask | None, *, salvage: bool) -> Sources:
    found = contents(path, salvage=salvage)
    chosen = _one(found, "poses", choices.pose, ask, _likely_poses(found.of("poses")))
    pose: dict[str, Any] = {"topic": chosen.topic.name}
    if chosen.topic.type_name.endswith(("TFMessage", "tfMessage")):
        pose |= _frames(path, chosen.topic.name, choices, salvage=salvage)
    driving = _one(found, "commands", choices.commands, ask, found.of("commands"))
    siblings = _siblings(found, driving)
    commands: dict[str, Any] = {"topic": driving.topic.name}
    channels = _channels(path, driving, salvage=salvage)
    if len(siblings) > 1:  # a topic for each thruster
        commands = {}
        channels = {
            _plain(entry.topic.name): column | {"topic": entry.topic.name}
            for entry in siblings
            for column in _channels(path, entry, salvage=salvage).values()
        }
    notes = {
        "pose": _notes(found, chosen, "poses"),
        "commands": _notes(found, driving, "commands", len(siblings)),
    }
    return Sources(path, name, choices.axes, found.length, pose, commands, channels, notes)


def _one(
    found: Contents, role: str, given: str | None, ask: Ask | None, likely: list[Entry]
) -> Entry:
    """The topic that plays a role: the one given, the only one, or the one that is answered."""
    option = "--pose" if role == "poses" else "--commands"
    if given is not None:
        for entry in found.entries:
            if entry.topic.name in (given, f"/{given}"):
                return entry
        listed = "; ".join(f"{e.topic.name} ({e.topic.type})" for e in found.entries)
        raise RecordingError(f"{found.path}: no topic {given} ({option}); the topics are {listed}")
    if not likely:
        listed = "; ".join(f"{e.topic.name} ({e.topic.type})" for e in found.entries) or "none"
        raise RecordingError(
            f"{found.path}: no topic looks like {role}; if one is, name it with {option}. "
            f"The topics are {listed}"
        )
    if len(likely) == 1 or (role == "commands" and len(_siblings(found, likely[0])) == len(likely)):
        return likely[0]
    names = [e.topic.name for e in likely]
    if ask is None:
        raise RecordingError(
            f"{found.path}: several topics could be the {role}: {', '.join(names)}; name one with "
            f"{option} (two robots? then record them apart, or keep to the topics of one)"
        )
    answer = ask(f"Which topic has the {role} of the boat?", names)
    return likely[names.index(answer)]


def _likely_poses(entries: list[Entry]) -> list[Entry]:
    """Poses of the most telling name; tf only where there is nothing else."""
    plain = [e for e in entries if not e.topic.type_name.endswith(("TFMessage", "tfMessage"))]
    for word in LIKELY_POSES:
        named = [e for e in plain if word in e.topic.name.lower()]
        if named:
            return named
    return plain or entries


def _siblings(found: Contents, driving: Entry) -> list[Entry]:
    """Topics of the same type, of one number each, that belong to one boat: a thruster each."""
    if not driving.topic.type_name.startswith(("std_msgs/msg/Float", "std_msgs/msg/Int")):
        return [driving]
    if "Array" in driving.topic.type_name:
        return [driving]
    return [e for e in found.of("commands") if e.topic.type_name == driving.topic.type_name]


def _channels(path: Path, entry: Entry, *, salvage: bool) -> dict[str, dict[str, Any]]:
    fields = number_fields(path, entry.topic.name, salvage=salvage)
    wanted = PLANAR.get(entry.topic.type_name)
    kept = [f for f in fields if wanted is None or f in wanted]
    if not kept:
        raise RecordingError(f"{path}: {entry.topic.name} ({entry.topic.type}) holds no numbers")
    return {_plain(f): {"field": f} for f in kept}


def _frames(path: Path, topic: str, choices: Choices, *, salvage: bool) -> dict[str, str]:
    """Parent and child: as given, or by the usual names."""
    edges = tf_frames(path, topic, salvage=salvage)
    frames = {f for parent, child, _ in edges for f in (parent, child)}
    parent = choices.parent or next((f for f in WORLD_FRAMES if f in frames), None)
    child = choices.child or next((f for f in BODY_FRAMES if f in frames and f != parent), None)
    if parent is None or child is None:
        listed = ", ".join(f"{p} -> {c}{' (moves)' if m else ''}" for p, c, m in edges)
        raise RecordingError(
            f"{path}: {topic} has the transforms {listed}; name the world's frame with --parent and the "
            f"boat's with --child"
        )
    return {"parent": parent, "child": child}


def _notes(found: Contents, chosen: Entry, role: str, own: int = 1) -> list[str]:
    stream = chosen.stream
    said = [f"{chosen.topic.type}, {rhythm(stream)}, stamps: {stream.clock.value}"]
    others = [e.topic for e in found.of(role) if e.topic.name != chosen.topic.name]
    if others and own == 1:
        said.append("could also be: " + ", ".join(f"{t.name} ({t.type})" for t in others[:6]))
    return said


def _of_tables(path: Path, name: str, choices: Choices) -> Sources:
    tables = look_at_columns(path)
    poses = next(
        (t for t in tables if _named(t, POSE_NAMES["psi"]) and _named(t, POSE_NAMES["x"])), None
    )
    if poses is None:
        listed = "; ".join(f"{t.path}: {', '.join(c.name for c in t.columns)}" for t in tables)
        raise RecordingError(
            f"{path}: no table has columns named like x, y and psi (or yaw, heading); rename them, or "
            f"write the vehicle file by hand (docs/vehicle.md). There are {listed[:400]}"
        )
    driven = next((t for t in tables if t is not poses), poses)
    pose: dict[str, Any] = {"stamp": _stamp(poses)}
    for key, names in POSE_NAMES.items():
        column = _named(poses, names)
        if column is None:
            raise RecordingError(
                f"{poses.path}: no column for {key}, named like {', '.join(names)}"
            )
        pose[key] = {"column": column.name}
    commands: dict[str, Any] = {"stamp": _stamp(driven)}
    if len(tables) > 1:
        pose["file"], commands["file"] = Path(poses.path).name, Path(driven.path).name
    taken = {pose[k]["column"] for k in ("stamp", "x", "y", "psi")}
    taken.add(commands["stamp"]["column"])
    channels = {
        _plain(c.name): {"column": c.name}
        for c in driven.columns
        if c.name not in taken and c.changes and c.name.lower() not in NOT_COMMANDS
        and "valid" not in c.name.lower()
    }  # fmt: skip
    if not channels:
        raise RecordingError(f"{driven.path}: no column that changes is left for the commands")
    return Sources(path, name, choices.axes, 0.0, pose, commands, channels)


def _named(table: TableView, names: Sequence[str]) -> ColumnView | None:
    """The column with the first of these names, whatever its case and unit in brackets."""
    plain = {c.name.lower().split("[")[0].split("(")[0].strip(): c for c in table.columns}
    return next((plain[name] for name in names if name in plain), None)


def _stamp(table: TableView) -> dict[str, Any]:
    rising = [c for c in table.columns if c.unit]
    column = _named(table, TIME_NAMES) or (rising[0] if rising else None)
    if column is None:
        raise RecordingError(
            f"{table.path}: no column of stamps; it has {', '.join(c.name for c in table.columns)}"
        )
    unit = column.unit or "s"
    return {"column": column.name} | ({"unit": unit} if unit != "s" else {})


def _plain(text: str) -> str:
    """A word made of a field path, column or topic."""
    word = "".join(c if c.isalnum() else "_" for c in text).strip("_")
    return word if word[:1].isalpha() else f"c_{word}"
