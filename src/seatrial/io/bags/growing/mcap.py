# SPDX-License-Identifier: MIT
"""An .mcap that a recorder writes now: its records as they are flushed."""

import struct
from collections.abc import Iterator

from seatrial.io.bags.bag import Topic
from seatrial.io.bags.growing.growing_bag import BLOCK, LARGEST_RECORD, GrowingBag
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
from seatrial.util.errors import RecordingError

FOOTER = 0x02
HEAD = 9  # [bytes] of a record: kind, length


class GrowingMcap(GrowingBag, SalvagedMcap):
    """Records of an .mcap as they are flushed."""

    suffix = ".mcap"

    def _begin(self) -> None:
        self._schemas, self._channels, self._known = {}, {}, {}
        self._lost = self._latest = self._unpacked = 0
        self._data = b""

    def _read(self) -> None:
        block = self._bytes()
        if len(block) >= HEAD and self._at:  # a record may be longer
            length = _length(block, 0)
            if BLOCK < length <= LARGEST_RECORD:
                block = self._bytes(BLOCK + length)
        if self._at == 0 and len(block) >= len(MAGIC):
            if not block.startswith(MAGIC):
                raise RecordingError(f"{self.files[-1]}: does not begin like an .mcap")
            self._at, block = len(MAGIC), block[len(MAGIC) :]
        self._use(block if self._at else b"")

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


def _length(block: bytes, at: int) -> int:
    return int(struct.unpack_from("<Q", block, at + 1)[0])
