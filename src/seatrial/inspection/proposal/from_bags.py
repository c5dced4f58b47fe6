# SPDX-License-Identifier: MIT
"""Topics of a bag that are the poses and the commands."""

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from seatrial.inspection.proposal.columns.names import is_measured
from seatrial.inspection.proposal.from_topics import (
    BagTopics,
    given_commands,
    given_keys,
    given_pose,
    is_whole,
    pose_by_fields,
)
from seatrial.inspection.proposal.sources import (
    OPTIONS,
    Ask,
    Choices,
    Entries,
    Recognised,
    Sources,
    Sureness,
    choose,
    named,
)
from seatrial.io.bags.bag import Bag, Topic
from seatrial.io.bags.channels import holds_numbers, number_fields, tf_frames
from seatrial.io.bags.contents import NUMBER_TYPES, Contents, Entry, contents
from seatrial.io.bags.opening import open_bag
from seatrial.io.bags.poses import array_pose_paths
from seatrial.io.bags.tf import is_tf
from seatrial.io.bags.wire_walk import WireError
from seatrial.recording.timing import rate_text
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Axes

POSE_TOPIC_WORDS = (
    "slam", "mocap", "vicon", "qualisys", "optitrack", "vrpn", "amcl", "pose", "odom",
)  # fmt: skip
BODY_FRAMES = ("base_link", "base_footprint", "base", "body")
WORLD_FRAMES = ("map", "world", "odom")
PLANAR_FIELDS = {  # fields of motion in the plane, of messages with more
    "geometry_msgs/msg/Wrench": ("force.x", "force.y", "torque.z"),
    "geometry_msgs/msg/WrenchStamped": ("wrench.force.x", "wrench.force.y", "wrench.torque.z"),
    "geometry_msgs/msg/Twist": ("linear.x", "linear.y", "angular.z"),
    "geometry_msgs/msg/TwistStamped": ("twist.linear.x", "twist.linear.y", "twist.angular.z"),
    "mavros_msgs/msg/ManualControl": ("x", "y", "z", "r"),
}
OWN_TOPIC_CHANNELS = 2  # most numbers in each of several topics alike, one for each thruster
RATE_FIELD = "angular_velocity.z"
FULL_COMMAND = {"mavros_msgs/msg/ManualControl": 1000.0}


def of_bag(path: Path, name: str, choices: Choices, ask: Ask | None, *, salvage: bool) -> Sources:
    """Topics of poses and commands by type and name. Raises RecordingError, FileError."""
    with open_bag(path, salvage=salvage) as bag:
        found = contents(bag, path)
        pose, recognised, pose_notes = _pose(found, bag, choices, ask)
        topics = BagTopics(bag)
        given = None if choices.commands is None else given_commands(topics, choices.commands)
        full: float | None = None
        if given is not None:
            commands: dict[str, Any] = {"topic": given[0]}
            channels, command_notes = given[1], ["--commands"]
        else:
            able = _of_this_boat(found, _commanded(found), str(pose.get("topic", "")))
            driving = _one(found, "commands", choices.commands, ask, able)
            siblings = _siblings(able if driving in able else found.of("commands"), driving)
            commands, channels = _channels(bag, driving, siblings)
            command_notes = _notes(found, driving, "commands", len(siblings))
            full = FULL_COMMAND.get(driving.topic.type_name)
    notes = {"pose": pose_notes, "commands": command_notes}
    return Sources(
        path, name, choices.axes, found.length, pose, commands, channels, notes, full, recognised=recognised
    )  # fmt: skip


def _pose(
    found: Contents, bag: Bag, choices: Choices, ask: Ask | None
) -> tuple[dict[str, Any], tuple[Recognised, ...], list[str]]:
    """The pose's entries, how they were recognised, and notes. Raises RecordingError."""
    fields, topics = given_keys(choices.pose), BagTopics(bag)
    if is_whole(fields):
        return (*given_pose(topics, choices, {})[:2], ["--pose"])
    poses = _likely_poses(found.of("poses")) or found.of("positions")
    poses = _of_this_boat(found, poses, choices.commands or "")
    if not (poses or choices.pose) or (not found.of("headings") and found.of("positions") == poses):
        by_fields = pose_by_fields(topics, choices)
        if by_fields is not None:
            return (*by_fields, ["fields by their names"])
        in_array = _of_array(found, bag)
        if in_array:
            whole = given_pose(topics, replace(choices, pose=in_array), {})
            return (*whole[:2], ["fields of an array"])
    chosen = _one(found, "poses", None if fields else choices.pose, ask, poses)
    pose: dict[str, Any] = {"topic": chosen.topic.name}
    recognised: tuple[Recognised, ...] = ()
    if is_tf(chosen.topic):
        pose |= _frames(bag, chosen.topic.name, choices)
    elif chosen.role == "positions":
        more, recognised = _geographic(found, chosen, choices)
        pose |= more
    if not fields:
        return pose, recognised, _notes(found, chosen, "poses")
    return (*given_pose(topics, choices, pose)[:2], ["--pose"])


