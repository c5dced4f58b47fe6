# SPDX-License-Identifier: MIT
"""A ROS 1 bag that rosbag writes now: .bag.active, .bag when it is closed."""

from pathlib import Path
from typing import NoReturn

from seatrial.io.bags.growing.growing_bag import BLOCK, LARGEST_RECORD, GrowingBag
from seatrial.io.bags.ros1 import Ros1Bag
from seatrial.io.bags.ros1_records import (
    BAG_HEADER,
    CHUNK,
    CHUNK_INFO,
    CONNECTION,
    INDEX,
    MAGIC,
    DamagedError,
    Record,
    chunk_content,
    chunk_messages,
    is_encrypted,
    read_record,
)
from seatrial.io.bags.ros2 import by_number
from seatrial.util.errors import RecordingError

ACTIVE = ".active"  # end of the name while rosbag writes


class GrowingRos1(GrowingBag, Ros1Bag):
    """Messages of a chunk as they are written, of a compressed one when it is full."""

    suffix = ".bag"

    def __init__(self, path: Path) -> None:
        super().__init__(path.with_name(path.name.removesuffix(ACTIVE)))

    def _begin(self) -> None:
        self._known, self._callers = {}, {}
        self._inside = 0  # [bytes] of the newest chunk that are used

    def _there(self) -> list[Path]:
        folder = self.path.is_dir()
        written = self.path.glob(f"*.bag{ACTIVE}") if folder else [_active(self.path)]
        # before the closed ones: a file that is renamed in between is seen twice, not missed
        now = [p.with_name(p.name.removesuffix(ACTIVE)) for p in written if p.exists()]
        return sorted({*now, *super()._there()}, key=by_number)

    def _names(self) -> tuple[Path, ...]:
        return _active(self.files[-1]), self.files[-1]

    def _read(self) -> None:
        self._use(self._after_magic(self._bytes(), MAGIC, "a ROS 1 bag"))

    def _use(self, block: bytes) -> None:
        """The whole records of a block."""
        at = 0
        try:
            if _has_header(block, 0):  # a record may be longer
                end = read_record(block, 0, len(block), whole=False).end
                if BLOCK < end <= LARGEST_RECORD:
                    block = self._bytes(end)
            while not self._complete and _has_header(block, at):
                record = read_record(block, at, len(block), whole=False)
                if record.end - at > LARGEST_RECORD:
                    self._damaged(at, "a record is too long")
                if record.end > len(block) or not self._take(record):
                    break
                at = record.end
        except DamagedError as error:
            self._damaged(at, str(error))
        self._at += at

    def _damaged(self, at: int, how: str) -> NoReturn:
        raise RecordingError(
            f"{self.files[-1]}: is damaged at byte {self._at + at} ({how}); replay it with --salvage"
        ) from None

    def _take(self, record: Record) -> bool:
        """Use a record. Whether it is finished."""
        if record.kind in (CHUNK_INFO, CONNECTION):  # the index behind all chunks
            self._complete = True
        elif record.kind == CHUNK:
            return self._chunk_of(record)
        elif record.kind not in (BAG_HEADER, INDEX):
            raise DamagedError(f"a record of kind {record.kind}")
        elif record.kind == BAG_HEADER and is_encrypted(record):
            raise RecordingError(f"{self.files[-1]}: is encrypted, so it can't be followed")
        return True

    def _chunk_of(self, record: Record) -> bool:
        """Messages of a chunk; while it is written its lengths are 0."""
        open_now = record.end == record.begin
        # rosbag writes its two lengths one after the other: one of them may be there
        last = record.end == len(record.source)
        ending = last and not open_now and record.u32(b"size") == 0
        if ending or (open_now and record.text(b"compression") != "none"):
            return False
        chunk = record.source[record.begin :] if open_now else chunk_content(record)
        try:
            for number, stamp, begin, end in chunk_messages(
                chunk, self._add_connection, self._inside
            ):
                self._inside = end
                if number in self._known:
                    name = self._known[number].name
                    self._new.append((name, stamp, chunk[begin:end]))
        except DamagedError:
            if not open_now:
                raise
        if open_now:
            return False
        self._inside = 0
        return True


def _active(path: Path) -> Path:
    """The name while rosbag writes."""
    return path.with_name(path.name + ACTIVE)


def _has_header(block: bytes, at: int) -> bool:
    """Whether a record's header and the length of its data are there."""
    if at + 8 > len(block):
        return False
    return at + 8 + int.from_bytes(block[at : at + 4], "little") <= len(block)
