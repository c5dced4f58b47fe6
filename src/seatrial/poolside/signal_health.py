# SPDX-License-Identifier: MIT
"""Health of the signals while they arrive: rate, delay, gaps, jumps, clocks, signs, units and order.

Timing is judged over the last `WINDOW` of arrivals, signs, units and order over the drive so far
(`seatrial.inspection.consistency`).
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.poolside.signal_edits import Edit, edits
from seatrial.poolside.sources.source import EventKind
from seatrial.poolside.state import Level, SignalState
from seatrial.recording.other_clock import FACTOR_SLACK, FACTORS, other_zone
from seatrial.recording.pose_faults import GAP_FACTOR, FaultKind, examine, usual_step
from seatrial.recording.recording import Recording
from seatrial.recording.timing import FEW_STEPS, regular_period, silence_length
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps

WINDOW = 10.0  # [s] of arrivals that timing is judged by
MOST_ROWS = 4096  # of a signal in the window
MISSING = 2.0  # [s] after which a signal that has not arrived is missing
STOPPED = 1.0  # [s] least silence after which poses have stopped
OWN_CLOCK = 10.0  # [s] from this machine's clock, above which stamps are of a clock of their own
LATE, AHEAD = 0.5, 0.1  # [s] of stamps behind and ahead of this machine's clock that are reported
APART = 0.5  # [s] between the delays of poses and commands: two clocks
PACE_TIME = 2.0  # [s] of arrivals that show the pace of the stamps
PACE = 1.5  # ratio of stamps to arrivals, or its inverse, above which their unit is wrong
CONSTANT = 10.0  # [s] without a change, of a command
SATURATED = 0.5  # of the window at the largest value
RAW = 10.0  # command units: a larger command is a raw number, as PWM
FROZEN = 2.0  # [s] of exactly equal poses under changing commands
SETTLED = 2.0  # [s] of poses after a jump that show whether it is one
EXAMINED = 1.0  # [s] between two examinations of the poses
TURN = (350.0, 370.0)  # a step of the heading between these is a turn in degrees
NANO = 1e-9
RANK: dict[Level, int] = {"ok": 0, "warning": 1, "error": 2}
PARTS: dict[EventKind, str] = {"pose": "poses", "position": "positions", "heading": "headings",
                               "command": "commands", "scale": "scales"}  # fmt: skip
Found = tuple[Level, str]


@dataclass
class _Stream:
    """Rows of one kind: the window, and what is counted over the whole session."""

    rows: int = 0
    gaps: int = 0
    period: float = 0.0  # [s] of the window; 0: not known yet
    recent: deque[tuple[int, int, Array]] = field(default_factory=lambda: deque(maxlen=MOST_ROWS))
    least: Array = field(default_factory=lambda: np.zeros(0))
    most: Array = field(default_factory=lambda: np.zeros(0))
    at_most: Array = field(
        default_factory=lambda: np.zeros(0)
    )  # rows at the largest absolute value
    changed: list[int] = field(default_factory=list)  # [ns] arrival of each value's last change
    first: int = 0  # [ns] arrival

    def add(self, stamp: int, values: Array, arrival: int, gap: float) -> None:
        """A row; a step above `gap` [s] is counted."""
        if self.rows == 0:
            self.first, self.least, self.most = arrival, values, values
            self.changed = [arrival] * len(values)
        else:
            last, _, before = self.recent[-1]
            self.gaps += 0.0 < gap < (stamp - last) * NANO
            self.least, self.most = np.minimum(self.least, values), np.maximum(self.most, values)
            for i in np.flatnonzero(values != before).tolist():
                self.changed[i] = arrival
        self.rows += 1
        self.recent.append((stamp, arrival, values))
        while self.recent[0][1] < arrival - WINDOW / NANO:
            self.recent.popleft()

    def columns(self) -> tuple[Stamps, Stamps, Array]:
        """Stamps (n,) and arrivals (n,) [ns], values (n, k) of the window."""
        stamps, arrivals, values = zip(*self.recent, strict=True)
        return np.array(stamps), np.array(arrivals), np.array(values)


@dataclass(frozen=True)
class _Timing:
    """Timing of a stream over its window."""

    rate: float | None  # [Hz]
    delay: float  # [s] median of arrival minus stamp, whatever the clocks
    jitter: float | None  # [s]
    longest: float  # [s] longest step
    backward: int  # stamps at or before the one before
    pace: float | None  # [s] of stamps for one of arrivals
    regular: bool


class SignalHealth:
    """Health of all signals of a vehicle.

    by_columns: the source reads by the vehicle file's columns, so that an edit of the file mends a signal.
    """

    def __init__(self, vehicle: Vehicle, *, by_columns: bool = True) -> None:
        self._vehicle, self._by_columns = vehicle, by_columns
        self._streams: dict[EventKind, _Stream] = {}
        self._edits: tuple[Edit, ...] = ()
        self._begin: int | None = None
        self._jumps, self._judged, self._examined = 0, 0, 0
        self._two_places = ""

    def use(self, kind: EventKind, stamp: int, values: Array, arrival: int) -> None:
        """An event of the source."""
        self._begin = arrival if self._begin is None else self._begin
        stream = self._streams.setdefault(kind, _Stream())
        stream.add(stamp, values, arrival, _gap(kind, stream.period))

    def check(self, recording: Recording) -> None:
        """Signs, units and order by the drive so far; takes tenths of a second."""
        self._edits = edits(recording, self._vehicle, by_columns=self._by_columns)

    def states(self, now: int) -> tuple[SignalState, ...]:
        """State of every signal at a time [ns] of the source's clock."""
        self._begin = now if self._begin is None else self._begin
        timings = {kind: _timing(stream) for kind, stream in self._streams.items()}
        self._examine(now)
        return tuple(self._states(now, timings))

    def _states(self, now: int, timings: dict[EventKind, _Timing]) -> Iterator[SignalState]:
        split = "position" in self._streams or "heading" in self._streams
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
        timings: dict[EventKind, _Timing],
    ) -> SignalState:
        stream = self._streams.get(kind)
        if stream is None:
            level, text = self._missing(kind, now)
            return SignalState(name, kind, 0, level=level, finding=text)
        timing = timings[kind]
        newest = stream.recent[-1]
        found: list[Found] = [*self._clocks(kind, timings), *_steps(kind, stream, timing, now)]
        edit = ""
        if index is None:
            found += self._pose_faults(stream, now)
        else:
            found += _command_faults(name, stream, index, now)
        for one in self._edits:
            if one.signal == name or (one.signal == "pose" and kind in ("position", "heading")):
                found.append(("error", one.text))
                edit = edit or one.line
        level, text = max(found, key=lambda f: RANK[f[0]], default=("ok", ""))
        own = newest[2] if index is None else newest[2][index : index + 1]
        return SignalState(
            name, kind, stream.rows, timing.rate, max(0.0, (now - newest[1]) * NANO),
            timing.delay if abs(timing.delay) < OWN_CLOCK else None, timing.jitter, stream.gaps,
            self._jumps if kind in ("pose", "position") else 0, tuple(own.tolist()), level, text, edit,
        )  # fmt: skip

    def _missing(self, kind: EventKind, now: int) -> Found:
        waited = (now - (self._begin or now)) * NANO
        if waited < MISSING:
            return "ok", f"waiting for {PARTS[kind]}"
        what = {
            "command": "no coefficient can be estimated without them; drive, and check the columns or topic",
            "scale": "thrust can't be scaled; check the columns or topic of scales",
        }.get(
            kind,
            "nothing can be estimated; start the tracker, and check its port, topic or columns",
        )
        return "error", f"no {PARTS[kind]} for {waited:.0f} s: {what}"

    def _clocks(self, kind: EventKind, timings: dict[EventKind, _Timing]) -> Iterator[Found]:
        """Clocks and units of the stamps."""
        own = timings[kind]
        if own.pace is not None and not 1.0 / PACE < own.pace < PACE:
            factor = max(own.pace, 1.0 / own.pace)
            unit = any(abs(factor / f - 1.0) < FACTOR_SLACK for f in FACTORS)
            advice = (
                "their unit is not that of the vehicle file; set unit at stamp"
                if unit
                else ("the sender's clock has another pace; stamp by its system's clock")
            )
            yield "error", f"stamps advance {own.pace:.3g} s in one second: {advice}"
            return
        others = [timings[k] for k in ("pose", "position") if k in timings]
        apart = own.delay - others[0].delay if others and kind in ("command", "scale") else 0.0
        if abs(apart) > APART:
            side = "behind" if apart > 0 else "ahead of"
            zone = other_zone(np.array([0.0, 1.0]), np.array([-apart, 1.0 - apart]))
            yield (
                "error",
                zone
                or (
                    f"stamps are {abs(apart):.3g} s {side} those of the poses: two clocks; stamp both by "
                    "one clock, or synchronise them"
                ),
            )
        elif -OWN_CLOCK < own.delay < -AHEAD:
            yield (
                "warning",
                (
                    f"stamps are {-own.delay:.3g} s ahead of this machine's clock; synchronise the clocks. The "
                    "estimate is right as long as poses and commands have one clock"
                ),
            )
        elif LATE < own.delay < OWN_CLOCK:
            yield (
                "warning",
                (
                    f"{PARTS[kind]} arrive {own.delay:.3g} s after their stamps: the page is late by as much; look "
                    "for a slow network, or synchronise the clocks"
                ),
            )

    def _examine(self, now: int) -> None:
        """Count jumps of the poses in the window; each once."""
        kind: EventKind = "pose" if "pose" in self._streams else "position"
        stream = self._streams.get(kind)
        if (
            stream is None
            or now - self._examined < EXAMINED / NANO
            or len(stream.recent) < FEW_STEPS
        ):
            return
        self._examined = now
        stamps, _, values = stream.columns()
        eta = values if values.shape[1] == 3 else np.column_stack([values, np.zeros(len(values))])
        try:
            found = examine("poses", stamps, eta, None)
        except RecordingError as error:
            self._two_places = str(error)
            return
        self._two_places = ""
        settled = int(stamps[-1] - SETTLED / NANO)
        first = int(stamps[found.in_order][0])
        for fault in found.faults:
            if fault.kind in (FaultKind.JUMP, FaultKind.EXCURSION):
                at = first + round(fault.start / NANO)
                self._jumps += self._judged < at <= settled
        self._judged = max(self._judged, settled)

    def _pose_faults(self, stream: _Stream, now: int) -> Iterator[Found]:
        if self._two_places:
            yield "error", self._two_places
        still = (now - max(stream.changed)) * NANO
        commands = self._streams.get("command")
        driven = commands is not None and np.any(commands.recent[-1][2]) and still > FROZEN
        if driven and commands is not None and (now - max(commands.changed)) * NANO < still:
            yield (
                "error",
                (
                    f"the pose has been exactly the same for {still:.1f} s under command: is the tracker frozen?"
                ),
            )
        if self._jumps:
            yield (
                "warning",
                (
                    f"{self._jumps} jumps: false matches of the tracker; they are left out. Check markers, light "
                    "and reflections if there are many"
                ),
            )