def _of_array(found: Contents, bag: Bag) -> str:
    """The only pose of the only topic that has poses in arrays, as `--pose` names it; empty: none.

    Raises RecordingError where there are several.
    """
    texts, several = [], False
    for topic in (entry.topic for entry in found.entries if entry.stream.count > 1):
        with suppress(WireError):
            paths = array_pose_paths(topic.wire)
            if paths is None:
                continue
            pairs = zip(("x", "y", "heading"), paths, strict=True)
            texts.append(",".join(f"{key}={topic.name}/{path}" for key, path in pairs))
            second = paths[0].replace("[0].", "[1].")
            several |= second != paths[0] and second in number_fields(bag, topic.name)
    if several or len(texts) > 1:
        options = " or ".join(f"--pose {text}" for text in texts)
        raise RecordingError(f"{found.path}: several poses in arrays; choose the boat's: {options}")
    return texts[0] if texts else ""


def _of_this_boat(found: Contents, likely: list[Entry], chosen: str) -> list[Entry]:
    """Of several boats in a bag, each with poses in its own namespace, the topics of the one that was chosen."""
    mine = [e for e in likely if _namespace(e.topic.name) == _namespace(chosen)]
    posed = {_namespace(e.topic.name) for e in (*found.of("poses"), *found.of("positions"))}
    others = {_namespace(e.topic.name) for e in likely}
    return mine if mine and "" not in others and others <= posed else likely


def _commanded(found: Contents) -> list[Entry]:
    """Topics of commands, without those that are measured by their names, such as a battery's voltage."""
    able = found.of("commands")
    return [e for e in able if not is_measured(e.topic.name)] or able


def _namespace(topic: str) -> str:
    """First name of a topic's path, `otter` of /otter/pose; of a single name none."""
    first, slash, _ = topic.strip("/").partition("/")
    return first if slash else ""


def _channels(bag: Bag, driving: Entry, siblings: list[Entry]) -> tuple[dict[str, Any], Entries]:
    """The commands' entry, and the channels by name."""
    if len(siblings) == 1:
        fields = _fields(bag, driving.topic)
        return {"topic": driving.topic.name}, named((f, {"field": f}) for f in fields)
    channels = named(  # a topic for each thruster
        (entry.topic.name if len(fields) == 1 else f"{entry.topic.name}/{f}",
         {"field": f, "topic": entry.topic.name})
        for entry in siblings
        for fields in [_fields(bag, entry.topic)]
        for f in fields
    )  # fmt: skip
    return {}, channels


def _one(
    found: Contents, role: str, given: str | None, ask: Ask | None, likely: list[Entry]
) -> Entry:
    """The topic of a role: the one given, the only candidate, or the answer of `ask`."""
    option = OPTIONS[role]
    listed = "; ".join(f"{e.topic.name} ({e.topic.type})" for e in found.entries) or "none"
    if given is not None:
        for entry in found.entries:
            if entry.topic.name in (given, f"/{given}"):
                return entry
        raise RecordingError(f"{found.path}: no topic {given} ({option}); the topics are {listed}")
    if not likely:
        why = found.unreadable()
        advice = [f"name one with {option}"] * found.anything_readable() + [why] * bool(why)
        raise RecordingError(
            f"{found.path}: no topic has a type of {role}; {'; '.join(advice)}. The topics are {listed}"
        )
    alike = role == "commands" and len(_siblings(likely, likely[0])) == len(likely)
    if alike or len(likely) == 1:
        return likely[0]
    names = [e.topic.name for e in likely]
    return likely[names.index(choose(found.path, role, names, ask))]


def _likely_poses(entries: list[Entry]) -> list[Entry]:
    """Pose topics by name, the most specific word first; tf only without any other."""
    plain = [e for e in entries if not is_tf(e.topic)]
    for word in POSE_TOPIC_WORDS:
        named = [e for e in plain if word in e.topic.name.lower()]
        if named:
            return named
    return plain or entries


