# SPDX-License-Identifier: MIT
"""The contract of a log reader: topics, their numeric fields, and samples of some of them.

A topic is a message type of an autopilot, a topic of a bag, or a table. One file of `seatrial.io` for
each format implements `Log`; nothing else knows the format.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from seatrial.recording.timing import Clock
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps

LISTED_TOPICS = 20  # in an error message


@dataclass(frozen=True)
class LogTopic:
    """A topic of a log."""

    name: str  # GPS, GPS[1], vehicle_gps_position[0], /pose, poses.csv
    type: str  # the type of its messages, as users know it
    messages: int
    fields: tuple[str, ...]  # its numeric fields, arrays spelled out: C1, output[0]
    units: Mapping[str, str] = field(default_factory=dict)  # by field, where the log states it


@dataclass(frozen=True)
class Wanted:
    """Fields to be read of one topic."""

    topic: str
    fields: tuple[str, ...]


@dataclass(frozen=True)
class LogSamples:
    """Messages of one topic as columns, in the order of the file."""

    topic: str
    stamps: Stamps  # (n,) [ns] by the log's clock; may be out of order
    values: Array  # (n, fields); NaN where a message lacks a field
    dropped: int = 0  # messages that could not be read


class Log(ABC):
    """A log of which the topics are known; no file stays open. Constructors raise RecordingError, FileError."""

    path: Path
    kind: str  # for example `ArduPilot log`
    topics: dict[str, LogTopic]
    files: tuple[Path, ...]
    remarks: tuple[str, ...] = ()  # losses: "12 bytes at 3412 are no message"
    clock: Clock = Clock.LOG  # what its stamps are
    parameters: Mapping[str, float] = {}  # logged parameters of the autopilot: SERVO1_FUNCTION

    def read(self, wanted: Sequence[Wanted]) -> list[LogSamples]:
        """The samples, in the order of `wanted`. Raises RecordingError where a topic or field is unknown."""
        for each in wanted:
            self.require(each.topic, each.fields, "wanted")
        return self._read(wanted)

    @abstractmethod
    def _read(self, wanted: Sequence[Wanted]) -> list[LogSamples]:
        """Those of topics and fields that are there, in one pass and bounded memory."""

    def require(self, name: str, fields: Sequence[str], where: str) -> LogTopic:
        """The topic, which has all these fields. Raises RecordingError; `where`: place in the vehicle file."""
        topic = self.topics.get(name)
        if topic is None or topic.messages == 0:
            first = list(self.topics.values())[:LISTED_TOPICS]
            listed = ", ".join(t.name for t in first if t.messages)
            near = get_close_matches(name, [n for n in self.topics if n != name], n=1)
            hint = f"; did you mean {near[0]}?" if near and topic is None else "."
            lack = f"no topic {name}" if topic is None else f"topic {name} has no messages"
            raise RecordingError(f"{self.path}: {lack} ({where}){hint} It has {listed}")
        for wanted in fields:
            if wanted not in topic.fields:
                near = get_close_matches(wanted, topic.fields, n=1)
                hint = f"; did you mean {near[0]}?" if near else "."
                raise RecordingError(
                    f"{self.path}: topic {name} has no field '{wanted}' ({where}){hint} "
                    f"It has {', '.join(topic.fields[:LISTED_TOPICS])}"
                )
        return topic
