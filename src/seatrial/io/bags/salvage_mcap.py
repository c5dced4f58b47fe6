# SPDX-License-Identifier: MIT
"""Salvage of a damaged .mcap: record by record, without unreadable parts."""

import mmap
import re
import struct
import zlib
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path

from seatrial.io.bags.bag import LATEST, Bag, Message, Topic, merged_topics
from seatrial.io.bags.unpack import (
    LARGEST_MESSAGE,
    LZ4_RATIO,
    PIECE,
    chunk_limit,
    file_limit,
    inflate,
    lz4_decompressor,
    too_large,
    unpacked,
    zstd_decompressor,
)
from seatrial.util.errors import RecordingError

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, LAST_KIND = 0x03, 0x04, 0x05, 0x06, 0x0F
MESSAGE_HEADER = 22  # [bytes] channel, sequence, log time, publish time
CHUNK_HEADER = 40  # [bytes] times, size, checksum, length of the compression's name, length
# [ns] one day: a candidate message further from the last one is not one
LONGEST_GAP = 86_400 * 10**9
_candidates = re.compile(rb"[\x05\x06]").finditer


class SalvagedMcap(Bag):
    """An .mcap (https://mcap.dev/spec) with a damaged end, index or chunk."""

    kind = "ROS 2 bag"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise RecordingError(f"{path}: does not begin like an .mcap; nothing to salvage")
            self._data: mmap.mmap | bytes = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        self._schemas: dict[int, tuple[str, str, str]] = {}  # name, encoding, text
        self._channels: dict[int, tuple[int, str, str]] = {}  # schema, topic, encoding
        for _ in self._walk(learn=True):
            pass
        self._known = self._topics()
        counts = Counter(channel for channel, _, _ in self._walk())
        found = [replace(t, messages=counts[i]) for i, t in self._known.items()]
        self.topics = merged_topics(found)
        self.remarks = self._salvaged(sum(t.messages for t in found), self._lost)

    def close(self) -> None:
        """Close the file."""
        if isinstance(self._data, mmap.mmap):
            self._data.close()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, in the order of the file."""
        wanted = {i: t.name for i, t in self._known.items() if t.name in names}
        for channel, stamp, data in self._walk():
            if channel in wanted:
                yield wanted[channel], stamp, unpacked(data)

    def _topics(self) -> dict[int, Topic]:
        """Topics of the channels whose schemas are known, without messages."""
        found = {}
        for number, (schema, topic, encoding) in self._channels.items():
            if schema in self._schemas and encoding == "cdr":
                name, kind, text = self._schemas[schema]
                found[number] = Topic(topic, name, 0, text, idl=kind.endswith("idl"))
        return found

    def _walk(self, *, learn: bool = False) -> Iterator[tuple[int, int, bytes]]:
        """Channel, time and content of every message; with `learn` only schemas and channels."""
        self._lost, self._latest, self._unpacked = 0, 0, 0
        at, size = len(MAGIC), len(self._data)
        while at + 9 <= size:
            kind, length = struct.unpack_from("<BQ", self._data, at)
            end = at + 9 + length
            whole = 0 < kind <= LAST_KIND and end <= size
            if not whole or (kind == CHUNK and not self._is_chunk(at)):
                self._lost += 1
                end = self._next(at + 1, messages=not learn)
                whole = False
            if kind == CHUNK:
                yield from self._chunk(self._data[at + 9 : end], learn=learn, part=not whole)
            elif whole and kind in (SCHEMA, CHANNEL, MESSAGE) and learn is not (kind == MESSAGE):
                yield from self._record(kind, self._data[at + 9 : end], learn=learn)
            at = end

    def _is_chunk(self, at: int) -> bool:
        """Whether the lengths of a candidate chunk are consistent."""
        if at + 9 + CHUNK_HEADER > len(self._data):
            return False
        (length,) = struct.unpack_from("<Q", self._data, at + 1)
        (name,) = struct.unpack_from("<I", self._data, at + 9 + 28)
        if name not in (0, 3, 4) or at + 9 + length > len(self._data):
            return False
        (packed,) = struct.unpack_from("<Q", self._data, at + 9 + 32 + name)
        return bool(length == CHUNK_HEADER + name + packed)

    def _is_message(self, at: int) -> bool:
        """Whether a candidate is a message of a known channel with a plausible time."""
        if at + 9 + MESSAGE_HEADER > len(self._data):
            return False
        length, channel, _, stamp = struct.unpack_from("<QHIQ", self._data, at + 1)
        near = abs(stamp - self._latest) < LONGEST_GAP or (self._latest == 0 and stamp <= LATEST)
        end = at + 9 + length
        return bool(
            MESSAGE_HEADER <= length <= LARGEST_MESSAGE and end < len(self._data) and near
            and channel in self._known and 0 < self._data[end] <= LAST_KIND
        )  # fmt: skip

    def _next(self, at: int, *, messages: bool) -> int:
        """Start of the next chunk or message; the file's end if there is none."""
        for found in _candidates(self._data, at):
            begin = found.start()
            if self._data[begin] == CHUNK:
                if self._is_chunk(begin):
                    return begin
            elif messages and self._is_message(begin):
                return begin
        return len(self._data)

    def _chunk(self, body: bytes, *, learn: bool, part: bool) -> Iterator[tuple[int, int, bytes]]:
        try:
            records = _chunk_records(body, part=part)
        except (struct.error, ValueError):
            self._lost += not part
            return
        self._unpacked += len(records)
        if self._unpacked > file_limit(len(self._data)):
            raise too_large(self.path, f"its {len(self._data)} bytes", self._unpacked)
        at = 0
        while at + 9 <= len(records):
            kind, length = struct.unpack_from("<BQ", records, at)
            if kind == 0 or at + 9 + length > len(records):  # zeros are no records
                self._lost += not part
                return
            if kind in (SCHEMA, CHANNEL, MESSAGE) and learn is not (kind == MESSAGE):
                yield from self._record(kind, records[at + 9 : at + 9 + length], learn=learn)
            at += 9 + length

    def _record(self, kind: int, body: bytes, *, learn: bool) -> Iterator[tuple[int, int, bytes]]:
        try:
            if kind == MESSAGE and not learn:
                channel, _, stamp, _ = struct.unpack_from("<HIQQ", body)
                if not 0 < stamp <= LATEST:
                    self._lost += 1
                    return
                self._latest = stamp
                yield channel, stamp, body[MESSAGE_HEADER:]
            elif kind == SCHEMA:
                (number,) = struct.unpack_from("<H", body)
                name, encoding, text = _texts(body, 2, 3)
                self._schemas.setdefault(number, (name, encoding, text))
            elif kind == CHANNEL:
                number, schema = struct.unpack_from("<HH", body)
                topic, encoding = _texts(body, 4, 2)
                self._channels.setdefault(number, (schema, topic, encoding))
        except (struct.error, ValueError):
            self._lost += 1


