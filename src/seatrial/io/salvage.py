# SPDX-License-Identifier: MIT
"""What is left of damaged ROS 2 bags: files read record by record, unreadable parts left out."""

import sqlite3
import struct
import zlib
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from seatrial.errors import RecordingError
from seatrial.io.bag import Bag, Message, Topic, merged_topics

MAGIC = b"\x89MCAP0\r\n"
HEADER, SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 0x01, 0x03, 0x04, 0x05, 0x06, 0x0F
LARGEST_CHUNK = 1 << 30  # [bytes]
MESSAGE_HEADER = 22  # [bytes] channel, sequence, log time, publish time


class SalvagedMcap(Bag):
    """An .mcap (https://mcap.dev/spec) of which the end, the index or a chunk is lost."""

    kind = "ROS 2 bag"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        self._schemas: dict[int, tuple[str, str, str]] = {}  # name, encoding, text
        self._channels: dict[int, Topic] = {}
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise RecordingError(f"{path}: does not begin like an .mcap; nothing to salvage")
        counts = Counter(channel for channel, _, _ in self._walk(learn=True))
        if not counts:
            raise RecordingError(f"{path}: no message could be salvaged")
        self.topics = merged_topics(
            [replace(t, messages=counts[i]) for i, t in self._channels.items()]
        )
        lost = f", {self._lost} damaged stretches left out" if self._lost else ""
        self.remarks = (f"salvaged: {counts.total()} messages{lost}",)

    def close(self) -> None:
        """Nothing is held open."""

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, in the order of the file."""
        wanted = {i: t.name for i, t in self._channels.items() if t.name in names}
        for channel, stamp, data in self._walk(learn=False):
            if channel in wanted:
                yield wanted[channel], stamp, data

    def _walk(self, *, learn: bool) -> Iterator[tuple[int, int, bytes]]:
        self._lost = 0
        size = self.path.stat().st_size
        with self.path.open("rb") as file:
            file.seek(len(MAGIC))
            while file.tell() + 9 <= size:
                kind, length = struct.unpack("<BQ", file.read(9))
                left = size - file.tell()
                if kind in (0, DATA_END):
                    return
                if kind not in (SCHEMA, CHANNEL, MESSAGE, CHUNK):
                    file.seek(min(length, left), 1)
                    continue
                body = file.read(min(length, left))
                self._lost += length > left
                if kind == CHUNK:
                    yield from self._chunk(body, learn=learn)
                elif length <= left:
                    yield from self._record(kind, body, learn=learn)

    def _chunk(self, body: bytes, *, learn: bool) -> Iterator[tuple[int, int, bytes]]:
        try:
            records = _chunk_records(body)
        except (struct.error, ValueError, RuntimeError, EOFError):
            self._lost += 1
            return
        at = 0
        while at + 9 <= len(records):
            kind, length = struct.unpack_from("<BQ", records, at)
            if at + 9 + length > len(records):
                self._lost += 1
                return
            yield from self._record(kind, records[at + 9 : at + 9 + length], learn=learn)
            at += 9 + length

    def _record(self, kind: int, body: bytes, *, learn: bool) -> Iterator[tuple[int, int, bytes]]:
        try:
            if kind == MESSAGE and len(body) >= MESSAGE_HEADER:
                channel, _, stamp = struct.unpack_from("<HIQ", body)
                yield channel, stamp, body[MESSAGE_HEADER:]
            elif kind == SCHEMA and learn:
                (number,) = struct.unpack_from("<H", body)
                name, encoding, text = _texts(body, 2, 3)
                self._schemas[number] = (name, encoding, text)
            elif kind == CHANNEL and learn:
                number, schema = struct.unpack_from("<HH", body)
                name, encoding, text = self._schemas[schema]
                topic = _texts(body, 4, 1)[0]
                self._channels[number] = Topic(topic, name, 0, text, idl=encoding.endswith("idl"))
        except (struct.error, ValueError, KeyError):
            self._lost += 1


def _chunk_records(body: bytes) -> bytes:
    """The content of a chunk. Raises ValueError where it is not what it was."""
    size, crc = struct.unpack_from("<QI", body, 16)
    how = _texts(body, 28, 1)[0]
    begin = 32 + len(how) + 8
    (length,) = struct.unpack_from("<Q", body, begin - 8)
    if size > LARGEST_CHUNK:
        raise ValueError(f"a chunk of {size} bytes")
    raw = body[begin : begin + length]
    if how == "":
        if len(raw) == length and crc and zlib.crc32(raw) != crc:
            raise ValueError("checksum")
        return raw
    if how == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

        content = bytes(LZ4FrameDecompressor().decompress(raw, max_length=size))
    else:
        content = _unpacked_zstd(raw, size)
    if len(content) != size or (crc and zlib.crc32(content) != crc):
        raise ValueError("checksum")
    return content


def _unpacked_zstd(raw: bytes, size: int) -> bytes:
    import sys

    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    try:
        return zstd.ZstdDecompressor().decompress(raw, max_length=size)
    except zstd.ZstdError as error:
        raise ValueError(str(error)) from None


def _texts(body: bytes, at: int, count: int) -> list[str]:
    found = []
    for _ in range(count):
        (length,) = struct.unpack_from("<I", body, at)
        if at + 4 + length > len(body):
            raise ValueError("a text is cut off")
        found.append(body[at + 4 : at + 4 + length].decode("utf-8", "replace"))
        at += 4 + length
    return found


@dataclass(frozen=True)
class _Row:
    number: int
    topic: int
    stamp: int
    data: bytes


class SalvagedDb3(Bag):
    """A .db3 of which some pages are lost: rows from the front, then from the back."""

    kind = "ROS 2 bag"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        try:
            self._base = sqlite3.connect(f"{path.resolve().as_uri()}?immutable=1", uri=True)
            found = self._base.execute("SELECT id, name, type FROM topics").fetchall()
            names = {int(i): (str(name), str(kind)) for i, name, kind in found}
        except (sqlite3.Error, UnicodeDecodeError, ValueError, TypeError) as error:
            raise RecordingError(f"{path}: its list of topics is lost ({error})") from None
        texts = self._definitions()
        counts = Counter(row.topic for row in self._rows())
        self._topics = {
            i: Topic(name, kind, counts[i], texts.get(kind, ("", False))[0],
                     idl=texts.get(kind, ("", False))[1])
            for i, (name, kind) in names.items()
        }  # fmt: skip
        self.topics = merged_topics(list(self._topics.values()))
        if not counts:
            self.close()
            raise RecordingError(f"{path}: no message could be salvaged")
        self.remarks = (f"salvaged: {counts.total()} messages",)

    def close(self) -> None:
        """Let go of the file."""
        self._base.close()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, in the order of the file."""
        for row in self._rows():
            topic = self._topics.get(row.topic)
            if topic is not None and topic.name in names:
                yield topic.name, row.stamp, row.data

    def _definitions(self) -> dict[str, tuple[str, bool]]:
        """Texts by type, and whether they are IDL; none in bags before Iron."""
        query = "SELECT topic_type, encoded_message_definition, encoding FROM message_definitions"
        try:
            rows = self._base.execute(query).fetchall()
        except (sqlite3.Error, UnicodeDecodeError):
            return {}
        return {str(kind): (str(text), encoding == "ros2idl") for kind, text, encoding in rows}

    def _rows(self) -> Iterator[_Row]:
        last = 0
        for row in self._until_damaged("ASC", 0):
            last = row.number
            yield row
        yield from reversed(list(self._until_damaged("DESC", last)))

    def _until_damaged(self, order: str, above: int) -> Iterator[_Row]:
        query = (
            f"SELECT id, topic_id, timestamp, data FROM messages WHERE id > ? ORDER BY id {order}"
        )
        try:
            for number, topic, stamp, data in self._base.execute(query, (above,)):
                if isinstance(data, bytes) and isinstance(stamp, int):
                    yield _Row(number, topic, stamp, data)
        except (sqlite3.Error, UnicodeDecodeError):
            return
