# SPDX-License-Identifier: MIT
"""An .mcap that a recorder writes now: its records as they are flushed."""

import struct
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path

from seatrial.io.bags.bag import Message, Topic, merged_topics
from seatrial.io.bags.ros2 import by_number
from seatrial.io.bags.salvage_mcap import (
    CHANNEL,
    CHUNK,
    LAST_KIND,
    MAGIC,
    MESSAGE,
    SCHEMA,
    SalvagedMcap,
    schema_of,
)
from seatrial.util.errors import FileError, RecordingError

FOOTER = 0x02
BLOCK = 16 << 20  # [bytes] that are read at once
LARGEST_RECORD = 256 << 20  # [bytes]: a longer one is no record
HEAD = 9  # [bytes] of a record: kind, length


class GrowingMcap(SalvagedMcap):
    """The messages that `grow` found last; of a folder, those of its .mcap files in turn.

    path: a file, or a folder with one recording. Neither need be there yet.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, ()
        self._schemas, self._channels, self._known = {}, {}, {}
        self._lost = self._latest = self._unpacked = 0
        self._data = b""
        self._counts: Counter[str] = Counter()  # messages so far, by topic
        self._at = 0  # [bytes] of the newest file that are used
        self._complete = False  # whether that file is
        self._new: list[Message] = []
        self.topics = {}

    def grow(self) -> set[str]:
        """Read what was added, of `BLOCK` and one record at most; its topics. Raises FileError, RecordingError."""
        self._new = []
        if self._complete or not self.files:
            self._open_next()
        if self.files and not self._complete:
            self._use(self._block())
        self._count()
        return {topic for topic, _, _ in self._new}

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """Those of the last `grow`."""
        return (one for one in self._new if one[0] in names)

    def check(self, name: str, count: int) -> None:
        """Nothing: the number of messages is not known before the end."""

    def _open_next(self) -> None:
        """Go on with the first file that is not used yet, if there is one."""
        there = (
            sorted(self.path.glob("*.mcap"), key=by_number) if self.path.is_dir() else [self.path]
        )
        left = [file for file in there if file not in self.files and file.exists()]
        if left:
            self.files = (*self.files, left[0])
            self._schemas, self._channels, self._known = {}, {}, {}
            self._at, self._complete = 0, False

    def _block(self) -> bytes:
        """The bytes after those that are used."""
        try:
            with self.files[-1].open("rb") as file:
                if file.seek(0, 2) < self._at:
                    raise FileError(
                        f"{file.name}: became shorter; a bag that is followed only grows"
                    )
                file.seek(self._at)
                block = file.read(BLOCK)
                if len(block) >= HEAD and self._at:  # a record may be longer
                    length = _length(block, 0)
                    if BLOCK < length <= LARGEST_RECORD:
                        block += file.read(length)
        except OSError as error:
            raise FileError(f"{self.files[-1]}: can't be read ({error.strerror})") from None
        if self._at == 0 and len(block) >= len(MAGIC):
            if not block.startswith(MAGIC):
                raise RecordingError(f"{self.files[-1]}: does not begin like an .mcap")
            self._at, block = len(MAGIC), block[len(MAGIC) :]
        return block if self._at else b""

    def _use(self, block: bytes) -> None:
        """The whole records of a block."""
        at, self._data, self._unpacked = 0, block, 0
        while at + HEAD <= len(block) and not self._complete:
            kind, length = block[at], _length(block, at)
            if not 0 < kind <= LAST_KIND or length > LARGEST_RECORD:
                raise RecordingError(
                    f"{self.files[-1]}: is damaged at byte {self._at + at}; replay it with --salvage"
                )
            if at + HEAD + length > len(block):
                break
            self._take(kind, block[at + HEAD : at + HEAD + length])
            at += HEAD + length
        self._at += at

    def _take(self, kind: int, body: bytes) -> None:
        """A whole record."""
        self._complete = kind == FOOTER
        if kind in (SCHEMA, CHANNEL):
            list(self._record(kind, body, learn=True))
        elif kind == CHUNK:
            list(self._chunk(body, learn=True, part=False))
        self._learn()
        found: Iterator[tuple[int, int, bytes]] = iter(())
        if kind == MESSAGE:
            found = self._record(kind, body, learn=False)
        elif kind == CHUNK:
            found = self._chunk(body, learn=False, part=False)
        self._new += [
            (self._known[channel].name, stamp, data)
            for channel, stamp, data in found if channel in self._known
        ]  # fmt: skip

    def _learn(self) -> None:
        for number, (schema, topic, encoding) in self._channels.items():
            if number not in self._known and schema in self._schemas and encoding == "cdr":
                self._known[number] = Topic(topic, *schema_of(self._schemas[schema]))

    def _count(self) -> None:
        self._counts.update(topic for topic, _, _ in self._new)
        merged = merged_topics(list(self._known.values()))
        self.topics |= merged
        self.topics = {n: replace(t, messages=self._counts[n]) for n, t in self.topics.items()}


def _length(block: bytes, at: int) -> int:
    return int(struct.unpack_from("<Q", block, at + 1)[0])
