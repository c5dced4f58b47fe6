# SPDX-License-Identifier: MIT
"""ROS 1 bags, format 2.0 (http://wiki.ros.org/Bags/Format/2.0), chunk by chunk.

Not through rosbags: its reader makes an index entry for every message of every topic. A ten-hour
recording then needs unbounded memory, and a short one opens slowly (`benchmarks/bags.py`). The tests
compare with rosbags and with ROS 1.
"""

import mmap
import re
import struct
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from seatrial.io.bags.bag import SALVAGE, Bag, DamagedBagError, Message, Topic, merged_topics
from seatrial.io.bags.ros1_records import (
    BAG_HEADER,
    CHUNK,
    CHUNK_INFO,
    CONNECTION,
    MAGIC,
    DamagedError,
    Record,
    chunk_content,
    chunk_messages,
    decompressed,
    fields,
    is_encrypted,
    read_record,
)
from seatrial.io.bags.unpack import chunk_limit, file_limit
from seatrial.util.errors import RecordingError
from seatrial.util.files import readable

CHUNK_MARK = b"\x04\0\0\0op=\x05"
MAPPED_BYTES = 1 << 25  # [bytes] of the file that stay in memory
MARK_REACH = 64  # [bytes] a chunk's header starts at most this far before its mark


class Place(NamedTuple):
    """The position of a chunk."""

    position: int
    present: frozenset[int] | None  # connections in it; None: unknown
    until: int | None = None  # end of the bytes to read, damaged or not; None: only a whole chunk


