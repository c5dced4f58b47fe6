# SPDX-License-Identifier: MIT
"""PX4's logs (`.ulg`), ULog: https://docs.px4.io/main/en/dev_log/ulog_file_format.html.

A message is its size, a type, and a body. F defines a format, A gives a format and an instance a number, D
holds data of that number. Stamps are `timestamp`, microseconds since boot: when the data was published
(`timestamp_sample` is a field as others). Messages carry no checksum: behind damage the next sync message
is sought.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from struct import Struct

import numpy as np

from seatrial.io.formats.layout import Columns, Layout, Place, pass_blocks, topic_name
from seatrial.io.log import Log, LogSamples, LogTopic, Wanted
from seatrial.util.errors import RecordingError
from seatrial.util.files import readable

MAGIC = b"\x55\x4c\x6f\x67\x01\x12\x35"
FILE_HEADER = 16  # [bytes]
HEAD = Struct("<HB")  # size of the body, type
DATA_HEAD = Struct("<HBH")  # and of data the number of its topic
DATA = 0x44  # D
SYNC = b"\x2f\x73\x13\x20\x25\x0c\xbb\x12"
KNOWN = frozenset(b"BFIMPQARDLCSO")
ULOG_CODES = {
    "int8_t": "<b", "uint8_t": "<B", "int16_t": "<h", "uint16_t": "<H", "int32_t": "<i",
    "uint32_t": "<I", "int64_t": "<q", "uint64_t": "<Q", "float": "<f", "double": "<d", "bool": "<B",
}  # fmt: skip
TEXT = "char"
MOTORS = "actuator_motors"
MOST_FIELDS, MOST_DEPTH = 4000, 8  # of a topic; of formats in formats
MOST_IN_ALL = 100_000  # fields of all topics
MOST_FORMATS, MOST_TOPICS, MOST_PARAMETERS = 4000, 4000, 20_000
APPENDED = 1  # incompatible flag: data was appended behind the end


@dataclass
class _Topic:
    """What D messages of one number are."""

    name: str
    layout: Layout
    most: int  # [bytes] of a body without the number, with padding at its end
    columns: tuple[Columns, ...] = ()
    count: int = 0


class Px4Log(Log):
    """A `.ulg` file."""

    kind = "PX4 log"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        walk = _Walk(path)
        counts: Counter[str] = Counter()
        for topic in walk.topics:
            counts[topic.name] += topic.count
        fields = {topic.name: tuple(topic.layout.fields) for topic in walk.topics}
        self.topics = {
            name: LogTopic(name, name.partition("[")[0], counts[name], own)
            for name, own in sorted(fields.items())
            if counts[name]
        }
        self.parameters = walk.parameters
        if not self.topics:
            raise RecordingError(f"{path}: a PX4 log without any data")
        self.remarks = walk.remarks()

    def _read(self, wanted: Sequence[Wanted]) -> list[LogSamples]:
        columns = [Columns(each.topic, each.fields) for each in wanted]
        _Walk(self.path, columns)
        return [_stopped(each.samples()) for each in columns]


def _stopped(found: LogSamples) -> LogSamples:
    """NaN of a motor output means a stopped motor: no thrust, not an unknown one."""
    if found.topic.partition("[")[0] != MOTORS:
        return found
    return replace(found, values=np.nan_to_num(found.values, nan=0.0))


class _Walk:
    """One pass over the file: counts messages, or collects the wanted columns."""

    def __init__(self, path: Path, columns: Sequence[Columns] = ()) -> None:
        self.path, self.columns = path, columns
        self.formats: dict[str, list[tuple[str, int, str]]] = {}  # type, array size or 0, name
        self.layouts: dict[str, tuple[Layout, int]] = {}
        self.budget, self.left = 0, MOST_IN_ALL  # fields: of the format at hand, of all
        self.numbers: dict[int, _Topic] = {}
        self.topics: list[_Topic] = []
        self.parameters: dict[str, float] = {}
        self.unsound: set[str] = set()
        self.lost, self.places, self.unequal = 0, 0, 0  # [bytes], runs; data of a wrong size
        self.losing = False  # whether the last bytes are no message
        self.dropouts, self.dropped = 0, 0  # and their length [ms]
        self.ends: list[int] = []  # offsets behind which data was appended
        self.begins = FILE_HEADER  # where in the file the data at hand begin
        with readable(path), path.open("rb") as file:
            if not file.read(FILE_HEADER).startswith(MAGIC):
                raise RecordingError(f"{path}: no PX4 log: it does not begin as a ULog file")
            pass_blocks(file, path.stat().st_size, self._pass)

    def remarks(self) -> tuple[str, ...]:
        """Losses."""
        found = {
            f"{self.lost} bytes in {self.places} places are no message": self.lost,
            f"{self.unequal} messages have another size than their format": self.unequal,
            f"the logger dropped messages {self.dropouts} times, {self.dropped / 1000:.1f} s in all":
                self.dropouts,
            f"not read, their formats are not usable: {', '.join(sorted(self.unsound)[:10])}":
                len(self.unsound),
        }  # fmt: skip
        return tuple(text for text, count in found.items() if count)

    def _pass(self, data: bytes, ended: bool) -> int:
        """Pass all messages that are whole; returns where the next one begins."""
        at = self._messages(data, ended=ended)
        self.begins += at
        return at

    def _messages(self, data: bytes, *, ended: bool) -> int:
        at, end, unpack = 0, len(data), HEAD.unpack_from
        cut = self._cut()
        while at + 3 <= end:
            at = self._data(data, at, end if cut is None or cut > end else cut)
            if at + 3 > end:
                break
            size, kind = unpack(data, at)
            after = at + 3 + size
            # appended behind a torn message
            if cut is not None and at <= cut < after and cut <= end:
                self._lose(data[at:cut])
                at = cut
                cut = self._cut(at + 1)
                continue
            if kind not in KNOWN or size == 0:
                at = self._resync(data, at, ended=ended)
                if not ended and at + len(SYNC) + 3 >= end:
                    return at
                continue
            if after > end:
                break
            if kind == DATA and size > 1:  # of no topic, or of another size
                self.unequal += 1
            else:
                self._other(kind, data[at + 3 : after])
                if kind == 0x42:  # B
                    cut = self._cut(after)
            at = after
        if ended:
            self._lose(data[at:end])
            return end
        return at

    def _data(self, data: bytes, at: int, end: int) -> int:
        """Count or collect data of known topics, message by message; returns where the first other one begins."""
        begin, unpack, find = at, DATA_HEAD.unpack_from, self.numbers.get
        while at + 5 <= end:
            size, kind, number = unpack(data, at)
            after = at + 3 + size
            if kind != DATA or after > end or (topic := find(number)) is None:
                break
            least = topic.layout.size
            if not least <= size - 2 <= topic.most:
                break
            topic.count += 1
            for each in topic.columns:
                each.add(data[at + 5 : at + 5 + least], topic.layout)
            at = after
        if at > begin:
            self.losing = False
        return at

    def _cut(self, at: int = 0) -> int | None:
        """Where in the data appended data begin, at `at` or behind it."""
        return next((e - self.begins for e in self.ends if e >= self.begins + at), None)

    def _resync(self, data: bytes, at: int, *, ended: bool) -> int:
        """The next sync message, or the end of the data."""
        found = data.find(SYNC, at + 1)
        if found >= 3:
            after = max(found - 3, at + 1)
        else:
            after = len(data) if ended else max(at + 1, len(data) - len(SYNC) - 3)
        self._lose(data[at:after])
        return after

    def _lose(self, data: bytes) -> None:
        self.lost += len(data)
        self.places += bool(data) and not self.losing
        self.losing |= bool(data)

    # Definitions #

    def _other(self, kind: int, body: bytes) -> None:
        try:
            if kind == 0x46:  # F
                self._format(body.decode("latin-1"))
            elif kind == 0x41:  # A
                self._subscribe(body[0], body[1] | body[2] << 8, body[3:].decode("latin-1"))
            elif kind == 0x50:  # P
                self._parameter(body)
            elif kind == 0x4F:  # O
                self.dropped += body[0] + 256 * body[1]
                self.dropouts += 1
            elif kind == 0x42:  # B
                self._flags(body)
        except (IndexError, ValueError):
            self.unsound.add(chr(kind))

    def _flags(self, body: bytes) -> None:
        unknown = body[8] & ~APPENDED, *body[9:16]
        if any(unknown):
            raise RecordingError(
                f"{self.path}: a PX4 log with the incompatible flags {body[8:16].hex(' ')}; "
                "this version reads logs without them"
            )
        if body[8] & APPENDED:
            offsets = [int.from_bytes(body[i : i + 8], "little") for i in (16, 24, 32)]
            self.ends = sorted(o for o in offsets if o > FILE_HEADER)

    def _format(self, text: str) -> None:
        name, _, fields = text.partition(":")
        found = []
        for part in fields.split(";"):
            if not part.strip():
                continue
            kind, field = part.strip().split(" ")
            kind, _, length = kind.partition("[")
            found.append((kind, int(length.rstrip("]")) if length else 0, field))
        if len(self.formats) < MOST_FORMATS:
            self.formats[name] = found
            self.layouts.pop(name, None)

    def _subscribe(self, instance: int, number: int, name: str) -> None:
        """A topic: the D messages of this number."""
        self.numbers.pop(number, None)
        if name not in self.layouts:
            self.layouts[name] = self._layout(name)
        layout, most = self.layouts[name]
        if layout.stamp is None or layout.stamp.code != "<Q" or len(self.topics) >= MOST_TOPICS:
            self.unsound.add(name)
            return
        topic = topic_name(name, instance)
        mine = tuple(c for c in self.columns if c.topic == topic)
        self.numbers[number] = _Topic(topic, layout, most, columns=mine)
        self.topics.append(self.numbers[number])

    def _layout(self, name: str) -> tuple[Layout, int]:
        """Layout of a format without the padding at its end, and its size [bytes] with it.

        Without a stamp where its fields are unknown or too many.
        """
        self.budget = min(MOST_FIELDS, self.left)
        try:
            fields = list(self._fields(name, "", 0))
        except (KeyError, ValueError):
            return Layout(0, {}, None), 0
        self.left -= len(fields)
        most = sum(size for _, _, size in fields)
        while fields and fields[-1][0].startswith("_padding"):
            fields.pop()
        places: dict[str, Place] = {}
        offset = 0
        for field, code, size in fields:
            if code and not field.rpartition(".")[2].startswith("_padding"):
                places[field] = Place(offset, code)
            offset += size
        stamp = places.pop("timestamp", None)
        return Layout(offset, places, stamp), most

    def _fields(self, name: str, prefix: str, depth: int) -> Iterator[tuple[str, str, int]]:
        """Fields of a format, those of formats in it spelled out: name, code (text: none), size [bytes]."""
        if depth > MOST_DEPTH:
            raise ValueError("formats in formats")
        for kind, length, field in self.formats[name]:
            if kind == TEXT:
                yield prefix + field, "", max(length, 1)
                continue
            self.budget -= max(length, 1)
            if length < 0 or self.budget < 0:
                raise ValueError("too many fields")
            names = [f"{field}[{i}]" for i in range(length)] if length else [field]
            for each in names:
                if kind in ULOG_CODES:
                    yield prefix + each, ULOG_CODES[kind], Struct(ULOG_CODES[kind]).size
                else:
                    yield from self._fields(kind, f"{prefix}{each}.", depth + 1)

    def _parameter(self, body: bytes) -> None:
        kind, name = body[1 : 1 + body[0]].decode("latin-1").split(" ")
        code = ULOG_CODES.get(kind, "")
        if code and len(self.parameters) < MOST_PARAMETERS:
            value = Struct(code)
            if len(body) == 1 + body[0] + value.size:
                self.parameters[name] = float(value.unpack(body[1 + body[0] :])[0])
