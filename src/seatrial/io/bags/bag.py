# SPDX-License-Identifier: MIT
"""What every bag offers: its topics, and their messages as bytes, in the order of the file."""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path

from seatrial.io.bags.definitions import standard_definitions
from seatrial.io.bags.wire import Wire, WireError, parse_definition, plain, short_type
from seatrial.util.errors import RecordingError

Message = tuple[str, int, bytes]  # topic, time of arrival [ns], serialised
SALVAGE = "--salvage reads what is left"
LATEST = (1 << 63) - 1  # [ns] of a stamp


@dataclass(frozen=True)
class Topic:
    """A topic of a bag."""

    name: str
    type_name: str  # as ROS 2 writes it: geometry_msgs/msg/PoseStamped
    messages: int
    definition: str = ""  # text that came with the bag
    idl: bool = False  # the text is IDL
    cdr: bool = True  # ROS 2; False: ROS 1
    publishers: int = 1
    others: tuple[str, ...] = ()  # types that its name carries besides

    @property
    def type(self) -> str:
        """The type as people write it."""
        return short_type(self.type_name)

    @cached_property
    def wire(self) -> Wire:
        """How its messages are laid out. Raises WireError."""
        if self.definition:
            known = parse_definition(self.definition, self.type_name, idl=self.idl)
        else:
            known = standard_definitions()
        if self.type_name not in known:
            raise WireError(
                f"the bag brings no definition of {self.type}, and it is not a common type; record "
                "it as .mcap, which brings its definitions"
            )
        return Wire(self.type_name, known, self.cdr)


class Bag(ABC):
    """A bag opened for reading; a context manager."""

    path: Path
    kind: str  # in words
    topics: dict[str, Topic]
    files: tuple[Path, ...]
    remarks: tuple[str, ...] = ()  # what was lost when it was salvaged

    @abstractmethod
    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, in the order of the file. Raises RecordingError."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the files."""

    def _salvaged(self, count: int, lost: int) -> tuple[str, ...]:
        """What to say of a salvaged bag. Raises RecordingError where nothing is left of it."""
        if not count:
            self.close()
            raise RecordingError(f"{self.path}: no message could be salvaged")
        stretches = f", {lost} damaged stretches left out" if lost else ""
        return (f"salvaged: {count} messages{stretches}",)

    def __enter__(self) -> "Bag":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def check(self, name: str, count: int) -> None:
        """Raise RecordingError if fewer messages were read of a topic than the bag should have."""
        if count < self.topics[name].messages:
            raise RecordingError(
                f"{self.path}: the bag is damaged: {count} of {self.topics[name].messages} messages "
                f"on {name} are there; {SALVAGE}"
            )

    def check_all(self) -> None:
        """Read everything once. Raises RecordingError where that can't be done."""
        counts = Counter(name for name, _, _ in self.messages(self.topics.keys()))
        for name in self.topics:
            self.check(name, counts[name])

    def topic(self, name: str, where: str) -> Topic:
        """A topic that must be there and have messages."""
        found = self.topics.get(name) or self.topics.get(f"/{name}")
        if found is not None and found.others:
            raise RecordingError(
                f"{self.path}: topic {name} carries {found.type} and "
                f"{', '.join(map(short_type, found.others))} ({where}); record one type a topic"
            )
        if found is not None and found.messages > 0:
            return found
        listed = "; ".join(
            f"{t.name} ({t.type}, {t.messages})" for t in sorted(self.topics.values(), key=_order)
        )
        if found is not None:
            raise RecordingError(
                f"{self.path}: topic {name} has no messages ({where}); was its publisher running? "
                f"The topics are {listed}"
            )
        near = get_close_matches(name, self.topics, n=1)
        hint = f"; did you mean {near[0]}?" if near else "."
        there = f"The topics are {listed}" if listed else "The bag has no topics"
        raise RecordingError(f"{self.path}: no topic {name} ({where}){hint} {there}")


def _order(topic: Topic) -> tuple[bool, str]:
    return topic.messages == 0, topic.name


def merged_topics(found: Collection[Topic]) -> dict[str, Topic]:
    """Topics of several connections or files as one table."""
    merged: dict[str, Topic] = {}
    for each in found:
        topic = replace(each, name=plain(each.name, 300), type_name=plain(each.type_name, 300))
        before = merged.get(topic.name)
        if before is None:
            merged[topic.name] = topic
            continue
        others = dict.fromkeys((*before.others, topic.type_name))
        merged[topic.name] = replace(
            before if before.definition else topic,
            messages=before.messages + topic.messages,
            publishers=max(before.publishers, topic.publishers),
            others=tuple(name for name in others if name != before.type_name),
        )
    return merged
