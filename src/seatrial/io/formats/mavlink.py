# SPDX-License-Identifier: MIT
"""MAVLink telemetry logs (`.tlog`): a stamp of arrival in microseconds, and a frame of version 1 or 2.

What a message holds is stated by pymavlink, in the dialect ardupilotmega, which has the common messages.
A frame counts if its checksum is right.

Stamps: telemetry arrives late, and in bursts. Most messages state when the autopilot made them
(`time_boot_ms`, `time_usec`). Where its own time is within `SPREAD` of arrival, a message's stamp is that, on
the clock of arrival, and the messages are in this order: the offset is that of the least delayed message of the
whole log. Otherwise (it states 0, as GPS_RAW_INT before the first fix, or lay in a router), and of an autopilot
that started again, stamps are those of arrival.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from struct import unpack_from
from typing import Any

import numpy as np

from seatrial.io.formats.dataflash import c_text
from seatrial.io.formats.layout import (
    MOST_STAMP,
    Columns,
    Layout,
    Place,
    pass_blocks,
    refuse_noise,
    topic_name,
)
from seatrial.io.log import Log, LogSamples, LogTopic, Wanted
from seatrial.util.errors import RecordingError
from seatrial.util.files import readable
from seatrial.util.frames import Array, Stamps

INSTALL = "pip install 'seatrial[ardupilot]'"
STARTS = (0xFE, 0xFD)  # of version 1 and 2
STAMP = 8  # [bytes] before each frame
LONGEST = STAMP + 12 + 255 + 13  # [bytes] of a record
MAVLINK_CODES = {
    "int8_t": "b", "uint8_t": "B", "int16_t": "h", "uint16_t": "H", "int32_t": "i", "uint32_t": "I",
    "int64_t": "q", "uint64_t": "Q", "float": "f", "double": "d", "uint8_t_mavlink_version": "B",
}  # fmt: skip
TIMES = {"time_boot_ms": 1_000_000, "time_usec": 1000}  # [ns] of one
SPREAD = 10_000_000_000  # [ns] of the delays of messages
EARLIEST = 9e14  # [us] of arrival since 1970: 1998
LATEST = 5e15  # [us]
AUTOPILOT = 1  # component
HEARTBEAT, PARAM_VALUE = 0, 22  # numbers of messages
PX4 = 12  # autopilot of a heartbeat; it sends the bytes of whole numbers as a float
WHOLE = {1: "<B", 2: "<b", 3: "<H", 4: "<h", 5: "<I", 6: "<i"}  # types of parameters
BAD_PLACES = 50_000  # [bytes] after which a file that is less than half frames is no log
MOST_PARAMETERS = 20_000
Source = tuple[int, int]  # system, component


@dataclass(frozen=True)
class Message:
    """A message of the dialect."""

    name: str
    layout: Layout  # of the stamp of arrival and the payload, filled up with zeros
    extra: bytes  # what its definition adds to the checksum
    payload: int  # [bytes]
    boot: int | None  # offset [bytes] of time_boot_ms
    units: dict[str, str]


@cache
def messages() -> dict[int, Message]:
    """The messages by number. Raises RecordingError without pymavlink."""
    try:
        from pymavlink.dialects.v20 import ardupilotmega  # type: ignore[import-untyped]
    except ImportError:
        raise RecordingError(f"MAVLink telemetry logs need pymavlink: {INSTALL}") from None
    return {int(n): _message(m) for n, m in ardupilotmega.mavlink_map.items()}


def _message(found: Any) -> Message:  # noqa: ANN401 (a class that is generated)
    kinds = dict(zip(found.fieldnames, found.fieldtypes, strict=True))
    lengths = dict(zip(found.ordered_fieldnames, found.array_lengths, strict=True))
    places: dict[str, Place] = {}
    offset, instance = STAMP, None
    for name in found.ordered_fieldnames:
        kind, length = kinds[name], lengths[name]
        if name == found.instance_field and kind.startswith("uint8_t"):
            instance = offset
        if kind == "char":
            offset += max(length, 1)
            continue
        code = f"<{MAVLINK_CODES[kind]}"
        for i in range(length or 1):
            places[f"{name}[{i}]" if length else name] = Place(offset, code)
            offset += np.dtype(code).itemsize
    layout = Layout(offset, places, Place(0, ">Q"), 1000, instance)
    boot = places.get("time_boot_ms")
    return Message(
        found.msgname, layout, bytes((found.crc_extra,)), offset - STAMP,
        boot.offset if boot is not None and boot.code == "<I" else None,
        dict(found.fieldunits_by_name),
    )  # fmt: skip


def is_telemetry(data: bytes) -> bool:
    """Whether a file begins with records of a stamp of this century and a MAVLink frame."""
    at, found = 0, 0
    while at + 12 <= len(data) and found < 4:
        usec = int.from_bytes(data[at : at + STAMP], "big")
        if data[at + STAMP] not in STARTS or not EARLIEST < usec < LATEST:
            return False
        at += STAMP + frame_size(data, at + STAMP)
        found += 1
    return found > 0


def frame_size(data: bytes, at: int) -> int:
    """[bytes] of the MAVLink frame that begins at a place, of version 1 or 2."""
    if data[at] == STARTS[0]:
        return 8 + data[at + 1]
    return 12 + data[at + 1] + (13 if data[at + 2] & 1 else 0)  # signed


def frame_at(
    data: bytes,
    frame: int,
    end: int,
    known: Mapping[int, Message],
    checksum: Callable[[bytes], int],
) -> tuple[int, int, Source, int, int] | None:
    """The frame that begins at a place: where the next begins, number, source, and its payload's place and length.

    None: no whole frame, or its checksum is wrong. The checksum of an unknown message can't be checked.
    """
    if frame + 12 > end or data[frame] not in STARTS:
        return None
    length, after = data[frame + 1], frame + frame_size(data, frame)
    if data[frame] == STARTS[0]:
        body, source, number = frame + 6, (data[frame + 3], data[frame + 4]), data[frame + 5]
    else:
        body, source = frame + 10, (data[frame + 5], data[frame + 6])
        number = data[frame + 7] | data[frame + 8] << 8 | data[frame + 9] << 16
    if after > end:
        return None
    message = known.get(number)
    if message is not None:
        checked = checksum(data[frame + 1 : body + length] + message.extra)
        if checked != data[body + length] | data[body + length + 1] << 8:
            return None
    return after, number, source, body, length


class MavlinkLog(Log):
    """A `.tlog` file."""

    kind = "MAVLink telemetry log"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        walk = _Walk(path)
        self._autopilot = walk.autopilot()
        self.parameters = walk.parameters(self._autopilot)
        begun_again = self._autopilot in walk.begun_again
        self._offset = None if begun_again else walk.offsets.get(self._autopilot)
        self.topics: dict[str, LogTopic] = {}
        self._places: dict[str, tuple[int, Source, int]] = {}  # number, source, instance
        for (number, source, instance), count in sorted(walk.counts.items()):
            found = messages()[number]
            name = topic_name(found.name, instance)
            if source != self._autopilot:
                name += f"@{source[0]}.{source[1]}"
            self._places[name] = number, source, instance
            fields = tuple(found.layout.fields)
            self.topics[name] = LogTopic(name, found.name, count, fields, found.units)
        self.topics = dict(sorted(self.topics.items()))
        if not self.topics:
            raise RecordingError(f"{path}: no MAVLink log: no message has the right checksum")
        self.remarks = walk.remarks()

    def _read(self, wanted: Sequence[Wanted]) -> list[LogSamples]:
        columns: dict[tuple[int, Source, int], list[Columns]] = {}
        several = []
        for each in wanted:
            place = self._places[each.topic]
            time = next((t for t in TIMES if t in messages()[place[0]].layout.fields), None)
            fields = (*each.fields, time) if time else each.fields
            several.append((Columns(each.topic, fields), time))
            columns.setdefault(place, []).append(several[-1][0])
        _Walk(self.path, columns)
        return [self._stamped(c.samples(), time) for c, time in several]

    def _stamped(self, found: LogSamples, time: str | None) -> LogSamples:
        """Samples with the stamps that their own times give, where these are sound."""
        if time is None:
            return found
        values = np.ascontiguousarray(found.values[:, :-1])
        stamps = found.stamps
        if self._offset is not None and len(stamps):
            own = own_stamps(found.values[:, -1], time, stamps, self._offset)
            order = np.argsort(own, kind="stable")
            stamps, values = own[order], values[order]
        return LogSamples(found.topic, stamps, values, found.dropped)


def own_stamps(times: Array, name: str, arrival: Stamps, offset: int) -> Stamps:
    """Own times on the clock of arrival, else arrival. Microseconds in 32 bits wrap every 72 min."""
    own = np.minimum(times, MOST_STAMP // TIMES[name]).astype(np.int64) * TIMES[name] + offset
    if name == "time_usec":
        wrap = (1 << 32) * TIMES[name]
        turns = np.round((arrival - own) / wrap).astype(np.int64)
        own = own + np.where(times < 1 << 32, turns, 0) * wrap
    sound = (times != 0) & (np.abs(arrival - own) <= SPREAD)
    return np.where(sound, own, arrival)


class _Walk:
    """One pass over the file: counts messages, or collects the wanted columns."""

    def __init__(
        self, path: Path, columns: dict[tuple[int, Source, int], list[Columns]] | None = None
    ) -> None:
        self.messages = messages()
        from fastcrc.crc16 import mcrf4xx  # pymavlink brings it

        self.checksum = mcrf4xx
        self.path, self.columns = path, columns
        self.counts: Counter[tuple[int, Source, int]] = Counter()
        self.stated: dict[Source, dict[str, tuple[bytes, int]]] = {}  # parameters and their types
        self.px4: dict[Source, bool] = {}
        self.offsets: dict[Source, int] = {}  # [ns] least of arrival minus time since boot
        self.latest: dict[Source, int] = {}  # [ns] time since boot
        self.begun_again: set[Source] = set()
        self.unknown: Counter[int] = Counter()
        self.in_step = True  # whether the last bytes are a message
        self.lost, self.places, self.passed = 0, 0, 0  # [bytes], runs of them, [bytes] of frames
        with readable(path), path.open("rb") as file:
            pass_blocks(file, path.stat().st_size, self._pass)

    def autopilot(self) -> Source:
        """The source with the most messages; an autopilot's component before others."""
        several: Counter[Source] = Counter()
        for (_, source, _), count in self.counts.items():
            several[source] += count
        return max(several, key=lambda s: (s[1] == AUTOPILOT, several[s]), default=(0, 0))

    def parameters(self, source: Source) -> dict[str, float]:
        """Parameters that a source sent."""
        found = {}
        for name, (value, kind) in self.stated.get(source, {}).items():
            code = WHOLE.get(kind, "<f") if self.px4.get(source) else "<f"
            found[name] = float(unpack_from(code, value)[0])
        return found

    def remarks(self) -> tuple[str, ...]:
        """Losses."""
        unknown = ", ".join(str(n) for n in sorted(self.unknown)[:10])
        found = {
            f"{self.lost} bytes in {self.places} places are no message": self.lost,
            f"{self.unknown.total()} messages are of unknown types (number {unknown})": len(self.unknown),
        }  # fmt: skip
        return tuple(text for text, count in found.items() if count)

    def _pass(self, data: bytes, ended: bool) -> int:
        """Pass all records that are whole; returns where the next one begins."""
        at, end, in_step = 0, len(data), self.in_step
        last = end if ended else end - LONGEST
        while at < last:
            size = self._record(data, at, end)
            if size:
                at, in_step = at + size, True
                self.passed += size
                continue
            self.lost += 1
            self.places += in_step
            in_step = False
            at += 1
            if self.lost > BAD_PLACES:
                refuse_noise(self.path, "MAVLink log", self.passed, self.lost)
        self.in_step = in_step
        return at

    def _record(self, data: bytes, at: int, end: int) -> int:
        """Take the record at a place; its size [bytes], 0 where there is none."""
        frame = at + STAMP
        found = frame_at(data, frame, end, self.messages, self.checksum)
        arrival = int.from_bytes(data[at:frame], "big")
        if found is None or not EARLIEST < arrival < LATEST:
            return 0
        after, number, source, body, length = found
        known = self.messages.get(number)
        if known is None:  # its checksum is unknown: another record must follow
            if after + STAMP < end and data[after + STAMP] not in STARTS:
                return 0
            self.unknown[number] += 1
            return after - at
        record = data[at:frame] + data[body : body + min(length, known.payload)]
        self._take(number, source, record.ljust(known.layout.size, b"\0"), arrival)
        return after - at

    def _take(self, number: int, source: Source, record: bytes, arrival: int) -> None:
        """Count a message, or collect it. `arrival` [us]."""
        found = self.messages[number]
        offset = found.layout.instance
        key = number, source, 0 if offset is None else record[offset]
        if self.columns is not None:
            for each in self.columns.get(key, ()):
                each.add(record, found.layout)
            return
        self.counts[key] += 1
        if found.boot is not None:
            boot = int.from_bytes(record[found.boot : found.boot + 4], "little")
            own = boot * TIMES["time_boot_ms"]
            since = arrival * 1000 - own
            self.offsets[source] = min(self.offsets.get(source, since), since)
            if own < self.latest.get(source, 0) - SPREAD:
                self.begun_again.add(source)
            self.latest[source] = own
        elif number == PARAM_VALUE:
            stated = self.stated.setdefault(source, {})
            if len(stated) < MOST_PARAMETERS:
                stated[c_text(record[16:32])] = record[8:12], record[32]
        elif number == HEARTBEAT:
            self.px4[source] = record[STAMP + 5] == PX4