def _gap(kind: EventKind, period: float) -> float:
    """Least length [s] of a gap; 0: the period is not known yet."""
    if kind in ("command", "scale"):
        return silence_length(period) if period else 0.0
    return GAP_FACTOR * period


def _timing(stream: _Stream) -> _Timing:
    """Timing of the window; also sets the stream's period."""
    stamps, arrivals, _ = stream.columns()
    steps = np.diff(stamps) * NANO
    forward = steps[steps > 0]
    regular = regular_period(forward)
    stream.period = usual_step(forward) if len(forward) >= FEW_STEPS else 0.0
    delay = float(np.median(arrivals - stamps)) * NANO
    if not len(forward):
        return _Timing(None, delay, None, 0.0, len(steps), None, False)
    middle = float(np.median(forward))
    return _Timing(
        1.0 / middle, delay, float(np.percentile(forward, 95)) - middle, float(forward.max()),
        len(steps) - len(forward), _pace(stamps, arrivals), regular is not None,
    )  # fmt: skip


def _pace(stamps: Stamps, arrivals: Stamps) -> float | None:
    """Seconds of stamps for one of arrivals; None: too short to know. Rows that arrive together are one."""
    last = np.flatnonzero(np.diff(arrivals, append=arrivals[-1] + 1))
    span = float(arrivals[last[-1]] - arrivals[last[0]]) * NANO
    if span < PACE_TIME:
        return None
    return float(stamps[last[-1]] - stamps[last[0]]) * NANO / span


