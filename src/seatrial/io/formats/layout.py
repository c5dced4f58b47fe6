# SPDX-License-Identifier: MIT
"""Binary records of one topic as columns, decoded in blocks; files read by blocks or by lines."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from seatrial.io.log import LogSamples
from seatrial.util.errors import RecordingError
from seatrial.util.files import readable
from seatrial.util.frames import Array, Index
from seatrial.util.progress import reach

BLOCK = 1 << 22  # [bytes] of records that are decoded at once
MOST_STAMP = 1 << 62  # [ns] a later stamp is damage
READ = 1 << 22  # [bytes] of a file read at once
LONGEST_LINE = 4096  # [bytes] no message of numbers is longer
EVERY = 1 << 16  # [lines] between two reports of progress


@dataclass(frozen=True)
class Place:
    """A number in a record: value = raw / divisor."""

    offset: int  # [bytes] from the beginning of the record
    code: str  # of numpy, little-endian: <i4
    divisor: int = 1

    def stored(self, block: bytearray, size: int) -> NDArray[Any]:
        """The number of each record in a block of records of `size` bytes."""
        shape = (len(block) // size,)
        view: NDArray[Any] = np.ndarray(shape, np.dtype(self.code), block, self.offset, (size,))
        return view.copy()

    def values(self, block: bytearray, size: int) -> Array:
        """The same with its divisor."""
        with np.errstate(invalid="ignore"):  # a signalling NaN is a NaN
            found = self.stored(block, size).astype(np.float64)
        return found if self.divisor == 1 else found / self.divisor


@dataclass(frozen=True)
class Layout:
    """Fields of a record. Records of one layout have one size."""

    size: int  # [bytes]
    fields: Mapping[str, Place]
    stamp: Place | None  # None: records without a stamp are no topic
    tick: int = 1000  # [ns] of one unit of the stamp
    instance: int | None = None  # offset [bytes] of the byte that tells several sensors apart


def refuse_noise(path: Path, kind: str, passed: int, lost: int, unit: str = "bytes") -> None:
    """Raise RecordingError where less than half of what was passed are messages."""
    if passed < lost:
        raise RecordingError(
            f"{path}: no {kind}, or a badly damaged one: of its first {passed + lost} {unit} {lost} are no message"
        )


def topic_name(name: str, instance: int | None) -> str:
    """GPS of the first instance, GPS[1] of the second."""
    return f"{name}[{instance}]" if instance else name


class Columns:
    """Wanted fields of one topic, collected record by record and decoded in blocks."""

    def __init__(self, topic: str, fields: Sequence[str]) -> None:
        self.topic, self.fields = topic, tuple(fields)
        self.layout: Layout | None = None
        self.block = bytearray()
        self.stamps: list[Index] = []
        self.values: list[Array] = []
        self.dropped = 0

    def add(self, record: bytes, layout: Layout) -> None:
        """One record, `layout.size` bytes."""
        if layout is not self.layout:  # the log defines the topic anew
            self._decode()
            self.layout = layout
        self.block += record
        if len(self.block) >= BLOCK:
            self._decode()

    def samples(self) -> LogSamples:
        """All that was collected."""
        self._decode()
        stamps = np.concatenate([np.empty(0, np.int64), *self.stamps])
        self.stamps = []  # so that memory holds one copy
        values = np.concatenate([np.empty((0, len(self.fields))), *self.values])
        self.values = []
        return LogSamples(self.topic, stamps, values, self.dropped)

    def _decode(self) -> None:
        layout, block = self.layout, self.block
        if layout is None or layout.stamp is None or not block:
            return
        stamps = layout.stamp.stored(block, layout.size)
        values = np.full((len(stamps), len(self.fields)), np.nan)
        for i, name in enumerate(self.fields):
            if name in layout.fields:
                values[:, i] = layout.fields[name].values(block, layout.size)
        sound = (stamps >= 0) & (stamps <= MOST_STAMP // layout.tick)
        self.dropped += int(np.count_nonzero(~sound))
        self.stamps.append(stamps[sound].astype(np.int64) * layout.tick)
        self.values.append(values[sound])
        self.block = bytearray()


def pass_blocks(file: BinaryIO, size: int, consume: Callable[[bytes, bool], int]) -> None:
    """Reads a file of `size` bytes by blocks. `consume` takes what is left and the next block, and whether the
    file has ended; it returns how much of it is done with."""
    data, done = b"", 0
    while True:
        block = file.read(READ)
        data += block
        data = data[consume(data, not block) :]
        done += len(block)
        reach(done / max(size, 1))
        if not block:
            return


def pass_lines(path: Path) -> Iterator[bytes]:
    """Lines of a text log with their ends; of one above `LONGEST_LINE`, pieces of that length."""
    with readable(path), path.open("rb") as file:
        size, done = max(path.stat().st_size, 1), 0
        for number, line in enumerate(iter(lambda: file.readline(LONGEST_LINE), b""), 1):
            done += len(line)
            if number % EVERY == 0:
                reach(done / size)
            yield line