class Ros1Bag(Bag):
    """One .bag file. Raises RecordingError."""

    kind = "ROS 1 bag"

    def __init__(self, path: Path, *, salvage: bool = False) -> None:
        self.path, self.files = path, (path,)
        self._known: dict[int, Topic] = {}
        self._callers: dict[str, set[str]] = {}  # by topic
        self._counts: Counter[int] = Counter()
        self._chunks: list[Place] = []
        self._places: set[int] = set()  # of the chunks in the index
        self._unpacked: dict[int, int] = {}  # [bytes] of chunks by position
        self._total = 0  # [bytes] of these
        self._released = 0
        self._data = _mapped(path)
        try:
            self._open()
            if salvage:
                self.check_all()
        except DamagedBagError as error:
            if not salvage:
                self.close()
                raise
            self._scan(error.reason)

    def close(self) -> None:
        """Close the file."""
        self._data.close()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, chunk by chunk."""
        wanted = {i: t.name for i, t in self._known.items() if t.name in names}
        for place in self._chunks:
            if place.present is not None and not place.present & wanted.keys():
                continue
            self._release(place.position)
            try:
                chunk = self._content(place)
                for connection, stamp, begin, end in chunk_messages(chunk):
                    if connection in wanted:
                        yield wanted[connection], stamp, chunk[begin:end]
            except DamagedError as error:
                if place.until is None:
                    reason = f"the bag is damaged at byte {place.position} ({error})"
                    raise DamagedBagError(f"{self.path}: {reason}; {SALVAGE}", reason) from None

    def _release(self, position: int) -> None:
        """Release the memory of the chunks before `position`."""
        until = position // mmap.PAGESIZE * mmap.PAGESIZE
        if until - self._released >= MAPPED_BYTES and hasattr(mmap, "MADV_DONTNEED"):
            self._data.madvise(mmap.MADV_DONTNEED, 0, until)
            self._released = until

    def _open(self) -> None:
        try:
            self._read_index()
        except DamagedError as error:
            reason = f"the bag is not whole ({error})"
            message = f"{self.path}: {reason}: was the recording cut off? {SALVAGE}"
            raise DamagedBagError(message, reason) from None
        self.topics = self._merged()

    def _merged(self) -> dict[str, Topic]:
        return merged_topics(
            [
                replace(t, messages=self._counts[i], publishers=len(self._callers[t.name]))
                for i, t in self._known.items()
            ]
        )

    def _read_index(self) -> None:
        """Connections and chunks from the index at the file's end."""
        head = read_record(self._data, len(MAGIC), len(self._data))
        if head.kind != BAG_HEADER:
            raise DamagedError("no bag header")
        if is_encrypted(head):
            reason = "is encrypted; decrypt it with rosbag decrypt"
            raise DamagedBagError(f"{self.path}: {reason}", reason)
        at = head.u64(b"index_pos")
        if at == 0:
            raise DamagedError("it has no index")
        if at > len(self._data):
            raise DamagedError(f"{len(self._data)} of at least {at} bytes are there")
        for _ in range(head.u32(b"conn_count")):
            record = read_record(self._data, at, len(self._data))
            self._add_connection(record)
            at = record.end
        for _ in range(head.u32(b"chunk_count")):
            record = read_record(self._data, at, len(self._data))
            self._add_chunk(record)
            at = record.end

    def _add_connection(self, record: Record) -> None:
        if record.kind != CONNECTION:
            raise DamagedError("a connection is missing from the index")
        inner = Record(record.source, fields(record.source, record.begin, record.end), 0, 0)
        name = "/".join(part for part in record.text(b"topic").split("/") if part)
        package, _, kind = inner.text(b"type").partition("/")
        number = record.u32(b"conn")
        self._known[number] = Topic(
            f"/{name}", f"{package}/msg/{kind.removeprefix('msg/')}", 0,
            inner.text(b"message_definition") or "# empty", cdr=False,
        )  # fmt: skip
        caller = inner.text(b"callerid") if b"callerid" in inner.fields else str(number)
        self._callers.setdefault(f"/{name}", set()).add(caller)

    def _add_chunk(self, record: Record) -> None:
        if record.kind != CHUNK_INFO:
            raise DamagedError("a chunk is missing from the index")
        pairs = self._data[record.begin : record.end]
        if len(pairs) != 8 * record.u32(b"count"):
            raise DamagedError("a chunk's entry in the index has the wrong size")
        counts = dict(struct.iter_unpack("<II", pairs))
        self._counts.update(counts)
        position = record.u64(b"chunk_pos")
        if position >= len(self._data):
            raise DamagedError("a chunk's position is beyond the end of the file")
        if position in self._places:
            raise DamagedError("a chunk is in the index twice")
        self._places.add(position)
        self._chunks.append(Place(position, frozenset(counts)))
        if {b"start_time", b"end_time"} <= record.fields.keys():
            begin, end = record.time(b"start_time"), record.time(b"end_time")
            known = self.spans[0] if self.spans else (begin, end)
            self.spans = ((min(known[0], begin), max(known[1], end)),)

    def _scan(self, reason: str) -> None:
        """Connections and chunks from the records themselves, where the index is not whole."""
        self._known.clear()
        self._counts.clear()
        self._chunks.clear()
        lost = 0
        at, end = self._next_chunk(len(MAGIC)), len(MAGIC)
        while at < len(self._data):
            end = read_record(self._data, at, len(self._data), whole=False).end
            following = self._next_chunk(at + 1)
            lost += self._scan_chunk(Place(at, None, following))
            at = following
        self._scan_index(end)
        self.topics = self._merged()
        self.remarks = self._salvaged(sum(self._counts[i] for i in self._known), lost, reason)

    def _scan_chunk(self, place: "Place") -> int:
        """1 if a part of the chunk can't be read."""
        self._chunks.append(place)
        try:
            for connection, *_ in chunk_messages(self._content(place), self._learn):
                self._counts[connection] += 1
        except DamagedError:
            return 1
        return 0

    def _scan_index(self, at: int) -> None:
        """Connections after the chunks: those in a chunk may be lost."""
        try:
            while at < len(self._data):
                record = read_record(self._data, at, len(self._data))
                if record.kind == CONNECTION:
                    self._add_connection(record)
                at = record.end
        except DamagedError:
            return

    def _next_chunk(self, at: int) -> int:
        """Start of the next chunk; the file's end if there is none."""
        mark = self._data.find(CHUNK_MARK, at)
        while mark >= 0:
            for begin in range(mark - 4, max(at, mark - MARK_REACH) - 1, -1):
                try:
                    if read_record(self._data, begin, len(self._data), whole=False).kind == CHUNK:
                        return begin
                except DamagedError:
                    continue
            mark = self._data.find(CHUNK_MARK, mark + 1)
        return len(self._data)

    def _content(self, place: "Place") -> bytes:
        return self._chunk(place.position) if place.until is None else self._part(place)

    def _learn(self, record: Record) -> None:
        if record.kind == CONNECTION:
            with suppress(DamagedError):
                self._add_connection(record)

    def _chunk(self, position: int) -> bytes:
        record = read_record(self._data, position, len(self._data))
        if record.kind != CHUNK:
            raise DamagedError("no chunk there")
        size = record.u32(b"size")
        self._total += size - self._unpacked.get(position, 0)
        self._unpacked[position] = size
        if self._total > file_limit(len(self._data)):
            raise DamagedError("its chunks would become far more than recordings do")
        return chunk_content(record)

    def _part(self, place: "Place") -> bytes:
        """The readable part of a chunk; an unfinished chunk has no lengths."""
        record = read_record(self._data, place.position, len(self._data), whole=False)
        limit = chunk_limit(record.end - record.begin)
        size = min(record.u32(b"size"), limit) or limit
        raw = self._data[record.begin : place.until]
        return decompressed(raw, record.text(b"compression"), size, part=True)[:size]


def _mapped(path: Path) -> mmap.mmap:
    """The file as a memory map."""
    with readable(path, RecordingError), path.open("rb") as file:
        first = file.read(len(MAGIC))
        if not first:
            raise RecordingError(f"{path}: is empty; was anything recorded?")
        if first != MAGIC:
            old = re.match(rb"#ROSBAG V(\d+\.\d+)", first)
            hint = (
                f"a bag of format {old[1].decode()}; convert it with rosbag migrate"
                if old else "not a ROS 1 bag; is it another file, renamed?"
            )  # fmt: skip
            raise RecordingError(f"{path}: is {hint}")
        return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
