# SPDX-License-Identifier: MIT
"""Likelihood of the last seconds about the unchanged boat, by filters that go on with the drive.

`Window.quadratic` filters the poses of a window anew for each test. Here each noise's filter uses a pose once.
A window is the difference of the sums at its ends. The filter knows the state at the window's start from earlier
poses. So the evidence is close to that of `Window.quadratic`, not equal: it chooses the windows that are worth
the full test.
"""

from collections import deque
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from seatrial.boat.model import Model
from seatrial.identification.likelihood.growing_filter import GrowingFilter
from seatrial.monitoring.recent_log import RecentLog
from seatrial.monitoring.window_likelihood import (
    Quadratic,
    Sums,
    dispersion,
    nuisance_deviations,
    windows,
    without_nuisances,
)
from seatrial.util.errors import RecordingError
from seatrial.util.frames import NS_PER_S, Array
from seatrial.util.progress import over

HOLD = 300_000_000  # [ns] in which rows may arrive late
CONTEXT = 5_000_000_000  # [ns] before new poses, which shows their faults
BEGINNING = 3_000_000_000  # [ns] of poses with which the filters begin


@dataclass(frozen=True)
class Mark:
    """Sums of each noise's filter over all poses up to a stamp."""

    stamp: int  # [ns]
    sums: tuple[Sums, ...]  # (noises)
    poses: int  # number of usable ones


@dataclass(frozen=True)
class RunningWindow:
    """The last seconds with each noise, about the unchanged boat."""

    quadratics: list[Quadratic]  # (noises) over the dispersion
    dispersion: float  # of the scores, with the noise that explains them best


class RunningLikelihood:
    """Windows that end at the newest poses, of the last `length` [s].

    model: with the noise; wider, theta (n,): the same boat with the parameters in which it may change. Memory does
    not grow. `advance` and `window` from one thread.
    """

    def __init__(self, model: Model, wider: Model, theta: Array, length: float) -> None:
        self._model, self._wider, self._theta = model, wider, theta
        self._length = round(NS_PER_S * length)
        self.restart()

    def restart(self) -> None:
        """Forget all poses; the filters begin again."""
        self._filters: list[GrowingFilter] = []
        self._deviations: Array | None = None
        self._marks: deque[Mark] = deque()

    def advance(self, log: RecentLog, since: int, now: int) -> None:
        """Use the poses up to `now` [ns], but for those that others may still come before; none before `since`."""
        until = now - HOLD
        if self._filters and not self._newest <= until <= self._newest + self._length:
            self.restart()  # the clock was set, or no poses came for long
        if not self._filters:
            self._begin(log, since, until)
            return
        latest = self._filters[0].newest
        try:
            part = log.recording(max(since, latest - CONTEXT), until)
        except RecordingError:
            return  # too few poses: the next part has these, too
        if part.origin > latest:
            self.restart()  # the filters have no pose to go on from
            return
        before, poses = self._newest, self._marks[-1].poses
        trace, series = self._filters[0].along(part)  # the same for all noises
        for one in over(self._filters):
            one.go_on(trace, series, until)
        new = part.valid & (part.stamps > before) & (part.stamps <= until)
        self._mark(until, poses + int(new.sum()))

    def window(self, start: int, fewest: int) -> "RunningWindow | None":
        """From `start` [ns] to the newest poses; None where filters do not reach back, or poses are fewer."""
        first = max((i for i, mark in enumerate(self._marks) if mark.stamp <= start), default=None)
        if first is None or self._deviations is None:
            return None
        marks = [*self._marks][first:]
        if marks[-1].poses - marks[0].poses < fewest:
            return None
        of_noises = [
            [end.since(begin) for begin, end in pairwise(sums)]
            for sums in zip(*(mark.sums for mark in marks), strict=True)
        ]
        whole = [
            end.since(begin).marginal(self._theta, self._deviations)
            for begin, end in zip(marks[0].sums, marks[-1].sums, strict=True)
        ]
        likeliest = int(np.argmax([one.most for one in whole]))
        scatter = dispersion(of_noises[likeliest])
        return RunningWindow([one.over(scatter) for one in whole], scatter)

    @property
    def _newest(self) -> int:
        """Stamp [ns] up to which the poses are used."""
        return self._marks[-1].stamp

    def _begin(self, log: RecentLog, since: int, until: int) -> None:
        if until - since < BEGINNING:
            return
        start = max(since, until - CONTEXT)
        try:
            recording = log.recording(start, until)
        except RecordingError:
            return
        for window in windows(self._model, recording):
            problem = window.problem(self._wider)
            self._deviations = nuisance_deviations(problem, self._wider)
            theta = without_nuisances(problem, self._theta)
            self._filters.append(GrowingFilter(problem, theta, window.noise))
            self._filters[-1].begin(until)
        zero = tuple(sums.since(sums) for sums in self._sums())
        self._marks.append(Mark(start, zero, 0))
        self._mark(until, int(recording.valid.sum()))

    def _mark(self, stamp: int, poses: int) -> None:
        """Note the sums; forget those that no window needs, and all where the boat diverged."""
        sums = self._sums()
        if not all(np.isfinite(one.cost) for one in sums):
            self.restart()
            return
        self._marks.append(Mark(stamp, sums, poses))
        while len(self._marks) > 1 and self._marks[1].stamp <= stamp - self._length:
            self._marks.popleft()

    def _sums(self) -> tuple[Sums, ...]:
        return tuple(Sums.of(one.at().runs) for one in self._filters)
