# SPDX-License-Identifier: MIT
"""Coverage of the drive so far: seconds by speed and command of each driven axis, in bounded memory."""

import math
from bisect import bisect_right
from collections import deque

import numpy as np

from seatrial.boat.physics import full_forces
from seatrial.boat.static_forces import static_forces
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.coverage import AT_REST_COMMAND, largest_of_each
from seatrial.poolside.state import CoverageState
from seatrial.util.frames import AXES, Array

SPEED_BINS = 8  # even: the range doubles by joining pairs
COMMAND_EDGES = (-1.0, -2 / 3, -1 / 3, -AT_REST_COMMAND, AT_REST_COMMAND, 1 / 3, 2 / 3, 1.0)
FIRST_SPEEDS = np.array([0.2, 0.2, 0.4])  # [m/s, m/s, rad/s] range at the start
LONGEST_INTERVAL = 0.5  # [s] between two poses that counts as driven; a longer one is a gap
SNAPSHOT, MOST_SNAPSHOTS = 1.0, 3600  # [s] between two of them, and how many: 5 MB


class Coverage:
    """Seconds in bins of speed and command; poses are added as they come."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        self.axes = sorted({force.axis for force in vehicle.forces})
        self._range = FIRST_SPEEDS.copy()
        self._seconds = np.zeros((3, SPEED_BINS, len(COMMAND_EDGES) - 1))
        self._last: float | None = None
        self._command: list[float] = []
        self._columns = [0, 0, 0]  # bins of its forces
        # time, ranges and seconds, once a second: what `discard` returns to
        self._before: deque[tuple[float, Array, Array]] = deque(maxlen=MOST_SNAPSHOTS)

    def add(self, t: float, nu: Array, command: Array) -> None:
        """The state at a pose: t [s] rising, nu (3,) [m/s, m/s, rad/s], command (inputs,), forward-left-up."""
        step = 0.0 if self._last is None else t - self._last
        self._last = t
        if not self._before or not 0.0 <= t - self._before[-1][0] < SNAPSHOT:
            self._before.append((t, self._range.copy(), self._seconds.copy()))
        speeds = nu.tolist()
        if not 0.0 < step <= LONGEST_INTERVAL or not all(map(math.isfinite, speeds)):
            return
        columns = self._columns_of(command)
        for axis in self.axes:
            while abs(speeds[axis]) > self._range[axis]:
                self._widen(axis)
            share = (speeds[axis] / float(self._range[axis]) + 1.0) / 2.0
            row = min(int(share * SPEED_BINS), SPEED_BINS - 1)
            self._seconds[axis, row, columns[axis]] += step

    def discard(self, start: float) -> None:
        """Without what was driven since a time [s], to a second."""
        while self._before and self._before[-1][0] >= start:
            _, self._range, self._seconds = self._before.pop()

    @property
    def driven(self) -> Array:
        """Seconds (3, 2) under command of each axis: to the negative side, to the positive one."""
        middle = COMMAND_EDGES.index(-AT_REST_COMMAND)
        by_command = self._seconds.sum(axis=1)
        return np.column_stack(
            [by_command[:, :middle].sum(axis=1), by_command[:, middle + 1 :].sum(axis=1)]
        )

    def _columns_of(self, command: Array) -> list[int]:
        """Bins of the forces of the axes; a command holds over many poses."""
        values = command.tolist()
        if values != self._command:
            self._command = values
            forces = axis_commands(self.vehicle, np.array([values], dtype=float))[0]
            self._columns = [bisect_right(COMMAND_EDGES[1:-1], force) for force in forces.tolist()]
        return self._columns

    def state(self) -> tuple[CoverageState, ...]:
        """Of every driven axis, in the vehicle file's axes."""
        return tuple(self._axis(axis) for axis in self.axes)

    def _axis(self, axis: int) -> CoverageState:
        edges = self._range[axis] * np.linspace(-1.0, 1.0, SPEED_BINS + 1)
        seconds = self._seconds[axis]
        if self.vehicle.axes.value == "forward-right-down" and axis > 0:
            seconds = seconds[::-1, ::-1]  # both ranges are symmetric
        rows = tuple(tuple(row) for row in seconds.round(3).tolist())
        return CoverageState(AXES[axis], tuple(edges.tolist()), COMMAND_EDGES, rows)

    def _widen(self, axis: int) -> None:
        """Twice the range of speeds: pairs of bins join in the middle half."""
        joined = self._seconds[axis].reshape(SPEED_BINS // 2, 2, -1).sum(axis=1)
        quarter = SPEED_BINS // 4
        self._seconds[axis] = np.pad(joined, ((quarter, quarter), (0, 0)))
        self._range[axis] *= 2.0


def axis_commands(vehicle: Vehicle, commands: Array) -> Array:
    """The largest force (n, 3) of each axis under held commands (n, inputs), as shares of full command.

    By the chain's start values.
    """
    forces = static_forces(vehicle, commands) / list(full_forces(vehicle).values())
    return largest_of_each(vehicle, forces)
