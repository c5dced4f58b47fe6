# SPDX-License-Identifier: MIT
"""A bag, or a folder of a recording in several, that another program writes: messages as they are flushed."""

import time
from collections.abc import Iterator
from pathlib import Path

from seatrial.boat.vehicle import Vehicle
from seatrial.io.bags.growing.db3 import GrowingDb3
from seatrial.io.bags.growing.growing_bag import GrowingBag
from seatrial.io.bags.growing.mcap import GrowingMcap
from seatrial.io.bags.growing.ros1 import GrowingRos1
from seatrial.io.bags.signals import BagSignals
from seatrial.io.bags.tf import is_tf
from seatrial.poolside.sources.conversion import Conversion
from seatrial.poolside.sources.source import EventSource, SourceEvent
from seatrial.util.errors import FileError, LiveError, RecordingError, SeatrialError

POLL = 0.05  # [s]
SILENT = 10.0  # [s] without a message, that are reported


KINDS: dict[str, type[GrowingBag]] = {
    ".mcap": GrowingMcap,
    ".db3": GrowingDb3,
    ".bag": GrowingRos1,
    ".bag.active": GrowingRos1,
}


def growing_bag(path: Path) -> GrowingBag | None:
    """The bag at a path, or in a folder; None: it is none."""
    for end, kind in KINDS.items():
        if path.name.endswith(end) or (path.is_dir() and any(path.glob(f"*{end}"))):
            return kind(path)
    return None


class FollowBag(EventSource):
    """Messages of a bag while it grows, from its beginning. It ends when it is closed.

    Messages before every topic of the vehicle file has one are not used. A recorder that writes in chunks flushes
    one when it is full; so arrivals are by the recorder's clock. Iteration raises SeatrialError where the file is
    damaged.
    """

    recorded = True

    def __init__(self, name: str, bag: GrowingBag, vehicle: Vehicle) -> None:
        if not bag.path.parent.is_dir():
            raise FileError(f"{bag.path}: there is no folder {bag.path.parent}")
        super().__init__(name)
        self._bag, self._vehicle = bag, vehicle
        self._signals = BagSignals(self._bag, vehicle)
        self._conversion: Conversion | None = None
        self._wait = ""  # what it waits for
        self._now = 0  # [ns]
        self._grown = time.monotonic()

    def __iter__(self) -> Iterator[SourceEvent]:
        """See `EventSource`."""
        while not self._closed.is_set():
            topics = self._bag.grow()
            if topics:
                self._grown = time.monotonic()
                yield from self._events(topics)
            else:
                self._closed.wait(POLL)
        # what was added before it was closed: a block at a time, and file by file
        before = None
        while before != self._bag.place:
            before = self._bag.place
            yield from self._events(self._bag.grow())

    @property
    def problems(self) -> tuple[str, ...]:
        """See `EventSource`."""
        mistakes = str(self._conversion.mistakes) if self._conversion else ""
        silent = time.monotonic() - self._grown
        waits = (
            f"nothing was added to {self._bag.path.name} for {silent:.0f} s: has the recorder stopped? One that "
            "writes in chunks adds a chunk when it is full: let it write smaller ones"
        )
        return tuple(
            text for text in (self._wait, waits if silent > SILENT else "", mistakes) if text
        )

    def now(self) -> int:
        """The arrival [ns] of the newest event, by the recorder's clock."""
        return self._now

    def _begin(self) -> Conversion | None:
        """How messages become events, once every topic of the vehicle file has one. Raises LiveError."""
        if self._conversion is None:
            try:
                self._conversion = Conversion(self._vehicle, self._signals)
            except SeatrialError as error:
                self._wait = f"waiting: {error}"
                return None
            self._wait = ""
            for one in self._conversion.wanted:
                if is_tf(self._bag.topics[one.place]):
                    raise LiveError(
                        f"{one.wheres[0]}: {one.place} carries transforms, which can't be followed; name a topic "
                        "with poses, or replay the bag when it is closed"
                    )
        return self._conversion

    def _events(self, topics: set[str]) -> Iterator[SourceEvent]:
        conversion = self._begin() if topics else None
        wanted = [one for one in conversion.wanted if one.place in topics] if conversion else []
        if conversion is None or not wanted:
            return
        parts = []
        for one in wanted:  # each by itself: poses that can't be used take no commands with them
            try:
                (rows,) = self._signals.read([one])
            except RecordingError as error:
                conversion.mistakes.total += 1
                conversion.mistakes.add(str(error))
                continue
            parts.append((one, rows.stamps, rows.values))
        for event in conversion.events(parts) if parts else ():
            self._now = event.arrival
            yield event
