# SPDX-License-Identifier: MIT
"""Fields of topics that the user chose: `--pose x=TOPIC/FIELD,...` and `--commands NAME=TOPIC/FIELD,...`.

The topics are read as tables, so that units, zero and sense of the heading are found as in tables.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from seatrial.inspection.proposal.columns.choice import CHOICE_KEYS, COORDINATE_KEYS, HEADING_KEYS
from seatrial.inspection.proposal.columns.names import COORDINATES, Kind, grade, is_quaternion_part
from seatrial.inspection.proposal.columns.pose import choose_pose
from seatrial.inspection.proposal.columns.signals import headings, positions
from seatrial.inspection.proposal.sources import (
    Choices,
    Entries,
    Recognised,
    assigned,
    listed_topics,
    named,
)
from seatrial.io.bags.bag import Bag
from seatrial.io.bags.collect import Collector, collect
from seatrial.io.bags.poses import orientation_paths, pose_paths
from seatrial.io.columns import TableSeen, table_seen
from seatrial.io.log import Log, Wanted
from seatrial.io.tables.base import Table
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps

STAMP = "stamp"
NUMBER = "data"  # field of a topic of one number
OF_POSES = (*COORDINATES, Kind.HEADING, Kind.YAW_RATE)
POSE_KEYS = tuple(key for key in CHOICE_KEYS if key != STAMP)  # a message has its own stamp
Place = tuple[str, str]  # topic and field


class TopicTable(Table):
    """Some fields of a topic, with the messages' stamps as a column."""

    def __init__(
        self, path: Path, topic: str, fields: Sequence[str], samples: tuple[Stamps, Array]
    ) -> None:
        stamps, values = samples
        super().__init__(path, topic)
        self.names = [STAMP, *fields]
        seconds = (stamps - stamps[0]) * 1e-9 if len(stamps) else np.empty(0)
        self._values = np.column_stack([seconds, values])

    def _numbers(self, name: str) -> Array:
        return np.asarray(self._values[:, self.names.index(name)])

    def _texts(self, name: str) -> None:
        return None


class Topics(ABC):
    """Topics of an open bag or log, by name."""

    path: Path
    names: Sequence[str]

    @abstractmethod
    def require(self, topic: str, field: str, option: str) -> str:
        """The topic's name. Raises RecordingError where there is no such topic or field."""

    @abstractmethod
    def fields(self, topic: str) -> Sequence[str]:
        """Fields of single numbers."""

    @abstractmethod
    def samples(self, wanted: Mapping[str, Sequence[str]]) -> list[tuple[Stamps, Array]]:
        """Stamps [ns] and values (n, fields) of each topic."""

    def usual(self, topic: str) -> Sequence[str]:
        """Fields x, y and orientation that a topic of poses has by its type; empty: none."""
        return ()

    def place(self, text: str, option: str) -> Place:
        """Topic and field of `TOPIC/FIELD`. Raises RecordingError."""
        for whole in (text, f"/{text}"):
            own = [name for name in self.names if whole.startswith(f"{name}/")]
            if own:
                topic = max(own, key=len)
                field = whole.removeprefix(f"{topic}/")
                return self.require(topic, field, option), field
        topic, slash, field = text.rpartition("/")
        if not (topic and slash and field):
            raise RecordingError(
                f"{self.path}: {option} {text}: expected TOPIC/FIELD; the topics are {listed_topics(self.names)}"
            )
        return self.require(topic, field, option), field

    def tables(self, places: Sequence[Place]) -> list[TableSeen]:
        """The topics as tables with these fields; of a quaternion's component, the whole quaternion."""
        wanted: dict[str, list[str]] = {}
        for topic, field in places:
            part = is_quaternion_part(field)
            alike = [
                f for f in (self.fields(topic) if "[" not in field else _parts_of(field))
                if part and (other := is_quaternion_part(f)) and other[0] == part[0]
            ]  # fmt: skip
            mine = wanted.setdefault(topic, [])
            mine += [f for f in dict.fromkeys((field, *alike)) if f not in mine]
        return [
            table_seen(self.path, topic, TopicTable(self.path, topic, fields, samples))
            for (topic, fields), samples in zip(wanted.items(), self.samples(wanted), strict=True)
        ]


