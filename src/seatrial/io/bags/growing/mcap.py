# SPDX-License-Identifier: MIT
"""An .mcap that a recorder writes now: its records as they are flushed."""

import struct

from seatrial.io.bags.growing.growing_bag import BLOCK, LARGEST_RECORD, GrowingBag
from seatrial.io.bags.salvage_mcap import (
    CHANNEL,
    CHUNK,
    LAST_KIND,
    MAGIC,
    MESSAGE,
    SCHEMA,
    SalvagedMcap,
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
        self._use(self._after_magic(block, MAGIC, "an .mcap"))

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
        found: list[tuple[int, int, bytes]] = []
        for learn in (True, False):
            if kind == CHUNK:
                found += self._chunk(body, learn=learn, part=False)
            elif kind in (SCHEMA, CHANNEL, MESSAGE) and learn is not (kind == MESSAGE):
                found += self._record(kind, body, learn=learn)
            self._known |= {n: t for n, t in self._topics().items() if n not in self._known}
        self._new += [(self._known[i].name, t, data) for i, t, data in found if i in self._known]


def _length(block: bytes, at: int) -> int:
    return int(struct.unpack_from("<Q", block, at + 1)[0])
