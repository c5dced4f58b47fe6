# SPDX-License-Identifier: MIT
"""Detection of a change of the boat while it runs: a payload, a thruster that fails, a weak battery.

Either the poses of the last seconds are as probable by the model as they were at identification, or a changed
boat explains them better. The ratio of the two evidences is averaged over the identification's errors, wind,
current and gusts. Its mean is 1 while nothing changes, so it exceeds A with a probability of 1/A at most (Markov's
inequality). A follows from the false alarms that are accepted.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.evaluation.comparison.cause_candidates import NO_CHANGE
from seatrial.monitoring.change_space import change_space
from seatrial.monitoring.change_test import (
    Explained,
    explained,
    linearised,
    log_ratio,
    most_to_gain,
)
from seatrial.monitoring.recent_log import RecentLog
from seatrial.monitoring.window_likelihood import Window, noise_of, windows
from seatrial.onboard.boat_change import BoatChange, ChangeState
from seatrial.util.errors import RecordingError

WINDOWS = (10.0, 20.0, 40.0)  # [s]
EVERY = 2.0  # [s] from test to test
FALSE_ALARMS = 0.1  # an hour
PASSING = 5.0  # [s] after the notice, in which what passes is over
CONFIRMATION = 40.0  # [s] after that: all of this window is the changed boat's
CONFIRMED = 3.0  # log ratio there: odds of 20 to 1
FIRST_LOOK = 5.0  # log ratio that further linearisations may add
FEWEST_POSES = 20  # of a window
NANO = 1_000_000_000


class ChangeDetector:
    """Tests every `every` seconds whether the boat still is the model's.

    Inputs as of `Odometer`: stamps [ns], commands to all inputs, poses of the measured point, forward-left-up.
    `look` returns a finding when there is a new one: first `NOTICED`, of which there are at most `false_alarms`
    an hour while the boat is the model's. `PASSING + CONFIRMATION` seconds later it is `WITHDRAWN`, or `CONFIRMED`
    with the changed boat's model, which the next tests take for the boat. Raises ModelError where the model states
    no noise, or its innovations are correlated (model mismatch).
    """

    def __init__(
        self,
        model: Model,
        *,
        lengths: Sequence[float] = WINDOWS,
        every: float = EVERY,
        false_alarms: float = FALSE_ALARMS,
    ) -> None:
        self.threshold = math.log(len(lengths) * 3600.0 / every / false_alarms)
        self._lengths, self._every = tuple(sorted(lengths)), round(NANO * every)
        self._log = RecentLog(model.vehicle, max(*lengths, CONFIRMATION) + every)
        self._next: int | None = None  # [ns] stamp of the next test
        self.restart(model)

    def restart(self, model: Model) -> None:
        """Test against another model, by poses from now on."""
        noise_of(model)
        self.model, self._space = model, change_space(model)
        self._since = self._log.newest  # [ns] windows begin after it
        self._noticed: int | None = None  # [ns]

    def use(self, kind: str, stamp: int, values: ArrayLike) -> None:
        """A pose (3,), position (2,), heading (1,), command (inputs,) or scale (scales,) at a stamp [ns]."""
        self._log.add(kind, stamp, np.asarray(values))

    @property
    def due(self) -> bool:
        """Whether it is time for the next test."""
        now = self._log.newest
        return now is not None and (
            self._next is None or now >= self._next or now < self._next - self._every
        )

    def look(self) -> BoatChange | None:
        """A new finding, or None. When a test is due: filter runs over the windows."""
        now = self._log.newest
        if now is None or not self.due:
            return None
        if self._next is not None and now < self._next - self._every:  # the clock was set back
            self._since = now
            self._noticed = None if self._noticed is None else now
        self._next = now + self._every
        self._since = now if self._since is None else self._since
        if self._noticed is None:
            return self._notice(now, self._since)
        begin = self._noticed + round(NANO * PASSING)
        return self._confirmation(begin, now) if now >= begin + round(NANO * CONFIRMATION) else None

    def _notice(self, now: int, since: int) -> BoatChange | None:
        """The change in the shortest window that shows one."""
        for length in self._lengths:
            start = now - round(NANO * length)
            if start < since:
                break
            several = self._several(start, now)
            seen = linearised(self._space, several)
            # most windows are as probable as ever, or gusts explain them
            if not seen or most_to_gain(self._space, seen) < self.threshold:
                continue
            # a first look, about the unchanged boat, spares most searches
            first = explained(self._space, several, seen, rounds=0)
            if log_ratio(first) < self.threshold - FIRST_LOOK:
                continue
            found = explained(self._space, several, seen)
            if log_ratio(found) > self.threshold:
                self._noticed = now
                return _finding(found, ChangeState.NOTICED, now)
        return None

    def _confirmation(self, begin: int, now: int) -> BoatChange | None:
        """The change in the window after the notice; None: too few poses tell, the next window is awaited."""
        several = self._several(begin, now)
        self._noticed, self._since = None if several else now, now
        if not several:
            return None
        seen = linearised(self._space, several)
        found = explained(self._space, several, seen) if seen else []
        if log_ratio(found) < CONFIRMED:
            return BoatChange(ChangeState.WITHDRAWN, now, NO_CHANGE)
        change = _finding(found, ChangeState.CONFIRMED, now)
        best = next(one for one in found if one.change.cause == change.cause)
        boat = self._space.boat(best.theta, best.covariance)
        finding = finding_of(FindingKind.ADAPTED, text=change.text)
        estimator = msgspec.structs.replace(
            boat.estimator, findings=[*boat.estimator.findings, finding]
        )
        changed = replace(boat, estimator=estimator)
        self.restart(changed)  # the next change is one of this boat
        return replace(change, model=changed)

    def _several(self, start: int, end: int) -> list[Window]:
        """The window with each noise; none where it has few poses."""
        try:
            recording = self._log.recording(start, end)
        except RecordingError:
            return []
        enough = int(recording.valid.sum()) >= FEWEST_POSES
        return windows(self.model, recording) if enough else []


def _changes(found: Sequence[Explained]) -> list[Explained]:
    return [one for one in found if one.change.cause != NO_CHANGE]


def _finding(found: Sequence[Explained], state: ChangeState, now: int) -> BoatChange:
    """The most probable change, all causes being equally probable before."""
    logs: dict[str, list[float]] = {}
    for one in _changes(found):
        logs.setdefault(one.change.cause, []).append(one.log_evidence)
    each = {c: float(np.logaddexp.reduce(own) - np.log(len(own))) for c, own in logs.items()}
    whole = float(np.logaddexp.reduce([*each.values()]))
    causes = {c: math.exp(log - whole) for c, log in sorted(each.items(), key=lambda e: -e[1])}
    first = next(iter(causes))
    best = next(one for one in found if one.change.cause == first)
    return BoatChange(
        state,
        now,
        first,
        best.change.what,
        causes[first],
        best.size,
        best.error,
        log_ratio(found),
        causes,
    )