def _parts_of(field: str) -> list[str]:
    """The four fields of a quaternion in an array, poses[0].orientation.w or q[0], of which this is one."""
    stem, last = (field[:-3], field[-3:]) if field.endswith("]") else (field[:-1], field[-1:])
    return [f"{stem}{own}" for own in (("[0]", "[1]", "[2]", "[3]") if "]" in last else "xyzw")]


class BagTopics(Topics):
    """Those of a bag."""

    def __init__(self, bag: Bag) -> None:
        self.path, self.names, self._bag = bag.path, list(bag.topics), bag

    def require(self, topic: str, field: str, option: str) -> str:
        """By the message's definition."""
        found = self._bag.topic(topic, option)
        Collector(found, (field,), f"{self.path} ({option})")
        return found.name

    def fields(self, topic: str) -> Sequence[str]:
        """Without elements of arrays; none of a topic whose messages can't be read."""
        found = self._bag.topics[topic]
        return [path for path in found.wire.paths() if "[]" not in path] if found.readable else []

    def samples(self, wanted: Mapping[str, Sequence[str]]) -> list[tuple[Stamps, Array]]:
        """By the headers' stamps, where there are any."""
        collectors = [
            Collector(self._bag.topics[t], tuple(f), str(self.path), salvage=self._bag.salvage)
            for t, f in wanted.items()
        ]
        return [
            (s.arrival if s.header is None or not s.header.any() else s.header, s.values)
            for s in collect(self._bag, collectors)
        ]

    def usual(self, topic: str) -> Sequence[str]:
        """By the type of its messages."""
        wire = self._bag.topic(topic, "--pose").layout(str(self.path))
        return pose_paths(wire) or ("", "", *orientation_paths(wire))


class LogTopics(Topics):
    """Those of an autopilot's log."""

    def __init__(self, log: Log) -> None:
        self.path, self.names = log.path, [t.name for t in log.topics.values() if t.messages]
        self._log = log

    def require(self, topic: str, field: str, option: str) -> str:
        """By the log's own definitions."""
        return self._log.require(topic, [field], option).name

    def fields(self, topic: str) -> Sequence[str]:
        """With the elements of arrays."""
        return self._log.topics[topic].fields

    def samples(self, wanted: Mapping[str, Sequence[str]]) -> list[tuple[Stamps, Array]]:
        """By the log's clock."""
        found = self._log.read([Wanted(topic, tuple(fields)) for topic, fields in wanted.items()])
        return [(s.stamps, s.values) for s in found]


# Poses #


def given_keys(text: str | None) -> dict[str, str]:
    """The fields by key that `--pose` names; none where it names a topic, or nothing. Raises RecordingError."""
    return assigned(text or "", "--pose", POSE_KEYS)


def is_whole(given: Mapping[str, str]) -> bool:
    """Whether position and heading are both given."""
    return all(any(key in given for key in keys) for keys in (COORDINATE_KEYS, HEADING_KEYS))


def _usual_places(topics: Topics, entries: Mapping[str, Any]) -> dict[str, Place]:
    """Topic and field of the position and the heading that were recognised, by key. Raises RecordingError."""
    if not entries:
        return {}
    main = entries["topic"]
    found: dict[str, Place] = {}
    keys = ("latitude", "longitude") if "latitude" in entries else ("x", "y")
    for i, key in enumerate((*keys, "psi")):
        entry = entries.get(key, {})
        topic = entry.get("topic", main)
        usual = dict(enumerate(topics.usual(topic)))
        field = entry.get("field") or next(iter(entry.get("quaternion", ())), "") or usual.get(i)
        if not field:
            raise RecordingError(
                f"{topics.path}: {topic} has no field for {key}; name position and heading with --pose"
            )
        found[key] = topic, field
    return found


