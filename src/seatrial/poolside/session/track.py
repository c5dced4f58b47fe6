# SPDX-License-Identifier: MIT
"""Where the boat was: its newest pose, the time, and a thinned track for the page."""

import math

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.coverage import AT_REST_COMMAND
from seatrial.poolside.coverage import LONGEST_INTERVAL
from seatrial.util.frames import NS_PER_S, Array

STEP = 200_000_000  # [ns] between two rows of the track
MOST_ROWS = 20_000  # more are thinned to half: 67 min at 5 Hz
MOST_LATE, LONGEST_PAUSE = 5.0, 600.0  # [s] from a pose to the next: beyond these the clock was set
Row = tuple[float, float, float, float]


class Track:
    """In the vehicle's own axes. One thread calls `use`, any thread the rest, one at a time.

    A position without a heading, or a heading without a position, completes the pose before it.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self._flip = vehicle.axes.signs
        self._pose = np.full(3, np.nan)
        self._largest = [0.0] * len(vehicle.inputs)
        self._active = False  # whether a command drives the boat
        self._since = 0  # [ns] stamp of the last row
        self.rows: list[Row] = []
        self._driven: list[float] = []  # [s] before each row
        self.origin: int | None = None  # [ns] stamp of the first pose
        self.newest: int | None = None  # [ns]
        self.poses = 0
        self.driven = 0.0  # [s]
        self.changes = 0  # times that rows got other indices

    def use(self, kind: str, stamp: int, values: Array) -> None:
        """An event of the source, forward-left-up."""
        if kind == "command":
            sizes = [abs(value) for value in values.tolist()]
            self._largest = [max(pair) for pair in zip(self._largest, sizes, strict=True)]
            pairs = zip(sizes, self._largest, strict=True)
            self._active = any(size > AT_REST_COMMAND * largest for size, largest in pairs)
        elif kind == "heading":
            self._pose[2] = self._flip[2] * values[0]
        elif kind in ("pose", "position"):
            self._pose[: len(values)] = self._flip[: len(values)] * values
            self._add(stamp)

    @property
    def active(self) -> bool:
        """Whether a command drives the boat."""
        return self._active

    @property
    def pose(self) -> tuple[float, float, float] | None:
        """x, y [m], psi [rad]; None before all are known."""
        x, y, psi = self._pose.tolist()
        return None if math.isnan(x + y + psi) else (x, y, psi)

    @property
    def time(self) -> float:
        """[s] from the first pose to the newest."""
        return 0.0 if self.origin is None or self.newest is None else self._seconds(self.newest)

    def discard(self, start: int) -> None:
        """Without the rows from this stamp [ns] on."""
        while self.rows and self.rows[-1][0] >= self._seconds(start):
            self.rows.pop()
            self.driven = self._driven.pop()
        self.changes += 1

    def _seconds(self, stamp: int) -> float:
        return (stamp - (self.origin or 0)) / NS_PER_S

    def _set_clock(self, step: int) -> None:
        """The time goes on where it was, by the clock that was set by `step` [ns]."""
        self.origin = (self.origin or 0) + step
        self.newest = (self.newest or 0) + step
        self._since += step

    def _add(self, stamp: int) -> None:
        self.poses += 1
        if self.newest is None:
            self.origin = self.newest = stamp
        step = (stamp - self.newest) / NS_PER_S
        if not -MOST_LATE <= step <= LONGEST_PAUSE:
            self._set_clock(stamp - self.newest)
        self.newest = max(stamp, self.newest)
        if self._active and 0.0 < step <= LONGEST_INTERVAL:
            self.driven += step
        if (self.rows and stamp < self._since + STEP) or self.pose is None:
            return
        self._since = stamp
        if len(self.rows) == MOST_ROWS:
            self.rows, self._driven = self.rows[::2], self._driven[::2]
            self.changes += 1
        self.rows.append((self._seconds(stamp), *self.pose))
        self._driven.append(self.driven)
