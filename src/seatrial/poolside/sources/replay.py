# SPDX-License-Identifier: MIT
"""Replay of a recording: its events at the pace of their stamps, faster, or as fast as they are taken."""

import time
from collections.abc import Iterator
from pathlib import Path

from seatrial.boat.vehicle import Vehicle
from seatrial.io.reader import open_signals
from seatrial.io.signals import Request, Rows
from seatrial.poolside.sources.conversion import Conversion
from seatrial.poolside.sources.source import EventSource, SourceEvent
from seatrial.util.errors import LiveError
from seatrial.util.frames import Array, Stamps

FASTEST = 1e4  # times the pace of the stamps


class ReplaySource(EventSource):
    """A log of any format. Rows keep the order of the log; one arrives at its stamp, by the log's clock."""

    recorded = True

    def __init__(
        self, path: Path, vehicle: Vehicle, speed: float = 1.0, *, salvage: bool = False
    ) -> None:
        if not 0.0 <= speed <= FASTEST:
            raise LiveError(
                f"speed {speed:g}: expected times the recording's pace, up to {FASTEST:g}; 0: as fast as possible"
            )
        super().__init__(str(path))
        self._speed = speed
        with open_signals(path, vehicle, salvage=salvage) as signals:
            self._conversion = Conversion(vehicle, signals)
            wanted = self._conversion.wanted
            read = signals.read(wanted)
            self._parts = [_usable(*each) for each in zip(wanted, read, strict=True)]
            self._remarks = tuple(signals.remarks)
        self._now = 0

    def __iter__(self) -> Iterator[SourceEvent]:
        """See `EventSource`."""
        begin, first = time.monotonic(), None
        for event in self._conversion.events(self._parts):
            first = event.arrival if first is None else first
            if self._speed > 0.0:
                due = begin + (event.arrival - first) * 1e-9 / self._speed
                self._closed.wait(max(0.0, due - time.monotonic()))
            if self._closed.is_set():
                return
            self._now = event.arrival
            yield event

    @property
    def problems(self) -> tuple[str, ...]:
        """See `EventSource`."""
        mistakes = self._conversion.mistakes
        return (*self._remarks, *([str(mistakes)] if mistakes.bad else []))

    def now(self) -> int:
        """The arrival [ns] of the newest event."""
        return self._now


def _usable(request: Request, rows: Rows) -> tuple[Request, Stamps, Array]:
    """A stream without the poses that are marked invalid."""
    if rows.marked_valid is None:
        return request, rows.stamps, rows.values
    return request, rows.stamps[rows.marked_valid], rows.values[rows.marked_valid]
