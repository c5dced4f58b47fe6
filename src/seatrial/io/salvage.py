# SPDX-License-Identifier: MIT
"""What is left of damaged ROS 2 bags: files read record by record, unreadable parts left out."""

import mmap
import re
import sqlite3
import struct
import sys
import tempfile
import zlib
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from seatrial.errors import RecordingError
from seatrial.io.bag import LATEST, SALVAGE, Bag, Message, Topic, merged_topics
from seatrial.io.wire import plain

if TYPE_CHECKING:
    from backports.zstd import ZstdDecompressor

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, LAST_KIND = 0x03, 0x04, 0x05, 0x06, 0x0F
LARGEST_CHUNK = 1 << 30  # [bytes]
LARGEST_MESSAGE = 1 << 28  # [bytes] that is looked for in a damaged stretch
PIECE = 1 << 16  # [bytes] decompressed at once
LZ4_RATIO = 256  # lz4 packs no tighter
MESSAGE_HEADER = 22  # [bytes] channel, sequence, log time, publish time
CHUNK_HEADER = 40  # [bytes] times, size, checksum, length of the compression's name, length
MOST_STRETCHES = 10_000  # damaged ones that are stepped over
DAY = 86_400 * 10**9  # [ns]
ZSTD = b"\x28\xb5\x2f\xfd"  # begins what is compressed; CDR begins with 0
_candidates = re.compile(rb"[\x05\x06]").finditer


class Decompressor(Protocol):
    """What bz2's, lz4's and zstd's have in common."""

    @property
    def eof(self) -> bool:
        """Whether the end was reached."""

    @property
    def needs_input(self) -> bool:
        """Whether there is no more to come from what was given."""

    def decompress(self, data: bytes, max_length: int) -> bytes:
        """The next part."""


def inflate(packed: Decompressor, raw: bytes, most: int, *, part: bool = False) -> bytes:
    """At most `most` bytes out of compressed ones; with `part` those before the damage.

    Raises ValueError.
    """
    errors: tuple[type[Exception], ...]
    errors = (OSError, EOFError, RuntimeError, ValueError, MemoryError, *_zstd_errors())
    found: list[bytes] = []
    left = most
    try:
        for at in range(0, len(raw), PIECE):
            given = raw[at : at + PIECE]
            while left > 0 and not packed.eof and (given or not packed.needs_input):
                found.append(packed.decompress(given, max_length=left))
                left -= len(found[-1])
                given = b""
    except errors as error:
        if not part:
            raise ValueError(f"can't be decompressed: {plain(str(error))}") from None
    return b"".join(found)


def lz4_decompressor() -> Decompressor:
    """For frames of lz4."""
    from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

    made: Decompressor = LZ4FrameDecompressor()
    return made


def zstd_decompressor() -> "ZstdDecompressor":
    """For frames of zstd."""
    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    return zstd.ZstdDecompressor()


def _zstd_errors() -> tuple[type[Exception], ...]:
    """What zstd raises, if it is in use."""
    module = sys.modules.get("compression.zstd") or sys.modules.get("backports.zstd")
    return () if module is None else (module.ZstdError,)


