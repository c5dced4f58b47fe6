# SPDX-License-Identifier: MIT
"""Numbers from the topics of a bag, in one pass and in bounded memory."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seatrial.io.bags.bag import SALVAGE, Bag, Topic
from seatrial.io.bags.wire import Shape, Wire
from seatrial.io.bags.wire_walk import WireError
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps
from seatrial.util.progress import reach

BATCH = 8192  # messages decoded at once
BATCH_BYTES = 16 << 20  # [bytes] decoded at once


@dataclass(frozen=True)
class Samples:
    """Messages of one topic as columns, in the order of the file."""

    topic: Topic
    arrival: Stamps  # (n,) [ns] by the recorder's clock
    header: Stamps | None  # (n,) [ns]; None: no header
    values: Array  # (n, paths)
    texts: dict[str, list[str]]  # by path: n texts
    dropped: int = 0  # messages that could not be read


@dataclass
class Collector:
    """Gathers the wanted fields of one topic's messages."""

    topic: Topic
    paths: tuple[str, ...]
    source: str  # for error messages
    text_paths: tuple[str, ...] = ()
    salvage: bool = False
    _raw: list[bytes] = field(default_factory=list)
    _arrival: list[int] = field(default_factory=list)
    _bytes: int = 0
    _arrivals: list[Stamps] = field(default_factory=list)
    _headers: list[Stamps] = field(default_factory=list)
    _values: list[Array] = field(default_factory=list)
    _texts: dict[str, list[str]] = field(default_factory=dict)
    _dropped: int = 0
    _count: int = 0

    def __post_init__(self) -> None:
        self.wire: Wire = self.topic.layout(self.source)
        for path in self.paths:
            self.wire.require(path, f"{self.source}: topic {self.topic.name}")
        self._stamped = self.wire.stamped
        self._texts = {path: [] for path in self.text_paths}

    def add(self, arrival: int, raw: bytes) -> None:
        """One more message."""
        self._raw.append(raw)
        self._arrival.append(arrival)
        self._bytes += len(raw)
        if len(self._raw) >= BATCH or self._bytes >= BATCH_BYTES:
            self._flush()

    @property
    def count(self) -> int:
        """Messages so far."""
        return self._count + len(self._raw)

    def samples(self) -> Samples:
        """All samples; the collector is empty afterwards."""
        self._flush()
        if not sum(map(len, self._arrivals)):
            raise RecordingError(
                f"{self.source}: no message on {self.topic.name} could be read; record it again"
            )
        header = _joined(self._headers) if self._stamped else None
        return Samples(
            self.topic, _joined(self._arrivals), header, _joined(self._values), self._texts,
            self._dropped,
        )  # fmt: skip

    def _flush(self) -> None:
        if not self._raw:
            return
        self._count += len(self._raw)
        arrival = np.array(self._arrival, dtype=np.int64)
        raw, self._raw, self._arrival, self._bytes = self._raw, [], [], 0
        try:
            shapes = list(self.wire.shapes(raw))
        except WireError as error:
            if not self.salvage:
                raise RecordingError(
                    f"{self.source}: a message on {self.topic.name} {error}; {SALVAGE}"
                ) from None
            good = self.wire.readable(raw)
            self._dropped += len(raw) - len(good)
            raw, arrival = [raw[i] for i in good], arrival[good]
            shapes = list(self.wire.shapes(raw))
        if raw:
            self._decode(shapes, arrival)

    def _decode(self, shapes: Sequence[Shape], arrival: Stamps) -> None:
        n = len(arrival)
        values = np.full((n, len(self.paths)), np.nan)
        header = np.zeros(n, dtype=np.int64)
        keep = np.ones(n, dtype=bool)
        texts: dict[str, NDArray[np.object_]] = {
            path: np.full(n, "", dtype=object) for path in self.text_paths
        }
        for shape in shapes:
            for column, path in enumerate(self.paths):
                found = shape.numbers(path)
                if found is not None:
                    values[shape.rows, column] = found
                elif self.salvage and len(shapes) > 1:
                    keep[shape.rows] = False
                else:
                    raise self._lacking(shape, path)
            for path, listed in texts.items():
                listed[shape.rows] = shape.texts(path)
            seconds = shape.integers("header.stamp.sec")
            nanoseconds = shape.integers("header.stamp.nanosec")
            if seconds is not None and nanoseconds is not None:
                header[shape.rows] = seconds * 10**9 + nanoseconds
        self._dropped += int((~keep).sum())
        self._arrivals.append(arrival[keep])
        self._headers.append(header[keep])
        self._values.append(values[keep])
        for path, listed in texts.items():
            self._texts[path] += listed[keep].tolist()

    def _lacking(self, shape: Shape, path: str) -> RecordingError:
        array = path.rpartition("[")[0]
        leaf = shape.leaves.get(array)
        has = f"{leaf.count} values" if leaf is not None else "fewer elements"
        return RecordingError(
            f"{self.source}: topic {self.topic.name}: '{path}' is not in every message: {array or path} has "
            f"{has} in {len(shape.rows)} messages; count from 0"
        )


def _joined(parts: list[NDArray[Any]]) -> NDArray[Any]:
    """One array; the parts are released."""
    whole = np.concatenate(parts)
    parts.clear()
    return whole


def collect(bag: Bag, collectors: Sequence[Collector]) -> list[Samples]:
    """Fill collectors in one pass through the bag; a topic may have several."""
    by_topic: dict[str, list[Collector]] = {}
    for collector in collectors:
        by_topic.setdefault(collector.topic.name, []).append(collector)
    messages = sum(topic.messages for name, topic in bag.topics.items() if name in by_topic)
    for i, (topic, arrival, raw) in enumerate(bag.messages(by_topic.keys())):
        if i % BATCH == 0:
            reach(i / max(messages, 1))
        for collector in by_topic[topic]:
            collector.add(arrival, raw)
    for collector in collectors:
        bag.check(collector.topic.name, collector.count)
    return [collector.samples() for collector in collectors]
