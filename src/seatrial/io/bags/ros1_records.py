# SPDX-License-Identifier: MIT
"""Records of ROS 1 bags, format 2.0 (http://wiki.ros.org/Bags/Format/2.0)."""

import mmap
import struct
from bz2 import BZ2Decompressor
from collections.abc import Callable, Iterator
from typing import NamedTuple

from seatrial.io.bags.unpack import LZ4_RATIO, Decompressor, chunk_limit, inflate, lz4_decompressor
from seatrial.io.bags.wire import plain

MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, BAG_HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7
LARGEST_HEADER = 1 << 20  # [bytes]
Buffer = mmap.mmap | bytes
_u32 = struct.Struct("<I").unpack_from
_u64 = struct.Struct("<Q").unpack_from
_time = struct.Struct("<II").unpack_from


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
        return int(_u32(self.source, self.sized(name, 4))[0])

    def u64(self, name: bytes) -> int:
        """A field of eight bytes."""
        return int(_u64(self.source, self.sized(name, 8))[0])

    def time(self, name: bytes) -> int:
        """A time [ns], two fields of four bytes."""
        seconds, nanoseconds = _time(self.source, self.sized(name, 8))
        return int(seconds) * 10**9 + int(nanoseconds)

    def text(self, name: bytes) -> str:
        """A field of text."""
        if name not in self.fields:
            raise DamagedError(f"no field {name.decode()}")
        begin, end = self.fields[name]
        return self.source[begin:end].decode("utf-8", "replace")

    def sized(self, name: bytes, size: int) -> int:
        """Where a field of this size begins."""
        begin, end = self.fields.get(name, (0, 0))
        if end - begin != size:
            raise DamagedError(f"field {name.decode()} is missing or of the wrong size")
        return begin


def chunk_messages(
    chunk: bytes, learn: Callable[[Record], None] | None = None, at: int = 0
) -> Iterator[tuple[int, int, int, int]]:
    """Connection, time [ns], begin and end of each message of a chunk, from a record on.

    learn: is called with each other record: a connection, where nothing is damaged. Raises DamagedError, also
    where the last record is cut off.
    """
    end = len(chunk)
    layouts: dict[int, tuple[int, int, int]] = {}  # by length of header: op, conn, time
    while at < end:
        if at + 8 > end:
            raise DamagedError("a record is cut off")
        (length,) = _u32(chunk, at)
        begin = at + 8 + length
        layout = layouts.get(length)
        if layout is None or begin > end or chunk[at + layout[0]] != MESSAGE:
            record = read_record(chunk, at, end)
            if record.kind == MESSAGE:
                layout = layouts[length] = (
                    record.fields[b"op"][0] - at,
                    record.sized(b"conn", 4) - at,
                    record.sized(b"time", 8) - at,
                )
            else:
                if learn is not None:
                    learn(record)
                at = record.end
                continue
        stop = begin + _u32(chunk, begin - 4)[0]
        if stop > end:
            raise DamagedError("a message is cut off")
        seconds, nanoseconds = _time(chunk, at + layout[2])
        yield _u32(chunk, at + layout[1])[0], seconds * 10**9 + nanoseconds, begin, stop
        at = stop


def is_encrypted(header: Record) -> bool:
    """Whether a bag's header states how it is encrypted."""
    return b"encryptor" in header.fields and bool(header.text(b"encryptor"))


def chunk_content(record: Record) -> bytes:
    """The content of a whole chunk. Raises DamagedError."""
    size, how = record.u32(b"size"), record.text(b"compression")
    packed = record.end - record.begin
    if size > chunk_limit(packed):
        raise DamagedError(f"a chunk of {packed} bytes that would become {size}")
    content = decompressed(record.source[record.begin : record.end], how, size)
    if len(content) != size:
        raise DamagedError(f"a chunk has {len(content)} of {size} bytes")
    return content


def read_record(source: Buffer, at: int, end: int, *, whole: bool = True) -> Record:
    """The record at a position; without `whole` its data may be cut off. Raises DamagedError."""
    if at + 8 > end:
        raise DamagedError("a record is cut off")
    (length,) = _u32(source, at)
    begin = at + 8 + length
    if length > LARGEST_HEADER or begin > end:
        raise DamagedError("a record's header is cut off")
    stop = begin + _u32(source, begin - 4)[0]
    if stop > end and whole:
        raise DamagedError("a record is cut off")
    return Record(source, fields(source, at + 4, begin - 4), begin, stop)


def fields(source: Buffer, at: int, end: int) -> dict[bytes, tuple[int, int]]:
    """name=value fields: start and end of each value."""
    found: dict[bytes, tuple[int, int]] = {}
    while at < end:
        if at + 4 > end:
            raise DamagedError("a header's field is cut off")
        stop = at + 4 + _u32(source, at)[0]
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
