# SPDX-License-Identifier: MIT
"""Replay of a recording: its events at the pace of their stamps, faster, or as fast as they are taken."""

import time
from collections.abc import Iterator
from pathlib import Path
from threading import Event

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.vehicle import Vehicle
from seatrial.io.reader import open_signals
from seatrial.io.signals import Request, Rows
from seatrial.poolside.sources.conversion import Conversion
from seatrial.poolside.sources.source import EventSource, SourceEvent
from seatrial.recording.pose_faults import in_order
from seatrial.util.errors import LiveError
from seatrial.util.frames import Stamps

FASTEST = 1e4  # times the pace of the stamps


class ReplaySource(EventSource):
    """A log of any format. Rows keep the order of the log; one arrives at its stamp, by the log's clock."""

    recorded = True

    def __init__(self, path: Path, vehicle: Vehicle, speed: float = 1.0) -> None:
        if not 0.0 <= speed <= FASTEST:
            raise LiveError(
                f"speed {speed:g}: expected times the recording's pace, up to {FASTEST:g}; 0: as fast as possible"
            )
        self.name, self._speed, self._closed = str(path), speed, Event()
        with open_signals(path, vehicle) as signals:
            self._conversion = Conversion(vehicle, signals)
            self._rows = signals.read(self._conversion.wanted)
            self._remarks = tuple(signals.remarks)
        self._now = 0

    def __iter__(self) -> Iterator[SourceEvent]:
        """See `EventSource`."""
        begin, first = time.monotonic(), None
        for event in self._in_turn():
            first = event.arrival if first is None else first
            if self._speed > 0.0:
                due = begin + (event.arrival - first) * 1e-9 / self._speed
                self._closed.wait(max(0.0, due - time.monotonic()))
            if self._closed.is_set():
                return
            self._now = event.arrival
            yield event

    def close(self) -> None:
        """See `EventSource`."""
        self._closed.set()

    @property
    def problems(self) -> tuple[str, ...]:
        """See `EventSource`."""
        mistakes = self._conversion.mistakes
        return (*self._remarks, *([str(mistakes)] if mistakes.bad else []))

    def now(self) -> int:
        """The arrival [ns] of the newest event."""
        return self._now

    def _in_turn(self) -> Iterator[SourceEvent]:
        """All events in the order of their arrival."""
        pairs = list(zip(self._conversion.wanted, self._rows, strict=True))
        arrivals = [_arrivals(rows.stamps) for _, rows in pairs]
        which = np.repeat(np.arange(len(pairs)), [len(a) for a in arrivals])
        row = np.concatenate([np.arange(len(a)) for a in arrivals])
        order = np.argsort(np.concatenate(arrivals), kind="stable")
        which, row = which[order], row[order]
        ends = np.flatnonzero(np.diff(which, append=-1)) + 1
        for begin, end in zip(
            [0, *ends[:-1].tolist()], ends.tolist(), strict=True
        ):  # runs of one stream
            k = int(which[begin])
            yield from self._some(*pairs[k], arrivals[k], row[begin:end])

    def _some(
        self, request: Request, rows: Rows, arrivals: Stamps, index: NDArray[np.intp]
    ) -> Iterator[SourceEvent]:
        """Events of some rows of one stream; poses that are marked invalid are none."""
        if rows.marked_valid is not None:
            index = index[rows.marked_valid[index]]
        yield from self._conversion.events(
            request, rows.stamps[index], rows.values[index], arrivals[index]
        )


def _arrivals(stamps: Stamps) -> Stamps:
    """Stamps (n,) in order; a row that is out of order arrives with the one before it."""
    good = in_order(stamps, strict=False)
    last = np.maximum.accumulate(np.where(good, np.arange(len(stamps)), -1))
    first = int(np.argmax(good)) if good.any() else 0
    return np.asarray(stamps[np.where(last < 0, first, last)])
