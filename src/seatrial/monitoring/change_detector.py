# SPDX-License-Identifier: MIT
"""Detection of a change of the boat while it runs: a payload, a thruster that fails, a weak battery.

Either the poses of the last seconds are as probable by the model as they were at identification, or a changed
boat explains them better. The ratio of the two evidences is averaged over the identification's errors, wind,
current, gusts and waves. Its mean is 1 while nothing changes, so it exceeds A with a probability of 1/A at most
(Markov's inequality). A follows from the false alarms that are accepted.

Three steps, from cheap to thorough: filters that go on with the drive (`running_likelihood`); closed forms of the
evidence by their sums; the search of each change (`change_test`), in the few windows where these show one.
"""

from __future__ import annotations

import math
from collections import deque
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
    mean_over_noises,
    probable_noises,
)
from seatrial.monitoring.recent_log import KINDS, RecentLog
from seatrial.monitoring.running_likelihood import RunningLikelihood, RunningWindow
from seatrial.monitoring.window_likelihood import noise_of, windows
from seatrial.onboard.boat_change import BoatChange, ChangeState
from seatrial.util.arguments import expect
from seatrial.util.errors import ModelError, PredictorError, RecordingError
from seatrial.util.frames import NS_PER_S, POSE
from seatrial.util.rows import row_of

