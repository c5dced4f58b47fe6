# SPDX-License-Identifier: MIT
"""Records of a ROS 1 bag: header, fields, and the content of chunks."""

import mmap
import struct
from bz2 import BZ2Decompressor
from typing import NamedTuple

from seatrial.io.bags.unpack import LZ4_RATIO, Decompressor, inflate, lz4_decompressor
from seatrial.io.bags.wire import plain

LARGEST_HEADER = 1 << 20  # [bytes]
Buffer = mmap.mmap | bytes
u32_at = struct.Struct("<I").unpack_from
u64_at = struct.Struct("<Q").unpack_from


class DamagedError(Exception):
    """A record that can't be read."""


class Record(NamedTuple):
    """A record: positions of its header's values and of its data."""

    source: Buffer
    fields: dict[bytes, tuple[int, int]]
    begin: int
    end: int

    @property
    def kind(self) -> int:
        """The record's op."""
        begin, end = self.fields.get(b"op", (0, 0))
        return self.source[begin] if end - begin == 1 else 0

    def u32(self, name: bytes) -> int:
        """A field of four bytes."""
        return int(u32_at(self.source, self.sized(name, 4))[0])

    def u64(self, name: bytes) -> int:
        """A field of eight bytes."""
        return int(u64_at(self.source, self.sized(name, 8))[0])

    def text(self, name: bytes) -> str:
        """A field of text."""
        if name not in self.fields:
            raise DamagedError(f"no field {name.decode()}")
        begin, end = self.fields[name]
        return self.source[begin:end].decode("utf-8", "replace")

    def sized(self, name: bytes, size: int) -> int:
        """Position of a field of this size."""
        begin, end = self.fields.get(name, (0, 0))
        if end - begin != size:
            raise DamagedError(f"field {name.decode()} is missing or of the wrong size")
        return begin


def read_record(source: Buffer, at: int, end: int, *, whole: bool = True) -> Record:
    """The record at a position; without `whole` its data may be cut off. Raises DamagedError."""
    if at + 8 > end:
        raise DamagedError("a record is cut off")
    (length,) = u32_at(source, at)
    begin = at + 8 + length
    if length > LARGEST_HEADER or begin > end:
        raise DamagedError("a record's header is cut off")
    stop = begin + u32_at(source, begin - 4)[0]
    if stop > end and whole:
        raise DamagedError("a record is cut off")
    return Record(source, fields(source, at + 4, begin - 4), begin, stop)


def fields(source: Buffer, at: int, end: int) -> dict[bytes, tuple[int, int]]:
    """name=value fields: start and end of each value."""
    found: dict[bytes, tuple[int, int]] = {}
    while at < end:
        if at + 4 > end:
            raise DamagedError("a header's field is cut off")
        stop = at + 4 + u32_at(source, at)[0]
        if stop > end:
            raise DamagedError("a header's field is cut off")
        name, sign, _ = source[at + 4 : min(stop, at + 68)].partition(b"=")
        if not sign:
            raise DamagedError("a header's field has no name")
        found[name] = (at + 5 + len(name), stop)
        at = stop
    return found


def decompressed(raw: bytes, how: str, size: int, *, part: bool = False) -> bytes:
    """A chunk's content; never more than its stated size. Raises DamagedError."""
    packed: Decompressor
    if how == "none":
        return raw
    if how == "bz2":
        packed = BZ2Decompressor()
    elif how == "lz4":
        packed, size = lz4_decompressor(), min(size, LZ4_RATIO * len(raw) + LZ4_RATIO)
    else:
        raise DamagedError(f"a chunk is compressed with '{plain(how)}'; expected none, bz2, lz4")
    try:
        return inflate(packed, raw, size, part=part)
    except ValueError as error:
        raise DamagedError(f"a chunk {error}") from None
