# SPDX-License-Identifier: MIT
"""Interface of a bag: its topics, and their messages as bytes, in the order of the file."""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.io.bags.wire import Wire, parse_definition, plain, short_type
from seatrial.io.bags.wire_walk import WireError
from seatrial.util.errors import RecordingError

SALVAGE = "--salvage reads what is left"
LATEST = (1 << 63) - 1  # [ns] of a stamp
# not in rosbags; field lists are those of the packages' .msg files
COMMON = {
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "mavros_msgs/msg/RCOut": "std_msgs/Header header\nuint16[] channels",
    "mavros_msgs/msg/RCIn": "std_msgs/Header header\nuint8 rssi\nuint16[] channels",
    "mavros_msgs/msg/ManualControl": (
        "std_msgs/Header header\nfloat32 x\nfloat32 y\nfloat32 z\nfloat32 r\nuint16 buttons\n"
        "uint16 buttons2\nuint8 enabled_extensions\nfloat32 s\nfloat32 t\nfloat32 aux1\n"
        "float32 aux2\nfloat32 aux3\nfloat32 aux4\nfloat32 aux5\nfloat32 aux6"
    ),
}


Message = tuple[str, int, bytes]  # topic, time of arrival [ns], serialised


DEFINED = (
    "record it as .mcap, which contains its definitions, or convert it with ros2 bag convert, where the packages "
    "of its messages are installed"
)


class DamagedBagError(RecordingError):
    """A bag that can't be read as it is. `reason`: what is wrong with it, without path and advice."""

    def __init__(self, message: str, reason: str = "") -> None:
        super().__init__(message)
        self.reason = reason


@dataclass(frozen=True)
class Topic:
    """A topic of a bag."""

    name: str
    type_name: str  # as ROS 2 writes it: geometry_msgs/msg/PoseStamped
    messages: int
    definition: str = ""  # text of the definition in the bag
    idl: bool = False  # the text is IDL
    cdr: bool = True  # ROS 2; False: ROS 1
    publishers: int = 1
    others: tuple[str, ...] = ()  # further types under the same name

    @property
    def type(self) -> str:
        """The type in its short form."""
        return short_type(self.type_name)

    @cached_property
    def wire(self) -> Wire:
        """Layout of its messages. Raises WireError."""
        if self.definition:
            known = parse_definition(self.definition, self.type_name, idl=self.idl)
        else:
            known = standard_definitions()
        if self.type_name not in known:
            raise WireError(
                f"the bag has no definition of {self.type}, and it is not a common type; {DEFINED}"
            )
        return Wire(self.type_name, known, self.cdr)

    def layout(self, source: str) -> Wire:
        """The same; `source`: a bag, for the message. Raises RecordingError."""
        try:
            return self.wire
        except WireError as error:
            raise RecordingError(f"{source}: topic {self.name}: {error}") from None

    @property
    def readable(self) -> bool:
        """Whether the layout of its messages is known."""
        try:
            return bool(self.wire)
        except WireError:
            return False


class Bag(ABC):
    """A bag opened for reading; a context manager."""

    path: Path
    kind: str  # for example `ROS 1 bag`
    topics: dict[str, Topic]
    files: tuple[Path, ...]
    remarks: tuple[str, ...] = ()  # losses of a salvaged bag
    salvage: bool = False  # whether unreadable messages are left out
    # [ns] first and last arrival in each file, where the bag states them
    spans: tuple[tuple[int, int], ...] = ()

    @abstractmethod
    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, in the order of the file. Raises RecordingError."""

    @abstractmethod
    def close(self) -> None:
        """Close the files."""

    def _salvaged(self, count: int, lost: int, reason: str = "") -> tuple[str, ...]:
        """Remark on a salvaged bag. Raises RecordingError where it has no message left."""
        why = f" ({reason})" if reason else ""
        if not count:
            self.close()
            raise RecordingError(f"{self.path}: no message could be salvaged{why}")
        parts = f", {lost} damaged parts left out" if lost else ""
        return (f"salvaged{why}: {count} messages{parts}",)

    def __enter__(self) -> "Bag":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def check(self, name: str, count: int) -> None:
        """Raise DamagedBagError if fewer messages of a topic were read than the bag states."""
        if count < self.topics[name].messages:
            expected = self.topics[name].messages
            reason = f"the bag is damaged: {count} of {expected} messages on {name} are there"
            raise DamagedBagError(f"{self.path}: {reason}; {SALVAGE}", reason)

    def check_all(self) -> None:
        """Read every message once. Raises RecordingError where one is missing or unreadable."""
        counts = Counter(name for name, _, _ in self.messages(self.topics.keys()))
        for name in self.topics:
            self.check(name, counts[name])

    def topic(self, name: str, where: str) -> Topic:
        """A topic with messages. Raises RecordingError where there is none."""
        found = self.topics.get(name) or self.topics.get(f"/{name}")
        if found is not None and found.others:
            raise RecordingError(
                f"{self.path}: topic {name} carries {found.type} and "
                f"{', '.join(map(short_type, found.others))} ({where}); record one type a topic"
            )
        if found is not None and found.messages > 0:
            return found
        topics = sorted(self.topics.values(), key=lambda t: (t.messages == 0, t.name))
        listed = "; ".join(f"{t.name} ({t.type}, {t.messages})" for t in topics)
        if found is not None:
            raise RecordingError(
                f"{self.path}: topic {name} has no messages ({where}); was its publisher running? "
                f"The topics are {listed}"
            )
        near = get_close_matches(name, self.topics, n=1)
        hint = f"; did you mean {near[0]}?" if near else "."
        there = f"The topics are {listed}" if listed else "The bag has no topics"
        raise RecordingError(f"{self.path}: no topic {name} ({where}){hint} {there}")


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


if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict


@lru_cache(maxsize=1)
def standard_definitions() -> "Typesdict":
    """ROS 2's common interfaces, tf2 and mavros."""
    from rosbags.typesys import Stores, get_typestore

    known = dict(get_typestore(Stores.ROS2_HUMBLE).fielddefs)
    for name, text in COMMON.items():
        known.update(parse_definition(text, name))
    return known