class UnpackedBag(Bag):
    """A file that was compressed as a whole, unpacked for as long as it is read."""

    def __init__(self, path: Path, opened: Callable[[Path], Bag], *, salvage: bool) -> None:
        self.path = path
        self._folder = tempfile.TemporaryDirectory()
        unpacked = Path(self._folder.name) / path.stem
        try:
            self._unpack(unpacked, salvage=salvage)
            self._bag = opened(unpacked)
        except RecordingError as error:
            self._folder.cleanup()
            raise RecordingError(str(error).replace(str(unpacked), str(path))) from None
        except OSError:
            self._folder.cleanup()
            raise
        self.kind, self.topics, self.remarks = self._bag.kind, self._bag.topics, self._bag.remarks
        self._bag.path = path  # for messages to people
        self.files = (path,)

    def close(self) -> None:
        """Remove what was unpacked."""
        self._bag.close()
        self._folder.cleanup()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics."""
        yield from self._bag.messages(names)

    def _unpack(self, target: Path, *, salvage: bool) -> None:
        """As far as it can be. Raises RecordingError where that is not all of it."""
        packed = zstd_decompressor()
        with self.path.open("rb") as source, target.open("wb") as out:
            for raw in iter(lambda: source.read(PIECE), b""):
                try:
                    while raw:
                        packed = zstd_decompressor() if packed.eof else packed
                        out.write(packed.decompress(raw))
                        raw = packed.unused_data if packed.eof else b""  # noqa: PLW2901
                except _zstd_errors():
                    break
        if not packed.eof and not salvage:
            raise RecordingError(f"{self.path}: the compressed bag is not whole; {SALVAGE}")


class SalvagedMcap(Bag):
    """An .mcap (https://mcap.dev/spec) of which the end, the index or a chunk is lost."""

    kind = "ROS 2 bag"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise RecordingError(f"{path}: does not begin like an .mcap; nothing to salvage")
            self._data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        self._schemas: dict[int, tuple[str, str, str]] = {}  # name, encoding, text
        self._channels: dict[int, tuple[int, str, str]] = {}  # schema, topic, encoding
        for _ in self._walk(learn=True):
            pass
        self._known = {
            number: Topic(topic, *_schema(self._schemas[schema]))
            for number, (schema, topic, encoding) in self._channels.items()
            if schema in self._schemas and encoding == "cdr"
        }
        counts = Counter(channel for channel, _, _ in self._walk())
        found = [replace(t, messages=counts[i]) for i, t in self._known.items()]
        self.topics = merged_topics(found)
        count = sum(t.messages for t in found)
        if not count:
            self.close()
            raise RecordingError(f"{path}: no message could be salvaged")
        lost = f", {self._lost} damaged stretches left out" if self._lost else ""
        self.remarks = (f"salvaged: {count} messages{lost}",)

    def close(self) -> None:
        """Let go of the file."""
        self._data.close()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, in the order of the file."""
        wanted = {i: t.name for i, t in self._known.items() if t.name in names}
        for channel, stamp, data in self._walk():
            if channel in wanted:
                yield wanted[channel], stamp, _unpacked(data)

    def _walk(self, *, learn: bool = False) -> Iterator[tuple[int, int, bytes]]:
        """Channel, time and content of every message; or what the channels are, and no message."""
        self._lost, self._latest = 0, 0
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
        """Whether the lengths in what could be a chunk agree with each other."""
        if at + 9 + CHUNK_HEADER > len(self._data):
            return False
        (length,) = struct.unpack_from("<Q", self._data, at + 1)
        (name,) = struct.unpack_from("<I", self._data, at + 9 + 28)
        if name not in (0, 3, 4) or at + 9 + length > len(self._data):
            return False
        (packed,) = struct.unpack_from("<Q", self._data, at + 9 + 32 + name)
        return bool(length == CHUNK_HEADER + name + packed)

    def _is_message(self, at: int) -> bool:
        """Whether there could be a message of a known channel, of about the right time."""
        if at + 9 + MESSAGE_HEADER > len(self._data):
            return False
        length, channel, _, stamp = struct.unpack_from("<QHIQ", self._data, at + 1)
        near = abs(stamp - self._latest) < DAY or (self._latest == 0 and stamp <= LATEST)
        end = at + 9 + length
        return bool(
            MESSAGE_HEADER <= length <= LARGEST_MESSAGE and end < len(self._data) and near
            and channel in self._known and 0 < self._data[end] <= LAST_KIND
        )  # fmt: skip

    def _next(self, at: int, *, messages: bool) -> int:
        """Where the next chunk or message begins; the file's end if there is none."""
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
        at = 0
        while at + 9 <= len(records):
            kind, length = struct.unpack_from("<BQ", records, at)
            if at + 9 + length > len(records):
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


def _schema(schema: tuple[str, str, str]) -> tuple[str, int, str, bool]:
    """Type, no messages yet, definition, and whether it is IDL."""
    name, encoding, text = schema
    return name, 0, text, encoding.endswith("idl")


def _unpacked(data: bytes) -> bytes:
    """A message, if it was compressed by itself."""
    if not data.startswith(ZSTD):
        return data
    return inflate(zstd_decompressor(), data, LARGEST_MESSAGE, part=True)


def _chunk_records(body: bytes, *, part: bool) -> bytes:
    """The content of a chunk, or the part that is left. Raises ValueError, struct.error."""
    size, crc = struct.unpack_from("<QI", body, 16)
    how = _texts(body, 28, 1)[0]
    begin = CHUNK_HEADER + len(how)
    (length,) = struct.unpack_from("<Q", body, begin - 8)
    if size > LARGEST_CHUNK:
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


_DB3_ERRORS = (sqlite3.Error, UnicodeDecodeError, OverflowError)


@dataclass(frozen=True)
class _Row:
    number: int
    topic: int
    stamp: int
    data: bytes


class SalvagedDb3(Bag):
    """A .db3 of which some pages are lost: the rows on all others."""

    kind = "ROS 2 bag"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        uri = f"{path.resolve().as_uri()}?immutable=1"
        self._base = sqlite3.connect(uri, uri=True)
        self._base.execute("PRAGMA writable_schema = ON")  # or a file cut short is not opened
        try:
            found = self._base.execute("SELECT id, name, type FROM topics").fetchall()
            names = {int(i): (str(name), str(kind)) for i, name, kind in found}
        except (sqlite3.Error, UnicodeDecodeError, ValueError, TypeError) as error:
            self.close()
            raise RecordingError(
                f"{path}: its list of topics is lost ({plain(str(error))}); nothing to salvage"
            ) from None
        texts = self._definitions()
        counts = Counter(row.topic for row in self._rows())
        self._topics = {
            i: Topic(name, kind, counts[i], texts.get(kind, ("", False))[0],
                     idl=texts.get(kind, ("", False))[1])
            for i, (name, kind) in names.items()
        }  # fmt: skip
        self.topics = merged_topics(list(self._topics.values()))
        count = sum(t.messages for t in self._topics.values())
        if not count:
            self.close()
            raise RecordingError(f"{path}: no message could be salvaged")
        lost = f", {self._lost} damaged stretches left out" if self._lost else ""
        self.remarks = (f"salvaged: {count} messages{lost}",)

    def close(self) -> None:
        """Let go of the file."""
        self._base.close()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, in the order of the file."""
        for row in self._rows():
            topic = self._topics.get(row.topic)
            if topic is not None and topic.name in names:
                yield topic.name, row.stamp, _unpacked(row.data)

    def _definitions(self) -> dict[str, tuple[str, bool]]:
        """Texts by type, and whether they are IDL; none in bags before Iron."""
        query = "SELECT topic_type, encoded_message_definition, encoding FROM message_definitions"
        try:
            rows = self._base.execute(query).fetchall()
        except (sqlite3.Error, UnicodeDecodeError):
            return {}
        return {str(kind): (str(text), encoding == "ros2idl") for kind, text, encoding in rows}

    def _rows(self) -> Iterator[_Row]:
        """All rows that can be read, from the first on."""
        self._lost, at = 0, -LATEST
        while self._lost < MOST_STRETCHES:
            try:
                for row in self._from(at):
                    at = row.number + 1
                    yield row
            except _DB3_ERRORS:
                # a row is handed out only when the next was looked for
                last = self._one(at)
                if last is not None:
                    at = last.number + 1
                    yield last
                    continue
            else:
                return
            self._lost += 1
            at = max(at, 0)
            step = self._readable_after(at)
            if step is None:
                return
            at += step

    def _from(self, at: int, ends: str = "") -> Iterator[_Row]:
        query = (
            "SELECT rowid, topic_id, timestamp, data FROM messages WHERE rowid >= ? ORDER BY rowid"
        )
        for number, topic, stamp, data in self._base.execute(query + ends, (at,)):
            if type(number) is not int or number < at:
                raise sqlite3.DatabaseError("pages in a circle")
            at = number + 1
            kinds = [type(value) for value in (topic, stamp, data)]
            if kinds == [int, int, bytes] and 0 <= stamp <= LATEST:
                yield _Row(number, topic, stamp, data)

    def _one(self, at: int) -> _Row | None:
        try:
            return next(self._from(at, " LIMIT 1"), None)
        except _DB3_ERRORS:
            return None

    def _readable_after(self, at: int) -> int | None:
        """How far the next row is that can be read: twice as far each time, then halved back."""
        far = 1
        while not self._readable(at + far):
            far *= 2
            if at + far > LATEST:
                return None
        near = far // 2
        while far - near > 1:
            middle = (near + far) // 2
            near, far = (near, middle) if self._readable(at + middle) else (middle, far)
        return far

    def _readable(self, number: int) -> bool:
        query = "SELECT data FROM messages WHERE rowid >= ? ORDER BY rowid LIMIT 1"
        try:
            self._base.execute(query, (number,)).fetchall()
        except (sqlite3.Error, UnicodeDecodeError):
            return False
        return True