def given_pose(
    topics: Topics, choices: Choices, entries: Mapping[str, Any]
) -> tuple[dict[str, Any], tuple[Recognised, ...], TableSeen]:
    """The pose's entries with what `--pose` names, how it was recognised, and the position's topic.

    `entries` are those that were recognised, empty where position and heading are given.
    Raises RecordingError.
    """
    given = given_keys(choices.pose)
    places = {key: topics.place(text, "--pose") for key, text in given.items()}
    positioned = any(key in given for key in COORDINATE_KEYS)
    turned = any(key in given for key in HEADING_KEYS)
    # 1. What is not given, for the heading's zero and sense.
    for key, place in _usual_places(topics, entries).items():
        if not (turned if key in HEADING_KEYS else positioned):
            places[key] = place
    text = ",".join(f"{key}={topic}/{field}" for key, (topic, field) in places.items())
    tables = topics.tables(list(places.values()))
    found = choose_pose(topics.path, tables, replace(choices, pose=text), None)
    own = _of_topics(found.entries)
    # 2. What is given, on what was recognised.
    kept = dict(entries)
    if positioned:
        before = kept.pop("topic", None)
        for key in ("x", "y", "latitude", "longitude"):
            kept.pop(key, None)
        more = {key: own[key] for key in ("topic", "x", "y", "latitude", "longitude") if key in own}
        for key in ("psi", "yaw_rate"):
            if before and (key in kept or key == "psi"):
                kept[key] = {"topic": before} | kept.get(key, {})
        kept = more | kept
    for key in ("psi", "yaw_rate"):
        if (turned and key == "psi") or key in given:
            kept[key] = _elsewhere(own[key], own["topic"], kept["topic"])
    signals = ("heading",) * turned + ("yaw rate",) * ("yaw_rate" in given)
    rows = [
        r for r in found.recognised
        if r.signal in signals or (positioned and r.signal in ("x", "y", "east", "north", "latitude", "longitude"))
    ]  # fmt: skip
    return kept, tuple(rows), next(t for t in tables if t.key == own["topic"])


def pose_by_fields(
    topics: Topics, choices: Choices
) -> tuple[dict[str, Any], tuple[Recognised, ...]] | None:
    """The pose's entries, and how they were recognised, by the names of fields; None: there are none.

    Raises RecordingError where several topics have a position.
    """
    places = [
        (topic, field) for topic in topics.names for field in topics.fields(topic)
        if is_quaternion_part(field) is not None or any(grade(field, kind) for kind in OF_POSES)
    ]  # fmt: skip
    tables = topics.tables(places)
    moved = positions(tables)
    if not moved:
        return None
    if not headings(tables):  # in a topic of one number, by the topic's name
        turned = [t for t in topics.names if _is_heading(t) and list(topics.fields(t)) == [NUMBER]]
        if len(turned) != 1 or len({p.table.key for p in moved}) != 1:
            return None
        pairs = zip(moved[0].kinds, moved[0].names, strict=True)
        text = "".join(f"{kind.value}={moved[0].table.key}/{name}," for kind, name in pairs)
        whole = replace(choices, pose=f"{text}heading={turned[0]}/{NUMBER}")
        return given_pose(topics, whole, {})[:2]
    found = choose_pose(topics.path, tables, replace(choices, pose=None), None)
    rows = tuple(r for r in found.recognised if "stamps" not in r.signal)
    return _of_topics(found.entries), rows


def _is_heading(topic: str) -> bool:
    return grade(topic, Kind.HEADING) is not None


def _of_topics(entries: Mapping[str, Any]) -> dict[str, Any]:
    """A table's entries as those of topics: `file` and `column` are `topic` and `field`."""
    names = {"file": "topic", "column": "field"}
    return {
        names.get(key, key): _of_topics(value) if isinstance(value, dict) else value
        for key, value in entries.items()
        if key not in (STAMP, "origin")
    }


def _elsewhere(entry: Mapping[str, Any], own: str, main: str) -> dict[str, Any]:
    """A signal's entry with its topic, where that is not the position's."""
    topic = entry.get("topic", own)
    rest = {key: value for key, value in entry.items() if key != "topic"}
    return rest if topic == main else {"topic": topic} | rest


# Commands #


def given_commands(topics: Topics, text: str) -> tuple[str, Entries] | None:
    """The first topic, and channels by name; None where `--commands` names a topic. Raises RecordingError."""
    pairs = assigned(text, "--commands")
    if not pairs:
        if text in topics.names or f"/{text}" in topics.names:
            return None
        parts = [part.strip() for part in text.split(",")]
        if not all(_is_field(topics, part) for part in parts):
            return None
        pairs = {part: part for part in parts}
    places = {name: topics.place(part, "--commands") for name, part in pairs.items()}
    main = next(iter(places.values()))[0]
    channels = named(
        (name, {"field": field} | ({} if topic == main else {"topic": topic}))
        for name, (topic, field) in places.items()
    )
    return main, channels


def _is_field(topics: Topics, text: str) -> bool:
    """Whether the text is a topic's name, a slash, and a field."""
    return any(whole.startswith(f"{n}/") for n in topics.names for whole in (text, f"/{text}"))