WINDOWS = (10.0, 20.0, 40.0)  # [s]
EVERY = 2.0  # [s] from test to test
FALSE_ALARMS = 0.02  # an hour, at most, in weather of these noises: other weather gives some more
PASSING = 5.0  # [s] after the notice, in which what passes is over
CONFIRMATION = 40.0  # [s] after that: all of this window is the changed boat's
CONFIRMED = 3.0  # log ratio there: odds of 20 to 1
LINEAR_ERROR = 5.0  # by which the log ratio of linear changes may be below that of the full test
FEWEST_POSES = 20  # of a window


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
        expect(model, Model, "model")
        if not (lengths and min(lengths) > 0.0 and every > 0.0 and false_alarms > 0.0):
            raise ModelError(
                f"lengths {tuple(lengths)} s, every {every} s, false_alarms {false_alarms}: expected numbers "
                "above 0"
            )
        self.threshold = math.log(len(lengths) * 3600.0 / every / false_alarms)
        self._lengths, self._every = tuple(sorted(lengths)), round(NS_PER_S * every)
        self._suspicious = self.threshold - LINEAR_ERROR  # log ratio of linear changes
        self._kept = max(*lengths, CONFIRMATION) + 2.0 * every  # [s]
        self._log = RecentLog(model.vehicle, self._kept)
        self._next: int | None = None  # [ns] stamp of the next test
        self._begins: deque[int] = deque()  # [ns] stamps after which windows are to begin
        self.restart(model)

    def restart(self, model: Model) -> None:
        """Test against another model, by poses from now on."""
        noise_of(model)
        self.model, self._space = model, change_space(model)
        self._running = RunningLikelihood(model, self._space.wider, self._space.theta, self._kept)
        self._since = self._log.newest  # [ns] windows begin after it
        self._noticed: int | None = None  # [ns]

    def use(self, kind: str, stamp: int, values: ArrayLike) -> None:
        """A pose (3,), position (2,), heading (1,), command (inputs,) or scale (scales,) at a stamp [ns].

        Raises PredictorError for another kind, or another number of values.
        """
        if kind not in KINDS:
            raise PredictorError(f"no kind {kind!r}; there are {', '.join(KINDS)}")
        vehicle = self.model.vehicle
        names = {
            "command": vehicle.inputs,
            "scale": vehicle.scales,
            "heading": POSE[2:],
            "position": POSE[:2],
        }
        row = row_of(np.atleast_1d(values), kind, names.get(kind, POSE), PredictorError)
        self._log.add(kind, stamp, row)

    def begin_after(self, stamp: int) -> None:
        """Test by poses after a stamp [ns]: until then the boat was touched, or towed. From any thread.

        A change that was noticed is confirmed, or withdrawn, by poses after it.
        """
        self._begins.append(stamp)

    @property
    def due(self) -> bool:
        """Whether it is time for the next test."""
        now = self._log.newest
        return now is not None and (
            self._next is None or now >= self._next or now < self._next - self._every
        )

    def look(self) -> BoatChange | None:
        """A new finding, or None; the next test where it is due, which takes longest in a suspicious window."""
        now = self._log.newest
        if now is None or not self.due:
            return None
        if self._next is not None and now < self._next - self._every:  # the clock was set back
            self._log.drop_after(now)
            self._begins.clear()
            self._begin_at(now)
            self._noticed = None if self._noticed is None else now
        while self._begins:
            self._leave_out_until(self._begins.popleft())
        self._next = now + self._every
        self._since = now if self._since is None else self._since
        self._running.advance(self._log, self._since, now)
        if self._noticed is None:
            return self._notice(now, self._since)
        begin = self._noticed + round(NS_PER_S * PASSING)
        end = begin + round(NS_PER_S * CONFIRMATION)
        return self._confirmation(begin, now) if now >= end else None

    def _begin_at(self, stamp: int) -> None:
        """Windows begin after a stamp [ns]."""
        self._since = stamp
        self._running.restart()

    def _leave_out_until(self, stamp: int) -> None:
        """Windows, and the confirmation of a change, begin after a stamp [ns]."""
        if self._since is None or stamp >= self._since:
            self._begin_at(stamp + 1)
        if self._noticed is not None:
            self._noticed = max(self._noticed, stamp)

    def _notice(self, now: int, since: int) -> BoatChange | None:
        """The change in the shortest window that shows one."""
        for length in self._lengths:
            start = now - round(NS_PER_S * length)
            if start < since:
                break
            window = self._running.window(start, FEWEST_POSES)
            found = [] if window is None else self._fitted(window, start, now, self._suspicious)
            if log_ratio(found) > self.threshold:
                self._noticed = now
                return _finding(found, ChangeState.NOTICED, now)
        return None

    def _fitted(
        self, window: RunningWindow, start: int, end: int, least: float = -math.inf
    ) -> list[FittedChange]:
        """All changes, fitted to a window of the stamps [ns].

        Empty where the log ratio of the linear evidences is below `least`, there are too few poses, or the model
        diverges.
        """
        logs = linear_evidences(self._space, window.quadratics)
        if log_ratio(mean_over_noises(self._space, logs)) < least:
            return []
        try:
            recording = self._log.recording(start, end)
        except RecordingError:
            return []
        every = windows(self.model, recording, window.dispersion)
        several = [
            one
            for one, is_probable in zip(every, probable_noises(logs), strict=True)
            if is_probable
        ]
        quadratics = linearised(self._space, several)
        return fitted_changes(self._space, several, quadratics, len(every)) if quadratics else []

    def _confirmation(self, begin: int, now: int) -> BoatChange | None:
        """The change in the window after the notice; None: none can be fitted, the next one is awaited."""
        window = self._running.window(begin, FEWEST_POSES)
        found = [] if window is None else self._fitted(window, begin, now)
        self._begin_at(now)
        self._noticed = None if found else now
        if not found:
            return None
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


def _finding(found: Sequence[FittedChange], state: ChangeState, now: int) -> BoatChange:
    """The most probable change, all causes being equally probable before."""
    each = by_cause(found)
    whole = float(np.logaddexp.reduce([*each.values()]))
    causes = {c: math.exp(log - whole) for c, log in sorted(each.items(), key=lambda e: -e[1])}
    first = next(iter(causes))
    best = next(one for one in found if one.change.cause == first)
    return BoatChange(
        state, now, first, best.change.what, causes[first], best.size, best.error, log_ratio(found), causes,
    )  # fmt: skip
