# SPDX-License-Identifier: MIT
"""The filter along a recording that grows, at fixed parameters: gradient and information of all poses so far."""

import numpy as np

from seatrial import _core
from seatrial.evaluation.filtering import filter_series
from seatrial.identification.likelihood.filter_runs import FilterRuns
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.problem import Problem
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array


class GrowingFilter:
    """A filter run along the one recording of a problem, continued along later parts of the same drive.

    Its sums are those of `filter_along` along the whole; its memory does not grow.
    """

    def __init__(self, problem: Problem, theta: Array, noise: Array) -> None:
        (recording,) = problem.recordings
        self._problem, self._theta, self._noise = problem, theta, noise
        self._first = recording
        self._run = _core.GrowingRun(
            problem.boat(theta), problem.trace(theta, recording), problem.series[0], noise,
            problem.outlier, problem.own_effects(theta, 0), problem.earth_fixed,
        )  # fmt: skip

    def begin(self, until: int) -> None:
        """Runs along the problem's own recording, up to a stamp [ns]."""
        trace = self._problem.trace(self._theta, self._first)
        self._run.advance(trace, self._problem.series[0], self._seconds(until))

    def advance(self, later: Recording, until: int) -> None:
        """Goes on along a part of the drive that begins at `newest` or before, up to a stamp [ns]."""
        self.go_on(*self.along(later), until)

    def along(self, later: Recording) -> tuple[_core.ThrustTrace, _core.Series]:
        """Thrust and poses of a part of the drive, for `go_on` of filters that differ in their noise alone."""
        part = later.on_clock_of(self._first)
        return self._problem.trace(self._theta, part), filter_series(part)

    def go_on(self, trace: _core.ThrustTrace, series: _core.Series, until: int) -> None:
        """As `advance`, with what `along` returned."""
        self._run.advance(trace, series, self._seconds(until))

    @property
    def newest(self) -> int:
        """Stamp [ns] of the latest measurement that it used."""
        return self._first.origin + round(1e9 * self._run.time)

    @property
    def state(self) -> Array:
        """Pose, velocity and disturbance (9,) at `newest`."""
        return np.asarray(self._run.state)

    def at(self) -> Point:
        """The parameters, with cost, gradient and information of all measurements so far."""
        runs = FilterRuns(self._problem, self._theta, (self._run.sums(),))
        return Point(self._theta, self._noise, runs)

    def _seconds(self, stamp: int) -> float:
        return float(stamp - self._first.origin) * 1e-9
