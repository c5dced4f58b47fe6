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
    FittedChange,
    by_cause,
    fitted_changes,
    linear_evidences,
    linearised,
    log_ratio,
)
from seatrial.monitoring.recent_log import RecentLog
from seatrial.monitoring.running_likelihood import RunningLikelihood
from seatrial.monitoring.window_likelihood import Window, noise_of, windows
from seatrial.onboard.boat_change import BoatChange, ChangeState
from seatrial.util.errors import RecordingError

WINDOWS = (10.0, 20.0, 40.0)  # [s]
EVERY = 2.0  # [s] from test to test
FALSE_ALARMS = 0.1  # an hour
PASSING = 5.0  # [s] after the notice, in which what passes is over
CONFIRMATION = 40.0  # [s] after that: all of this window is the changed boat's
CONFIRMED = 3.0  # log ratio there: odds of 20 to 1
FIRST_LOOK = 5.0  # log ratio that the full test may add to that of linear changes
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
        self._kept = max(*lengths, CONFIRMATION) + every  # [s]
        self._log = RecentLog(model.vehicle, self._kept)
        self._next: int | None = None  # [ns] stamp of the next test
        self.restart(model)

    def restart(self, model: Model) -> None:
        """Test against another model, by poses from now on."""
        noise_of(model)
        self.model, self._space = model, change_space(model)
        self._running = RunningLikelihood(model, self._space.wider, self._space.theta, self._kept)
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
            self._begin_at(now)
            self._noticed = None if self._noticed is None else now
        self._next = now + self._every
        self._since = now if self._since is None else self._since
        if self._noticed is None:
            return self._notice(now, self._since)
        begin = self._noticed + round(NANO * PASSING)
        return self._confirmation(begin, now) if now >= begin + round(NANO * CONFIRMATION) else None

    def _begin_at(self, stamp: int) -> None:
        """Windows begin after a stamp [ns]."""
        self._since = stamp
        self._running.restart()

    def _notice(self, now: int, since: int) -> BoatChange | None:
        """The change in the shortest window that shows one."""
        self._running.advance(self._log, since, now)
        for length in self._lengths:
            start = now - round(NANO * length)
            if start < since:
                break
            found = self._fitted(start, now) if self._suspicious(start) else []
            if log_ratio(found) > self.threshold:
                self._noticed = now
                return _finding(found, ChangeState.NOTICED, now)
        return None

    def _suspicious(self, start: int) -> bool:
        """Whether a change may show from a stamp [ns] on: by linear evidences of the running filters."""
        quadratics = self._running.quadratics(start, FEWEST_POSES)
        evidences = linear_evidences(self._space, quadratics) if quadratics else []
        return log_ratio(evidences) > self.threshold - FIRST_LOOK

    def _fitted(self, start: int, end: int) -> list[FittedChange]:
        """All changes, fitted to a window; none where it has few poses, or the boat diverges."""
        several = self._windows(start, end)
        quadratics = linearised(self._space, several)
        return fitted_changes(self._space, several, quadratics) if quadratics else []

    def _confirmation(self, begin: int, now: int) -> BoatChange | None:
        """The change in the window after the notice; None: too few poses tell, the next window is awaited."""
        self._begin_at(now)
        if not self._windows(begin, now):
            self._noticed = now
            return None
        self._noticed = None
        found = self._fitted(begin, now)
        if log_ratio(found) < CONFIRMED:
            return BoatChange(ChangeState.WITHDRAWN, now, NO_CHANGE)
        change = _finding(found, ChangeState.CONFIRMED, now)
        changed = self._changed(found, change)
        self.restart(changed)  # the next change is one of this boat
        return replace(change, model=changed)

    def _changed(self, found: Sequence[FittedChange], change: BoatChange) -> Model:
        """The changed boat's model, with a finding of the change."""
        best = next(one for one in found if one.change.cause == change.cause)
        boat = self._space.boat(best.theta, best.covariance)
        finding = finding_of(FindingKind.ADAPTED, text=change.text)
        findings = [*boat.estimator.findings, finding]
        return replace(boat, estimator=msgspec.structs.replace(boat.estimator, findings=findings))

    def _windows(self, start: int, end: int) -> list[Window]:
        """The window with each noise; none where it has few poses."""
        try:
            recording = self._log.recording(start, end)
        except RecordingError:
            return []
        enough = int(recording.valid.sum()) >= FEWEST_POSES
        return windows(self.model, recording) if enough else []


def _finding(found: Sequence[FittedChange], state: ChangeState, now: int) -> BoatChange:
    """The most probable change, all causes being equally probable before."""
    each = by_cause(found)
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