def _siblings(able: list[Entry], driving: Entry) -> list[Entry]:
    """Topics of the same type that hold one number, or two where all are alike: one for each thruster."""
    alike = all(e.topic.type_name == driving.topic.type_name for e in able)
    if not holds_numbers(driving.topic, OWN_TOPIC_CHANNELS if alike else 1):
        return [driving]
    return [e for e in able if e.topic.type_name == driving.topic.type_name]


def _fields(bag: Bag, topic: Topic) -> list[str]:
    wanted = PLANAR_FIELDS.get(topic.type_name)
    kept = [f for f in number_fields(bag, topic.name) if wanted is None or f in wanted]
    if any("[" in f for f in kept):  # an array may have more places than there are thrusters
        ((_, values),) = BagTopics(bag).samples({topic.name: kept})
        filled = np.asarray(np.isfinite(values).any(axis=0))
        kept = [f for f, there in zip(kept, filled, strict=True) if there]
    if not kept:
        raise RecordingError(f"{bag.path}: {topic.name} ({topic.type}) holds no numbers")
    return kept


def _geographic(
    found: Contents, position: Entry, choices: Choices
) -> tuple[dict[str, Any], tuple[Recognised, ...]]:
    """Latitude and longitude, the heading of a compass or an IMU, and its yaw rate. Raises RecordingError."""
    headings = sorted(found.of("headings"), key=lambda e: e.topic.type_name not in NUMBER_TYPES)
    if not headings:
        raise RecordingError(
            f"{found.path}: {position.topic.name} has positions, and no topic has a heading (Imu, a quaternion, "
            "or a number named heading, hdg or compass); record one"
        )
    heading, others = headings[0], tuple(e.topic.name for e in headings[1:])
    psi: dict[str, Any] = {"topic": heading.topic.name}
    why = "orientation, psi from east, counter-clockwise (REP-103)"
    turned = choices.axes == Axes.FRD.value
    if heading.topic.type_name in NUMBER_TYPES:  # a compass, in degrees from north, clockwise
        psi |= {"field": "data", "unit": "deg"} | ({} if turned else {"sign": -1, "offset": 90.0})
        why = "a compass: degrees from north, clockwise"
    elif turned:
        psi |= {"sign": -1, "offset": float(np.pi / 2)}
    pose: dict[str, Any] = {
        "latitude": {"field": "latitude"}, "longitude": {"field": "longitude"}, "psi": psi,
    }  # fmt: skip
    rows = [
        Recognised("position", position.topic.name, "latitude, longitude", Sureness.CERTAIN),
        Recognised("heading", heading.topic.name, why, Sureness.LIKELY, others),
    ]
    gyros = [e for e in headings if RATE_FIELD in e.topic.wire.paths()]
    if gyros:
        sign = {"sign": -1} if turned else {}
        pose["yaw_rate"] = {"topic": gyros[0].topic.name, "field": RATE_FIELD} | sign
        rows.append(Recognised("yaw rate", gyros[0].topic.name, RATE_FIELD, Sureness.CERTAIN))
    return pose, tuple(rows)


def _frames(bag: Bag, topic: str, choices: Choices) -> dict[str, str]:
    """Parent and child: as given, or frames with the usual names."""
    edges = tf_frames(bag, topic)
    frames = {f for parent, child, _ in edges for f in (parent, child)}
    parent = choices.parent or _usual(WORLD_FRAMES, frames)
    child = choices.child or _usual(BODY_FRAMES, frames - {parent or ""})
    if parent is None or child is None:
        listed = ", ".join(f"{p} -> {c}{' (moves)' if m else ''}" for p, c, m in edges)
        raise RecordingError(
            f"{bag.path}: {topic} has the transforms {listed}; name the world's frame with --parent and the "
            "boat's with --child"
        )
    return {"parent": parent, "child": child}


def _usual(names: Sequence[str], frames: Collection[str]) -> str | None:
    """The frame with the first of the usual names, or of a robot, wamv/base_link; None: none, or several."""
    for name in names:
        own = [f for f in frames if f == name] or [f for f in frames if f.endswith(f"/{name}")]
        if own:
            return own[0] if len(own) == 1 else None
    return None


def _notes(found: Contents, chosen: Entry, role: str, own: int = 1) -> list[str]:
    stream = chosen.stream
    notes = [f"{chosen.topic.type}, {rate_text(stream)}, stamps: {stream.clock.value}"]
    others = [e.topic for e in found.of(role) if e.topic.name != chosen.topic.name]
    if others and own == 1:
        notes.append("other candidates: " + ", ".join(f"{t.name} ({t.type})" for t in others[:6]))
    return notes
