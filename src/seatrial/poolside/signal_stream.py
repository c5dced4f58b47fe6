# SPDX-License-Identifier: MIT
"""Rows of one kind of signal: the last seconds, and what is counted over the whole session. Bounded memory."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from seatrial.poolside.sources.source import EventKind
from seatrial.recording.faults.pose_faults import GAP_FACTOR, usual_step
from seatrial.recording.timing import FEW_STEPS, regular_period, silence_length
from seatrial.util.frames import NS_PER_S, Array, Stamps

WINDOW = 10.0  # [s] of arrivals that timing is judged by
MOST_ROWS = 4096  # in it
PACE_TIME = 2.0  # [s] of arrivals that show the pace of the stamps
TURN = (350.0, 370.0)  # a step of a heading between these is a turn in degrees
SIGNALS: tuple[EventKind, ...] = ("command", "scale")  # which hold until the next row


@dataclass(frozen=True)
class StreamTiming:
    """Timing of the window."""

    rate: float | None  # [Hz]; None: fewer than two stamps
    delay: float  # [s] median of arrival minus stamp, whatever the clocks
    jitter: float | None  # [s] 95th percentile of the steps less their median
    longest: float  # [s] longest step
    backward: int  # stamps at or before the one before
    pace: float | None  # [s] of stamps for one of arrivals; None: too short to know
    regular: bool
    usual: float  # [s] usual step; 0: not known yet


class SignalStream:
    """Poses, or commands, as they arrive."""

    def __init__(self, kind: EventKind, arrival: int, width: int) -> None:
        self.kind, self.first = kind, arrival
        self.rows = self.gaps = self.turns = 0  # turns: steps of a heading by 360
        self.recent: deque[tuple[int, int, list[float]]] = deque(maxlen=MOST_ROWS)
        # of each column
        self.least, self.most = [math.inf] * width, [-math.inf] * width
        self.largest = [-math.inf] * width  # absolute value
        self.at_largest = [0] * width  # rows there
        self.changed = [arrival] * width  # [ns] arrival of the last change of each value
        self._gap = 0.0  # [s] least length of one; 0: not known yet

    @property
    def newest(self) -> tuple[int, int, list[float]]:
        """Stamp and arrival [ns] and values of the newest row."""
        return self.recent[-1]

    def add(self, stamp: int, values: Array, arrival: int) -> None:
        """A row."""
        row = values.tolist()  # lists: of few numbers at a time they cost a tenth of arrays
        if self.rows:
            last, _, before = self.recent[-1]
            self.gaps += 0.0 < self._gap < (stamp - last) / NS_PER_S
            if self.kind in ("pose", "heading"):
                self.turns += TURN[0] < abs(row[-1] - before[-1]) < TURN[1]
            if row != before:
                for i, (value, old) in enumerate(zip(row, before, strict=True)):
                    if value != old:
                        self.changed[i] = arrival
        for i, value in enumerate(row):
            self._range(i, value)
        self.rows += 1
        self.recent.append((stamp, arrival, row))
        while self.recent[0][1] < arrival - WINDOW * NS_PER_S:
            self.recent.popleft()

    def _range(self, i: int, value: float) -> None:
        """A value of column i."""
        self.least[i] = min(self.least[i], value)
        self.most[i] = max(self.most[i], value)
        size = abs(value)
        if size > self.largest[i]:
            self.largest[i], self.at_largest[i] = size, 1
        elif size == self.largest[i]:
            self.at_largest[i] += 1

    def clocks(self) -> tuple[Stamps, Stamps]:
        """Stamps (n,) and arrivals (n,) [ns] of the window."""
        stamps, arrivals, _ = zip(*self.recent, strict=True)
        return np.array(stamps), np.array(arrivals)

    def values(self) -> Array:
        """Values (n, k) of the window."""
        return np.array([row for _, _, row in self.recent])

    def timing(self) -> StreamTiming:
        """Timing of the window; later gaps are counted by it."""
        stamps, arrivals = self.clocks()
        steps = np.diff(stamps) / NS_PER_S
        forward = steps[steps > 0]
        usual = usual_step(forward) if len(forward) >= FEW_STEPS else 0.0
        self._gap = _least_gap(self.kind, usual) if usual else 0.0
        delay = float(np.median(arrivals - stamps)) / NS_PER_S
        if not len(forward):
            return StreamTiming(None, delay, None, 0.0, len(steps), None, False, 0.0)
        middle = float(np.median(forward))
        return StreamTiming(
            1.0 / middle, delay, float(np.percentile(forward, 95)) - middle, float(forward.max()),
            len(steps) - len(forward), _pace(stamps, arrivals), regular_period(forward) is not None, usual,
        )  # fmt: skip


def _least_gap(kind: EventKind, usual: float) -> float:
    """Least length [s] of a gap."""
    return silence_length(usual) if kind in SIGNALS else GAP_FACTOR * usual


def _pace(stamps: Stamps, arrivals: Stamps) -> float | None:
    """Seconds of stamps for one of arrivals. Rows that arrive together count as their last."""
    last = np.flatnonzero(np.diff(arrivals, append=arrivals[-1] + 1))
    span = float(arrivals[last[-1]] - arrivals[last[0]]) / NS_PER_S
    if span < PACE_TIME:
        return None
    return float(stamps[last[-1]] - stamps[last[0]]) / NS_PER_S / span
