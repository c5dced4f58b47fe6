# SPDX-License-Identifier: MIT
"""Health of the signals while they arrive: rate, delay, gaps, jumps, clocks, signs, units and order.

Timing is judged over the last seconds; signs, units and order over the drive so far
(`seatrial.inspection.consistency`).
"""

from collections.abc import Iterator
from threading import Lock

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.poolside.signal_edits import (
    SENDER,
    Edit,
    backward_inputs,
    edits,
    heading_in_degrees,
    lacking_effect,
)
from seatrial.poolside.signal_findings import (
    OWN_CLOCK,
    Found,
    clock_findings,
    command_findings,
    degree_findings,
    frozen_findings,
    jump_findings,
    missing,
    step_findings,
)
from seatrial.poolside.signal_stream import SignalStream, StreamTiming
from seatrial.poolside.sources.source import EventKind
from seatrial.poolside.state import Level, SignalState
from seatrial.recording.faults.pose_faults import FaultKind, examine
from seatrial.recording.recording import Recording
from seatrial.recording.timing import FEW_STEPS
from seatrial.util.errors import RecordingError
from seatrial.util.frames import NS_PER_S, Array

SETTLED = 2.0  # [s] of poses after a jump that show whether it is one
EXAMINED = 1.0  # [s] between two examinations of the poses
TIMED = 0.8  # [s] between two looks at the timing of the signals
RANK: dict[Level, int] = {"ok": 0, "warning": 1, "error": 2}
PLACED: tuple[EventKind, ...] = ("pose", "position")


class SignalHealth:
    """Health of all signals of a vehicle. Methods may be called from any thread.

    by_columns: the source reads by the vehicle file's columns, so that an edit of the file mends a signal.
    """

    def __init__(self, vehicle: Vehicle, *, by_columns: bool = True) -> None:
        self._vehicle, self._by_columns = vehicle, by_columns
        self._streams: dict[EventKind, SignalStream] = {}
        self._timings: dict[EventKind, StreamTiming] = {}
        self._timed = 0  # [ns] of now
        self._edits: tuple[Edit, ...] = ()
        self._backward: tuple[Edit, ...] = ()
        self._begin: int | None = None  # [ns]
        # judged [ns] of stamps, examined [ns] of now
        self._jumps = self._judged = self._examined = 0
        self._two_places = self._problem = self._lacking = ""
        self._remark = Found("ok", "")
        self._lock = Lock()

    def use(self, kind: EventKind, stamp: int, values: Array, arrival: int) -> None:
        """An event of the source."""
        with self._lock:
            self._begin = arrival if self._begin is None else self._begin
            if kind not in self._streams:
                self._streams[kind] = SignalStream(kind, arrival, len(values))
            self._streams[kind].add(stamp, values, arrival)

    def remark(self, text: str, *, usable: bool = True) -> None:
        """What the poses of the drive so far show as a whole; empty: nothing."""
        self._remark = Found("warning" if usable else "error", text)

    def check(self, recording: Recording) -> None:
        """Signs, units and order by the drive so far; takes tenths of a second."""
        self._edits = edits(recording, self._vehicle, by_columns=self._by_columns)

    def check_estimate(self, model: Model) -> None:
        """Signs of the commands, and what the poses show that the model lacks, by the estimate so far."""
        self._lacking = lacking_effect(model)
        self._backward = backward_inputs(model, by_columns=self._by_columns)

    def states(self, now: int, problem: str = "") -> tuple[SignalState, ...]:
        """State of every signal at a time [ns] of the source's clock. problem: what the source can't use."""
        with self._lock:
            self._problem = problem
            self._begin = now if self._begin is None else self._begin
            self._examine(now)
            if (
                now - self._timed >= TIMED * NS_PER_S
                or self._timings.keys() != self._streams.keys()
            ):
                self._timed = now
                self._timings = {kind: one.timing() for kind, one in self._streams.items()}
            return tuple(self._states(now, self._timings))

    def _states(self, now: int, timings: dict[EventKind, StreamTiming]) -> Iterator[SignalState]:
        split = not {"position", "heading"}.isdisjoint(self._streams)
        parts: tuple[EventKind, ...] = ("position", "heading") if split else ("pose",)
        for kind in parts:
            yield self._state(kind, kind, None, now, timings)
        for i, name in enumerate(self._vehicle.inputs):
            yield self._state("command", name, i, now, timings)
        for i, name in enumerate(self._vehicle.scales):
            yield self._state("scale", name, i, now, timings)

    def _state(
        self,
        kind: EventKind,
        name: str,
        index: int | None,
        now: int,
        timings: dict[EventKind, StreamTiming],
    ) -> SignalState:
        """One signal; `index`: its column in the rows of its kind."""
        stream = self._streams.get(kind)
        if stream is None:
            found = missing(kind, (now - (self._begin or now)) / NS_PER_S, self._problem)
            return SignalState(name, kind, 0, level=found.level, finding=found.text)
        timing = timings[kind]
        all_found = [*clock_findings(kind, timings), *step_findings(stream, timing, now)]
        all_found += self._of_values(stream, name, index, now)
        worst = max(all_found, key=lambda f: RANK[f.level], default=Found("ok", ""))
        _, arrival, values = stream.newest
        own = values if index is None else values[index : index + 1]
        return SignalState(
            name, kind, stream.rows, timing.rate, max(0.0, (now - arrival) / NS_PER_S),
            timing.delay if abs(timing.delay) < OWN_CLOCK else None, timing.jitter, stream.gaps,
            self._jumps if kind in PLACED else 0, tuple(own), worst.level, worst.text, worst.line,
        )  # fmt: skip

    def _of_values(
        self, stream: SignalStream, name: str, index: int | None, now: int
    ) -> Iterator[Found]:
        """What the values show, and the drive so far."""
        signal = name if index is not None else "pose"
        for one in (*self._edits, *self._backward):  # of several the first is shown
            if one.signal == signal:
                yield Found("error", one.text, one.line)
        if index is not None:
            mend = "" if self._by_columns else SENDER
            yield from command_findings(name, stream, index, now, mend)
            return
        if self._remark.text:  # which makes jumps of its own
            yield self._remark
        elif self._two_places:
            yield Found("error", self._two_places)
        if self._lacking:
            yield Found("warning", self._lacking)
        line = heading_in_degrees(self._vehicle) if self._by_columns else ""
        yield from degree_findings(stream, line)
        yield from frozen_findings(stream, self._streams.get("command"), now)
        if stream.kind in PLACED and not self._remark.text:
            yield from jump_findings(self._jumps)

    def _examine(self, now: int) -> None:
        """Count the jumps of the poses in the window, each once."""
        stream = next((self._streams[k] for k in PLACED if k in self._streams), None)
        if (
            stream is None
            or len(stream.recent) < FEW_STEPS
            or now - self._examined < EXAMINED * NS_PER_S
        ):
            return
        self._examined = now
        (stamps, _), values = stream.clocks(), stream.values()
        eta = values if values.shape[1] == 3 else np.column_stack([values, np.zeros(len(values))])
        try:
            found = examine("poses", stamps, eta, None)
        except RecordingError as error:
            self._two_places = str(error)
            return
        self._two_places = ""
        first, settled = int(stamps[found.in_order][0]), int(stamps[-1] - SETTLED * NS_PER_S)
        for fault in found.faults:
            if fault.kind in (FaultKind.JUMP, FaultKind.EXCURSION):
                self._jumps += self._judged < first + round(fault.start * NS_PER_S) <= settled
        self._judged = max(self._judged, settled)