def _steps(kind: EventKind, stream: _Stream, timing: _Timing, now: int) -> Iterator[Found]:
    """Silence, gaps, order and evenness of a stream."""
    silent, limit = (now - stream.recent[-1][1]) * NANO, max(STOPPED, 10.0 * stream.period)
    periodic = kind not in ("command", "scale") or timing.regular
    if periodic and silent > limit:
        yield (
            "error",
            f"no {PARTS[kind]} for {silent:.1f} s: they have stopped; check the sender and the network",
        )
    if timing.backward:
        yield (
            "warning",
            (
                f"{timing.backward} stamps in the last {WINDOW:.0f} s are not after the one before; such rows are "
                "left out. Look for two senders, or a sender that stamps twice"
            ),
        )
    if periodic and stream.period and timing.longest > max(STOPPED, GAP_FACTOR * stream.period):
        yield (
            "warning",
            (
                f"a gap of {timing.longest:.1f} s in the last {WINDOW:.0f} s: the {PARTS[kind]} are not bridged; "
                "keep the boat in view, and check the network"
            ),
        )


def _command_faults(name: str, stream: _Stream, i: int, now: int) -> Iterator[Found]:
    """Constant, saturated and raw commands."""
    low, high = float(stream.least[i]), float(stream.most[i])
    largest = max(abs(low), abs(high))
    if largest > RAW:
        yield (
            "error",
            (
                f"{name} reaches {largest:.4g}: is it a raw number, as PWM? Full thrust is 1; give offset and scale "
                f"at commands: inputs: {name}"
            ),
        )
    seconds = (now - stream.first) * NANO
    if low == high and seconds > CONSTANT:
        yield (
            "warning",
            (
                f"{name} has been {low:.4g} for {seconds:.0f} s: drive with it, or check its column or field"
            ),
        )
    recent = np.array([abs(row[2][i]) for row in stream.recent])
    share = float(np.mean(recent == largest))
    if low < high and share > SATURATED and len(recent) >= FEW_STEPS and len(np.unique(recent)) > 1:
        yield (
            "warning",
            (
                f"{name} is at its largest value {largest:.4g} for {100 * share:.0f} % of the last {WINDOW:.0f} s: "
                "a saturated command shows the thrust at one point only; drive with smaller ones, too"
            ),
        )
