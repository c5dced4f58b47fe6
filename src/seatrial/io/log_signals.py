# SPDX-License-Identifier: MIT
"""Signals of a log of topics: an autopilot's messages."""

from collections.abc import Sequence

from seatrial.boat.schema import Column
from seatrial.io.log import Log, Wanted
from seatrial.io.signals import Request, Rows, Signals, Spec, of_columns
from seatrial.recording.timing import describe
from seatrial.util.errors import RecordingError


class LogSignals(Signals):
    """Topics of an open log."""

    def __init__(self, log: Log) -> None:
        self.path, self.files, self._log = log.path, log.files, log

    def place(self, column: Column, spec: Spec, where: str) -> str:
        """The column's topic."""
        topic = column.topic or spec.topic
        if topic is None or not (column.field or column.quaternion):
            lacks = "topic" if topic is None else "field"
            raise RecordingError(
                f"{where} has no {lacks}; name one, or let 'seatrial init {self.path}' write a vehicle file"
            )
        return topic

    def read(self, requests: Sequence[Request]) -> list[Rows]:
        """The rows of each request, in one pass."""
        for one in requests:
            self._log.require(one.place, one.paths, one.wheres[0])
        samples = self._log.read([Wanted(one.place, one.paths) for one in requests])
        dropped = [f"{s.dropped} unreadable messages of {s.topic}" for s in samples if s.dropped]
        self.remarks = (*self._log.remarks, *dropped)
        found = []
        for one, own in zip(requests, samples, strict=True):
            if not len(own.stamps):
                raise RecordingError(f"{self.path}: no message of {one.place} could be read")
            kind = self._log.topics[one.place].type
            stream = describe(one.role, one.place, kind, clock=self._log.clock, stamps=own.stamps)
            found.append(Rows(own.stamps, of_columns(own.values, one.columns), stream))
        return found