def _chunk_records(body: bytes, *, part: bool) -> bytes:
    """The content of a chunk; with `part` the readable part. Raises ValueError, struct.error."""
    size, crc = struct.unpack_from("<QI", body, 16)
    how = _texts(body, 28, 1)[0]
    begin = CHUNK_HEADER + len(how)
    (length,) = struct.unpack_from("<Q", body, begin - 8)
    if how and size > chunk_limit(length):
        raise ValueError(f"a chunk of {size} bytes")
    raw = body[begin : begin + length]
    if how == "":
        content = raw
    elif how == "lz4":
        most = min(size, LZ4_RATIO * len(raw) + PIECE)
        content = inflate(lz4_decompressor(), raw, most, part=part)
    else:
        content = inflate(zstd_decompressor(), raw, size, part=part)
    if not part and (len(content) != size or (crc and zlib.crc32(content) != crc)):
        raise ValueError("checksum")
    return content


def _texts(body: bytes, at: int, count: int) -> list[str]:
    found = []
    for _ in range(count):
        (length,) = struct.unpack_from("<I", body, at)
        if at + 4 + length > len(body):
            raise ValueError("a text is cut off")
        found.append(body[at + 4 : at + 4 + length].decode("utf-8", "replace"))
        at += 4 + length
    return found
