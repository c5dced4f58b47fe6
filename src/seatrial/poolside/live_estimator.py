# SPDX-License-Identifier: MIT
"""The model's estimate while the boat drives.

Three kinds of work, from cheap to thorough. Searches are due when the drive has grown by a share of itself, so
that the cost per pose is bounded:

- the filter's run goes on along the new poses, at the parameters of the last search; a Gauss-Newton step from its
  gradient and information is the estimate;
- a warm search over the drive so far begins at the estimate, and keeps its noise structure;
- a thorough search is that of `identify`: noise structure, fit horizon, actuator stages.

Of a drive longer than `MOST_SEARCHED` poses the older half is condensed: its information becomes the prior of
further searches. So memory and time of a search are bounded, too.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.estimator import fit
from seatrial.identification.first_search import maximised
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.problem_setup import problem_with
from seatrial.identification.recording_checks import check_recordings
from seatrial.identification.selection.actuator_stages import with_estimated_stages
from seatrial.identification.selection.terms.candidates import with_usual_terms
from seatrial.identification.solution import Fit, OutputErrorSettings, StartValues
from seatrial.identification.uncertainty.covariance import (
    SHORTEST_BLOCK,
    sandwich_covariance,
    with_enough_blocks,
)
from seatrial.poolside.drive_log import DriveLog
from seatrial.poolside.live_solution import Solution, scatter_ratio, solution_of, stepped, warm
from seatrial.recording.excitation import find_roles
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError, RecordingError, SeatrialError
from seatrial.util.frames import Array

FIRST_LENGTH = 15.0  # [s] of a drive before the first search
WARM_GROWTH = 1.25  # of the drive, from one search to the next
THOROUGH_GROWTH = 1.5  # of the drive, from one thorough search to the next
LEAST_GROWTH = 4.0  # [s] of the drive, between two searches
MOST_THOROUGH = 60_000  # poses: of a longer drive the structure is known
STEP = 500_000_000  # [ns] of new poses that the filter goes on along at once
HOLD = 300_000_000  # [ns] in which rows may arrive late
CONTEXT = 100  # rows before the new poses, which show their faults
INDEFINITE = -1e-9  # least eigenvalue of correlations: below, the covariance is none
NO_MAXIMUM = (
    "the search over the whole drive found no maximum: did the boat change? The estimate goes on from the last "
    "one. Begin a new session after a change of the boat"
)


class LiveEstimator:
    """The estimate of a drive that goes on; `use` and `model` from any thread, `work` from one.

    vehicle: as of `seatrial.load_vehicle`; with `structure: auto` its terms are those that every boat has, with
    free added mass (`choose_terms` chooses after the drive).
    start: the model until the drive has one of its own, and where the first search begins; effects: as those of
    `seatrial.identify`.

        estimator = LiveEstimator(vehicle)
        estimator.use("command", stamp, values)    # [ns], (inputs,)
        estimator.use("pose", stamp, (x, y, psi))  # of the measured point, forward-left-up
        changed = estimator.work()                 # in a thread of its own, a few times a second
        model = estimator.model()                  # None: see estimator.problem

    The estimate is that of `seatrial.identify(recording, vehicle, effects=effects)` on
    `estimator.log.recording()`, within a tenth of a standard error. Noise structure, fit horizon, actuator stages
    and findings are those of the last thorough search; effects (lever arm, current, trim, wind) of the last one.
    Standard errors of a drive too short for the scatter of its innovations assume these to be white.
    """

    def __init__(
        self, vehicle: Vehicle, *, start: Model | None = None, effects: Sequence[str] = ()
    ) -> None:
        self.vehicle = with_usual_terms(vehicle) if vehicle.automatic else vehicle
        self.log = DriveLog(self.vehicle)
        self._settings = OutputErrorSettings(effects=tuple(effects))
        self._start = start
        self._model = start
        self._solution: Solution | None = None
        self._problem = _waiting(0.0)
        self._searched = 0.0  # [s] of the drive at the last search
        self._anew = False  # whether the next search begins from nothing

    def use(self, kind: str, stamp: int, values: Sequence[float] | Array) -> bool:
        """A row of the drive, as of `DriveLog.add`: microseconds. False where it is not finite."""
        return self.log.add(kind, stamp, values)

    def discard(self, start: int, end: int) -> None:
        """Leave out the poses of an interval [ns]; the next `work` searches anew without them.

        What is condensed stays.
        """
        self.log.discard(start, end)
        self._anew, self._searched = True, 0.0

    def model(self) -> Model | None:
        """The current estimate with its covariance; None: there is none yet, and `problem` says why."""
        return self._model

    @property
    def problem(self) -> str:
        """What hinders an estimate, and what to do; empty: nothing."""
        return " ".join(text for text in (self._problem, self.log.message) if text)

    @property
    def whole(self) -> bool:
        """Whether the drive is long enough for `identify`; before, standard errors assume white innovations."""
        return self._solution is not None and self._solution.thorough > 0.0

    @property
    def trust(self) -> float:
        """Information that the drive turned out to have, over what the noise promised; at most 1."""
        found = self._solution
        if found is None:
            return 1.0
        return 1.0 / max(1.0, scatter_ratio(found.fit.covariance, found.information))

    @property
    def lag(self) -> float:
        """Seconds of the drive that the estimate has not used."""
        newest, found = self.log.newest, self._solution
        if newest is None or found is None:
            return 0.0
        since = self.log.length - self._searched  # a clock that is set is no lag
        return max(0.0, min(1e-9 * (newest - found.going.newest), since))

    def work(self, *, ended: bool = False) -> bool:
        """Do what is due, and return whether the estimate changed: milliseconds, or seconds of a search.

        ended: no more rows come. So none is waited for, and the last search is over the whole drive.
        """
        length = self.log.length
        if length < FIRST_LENGTH:
            self._problem = _waiting(length)
            return False
        hold = 0 if ended else HOLD
        due = max(WARM_GROWTH * self._searched, self._searched + LEAST_GROWTH)
        if length >= due or (ended and length > self._searched):
            self._searched = length
            if self._search(length, hold):
                return True
        return self._solution is not None and self._go_on(self._solution, hold)

    def _search(self, length: float, hold: int) -> bool:
        anew, self._anew = self._anew, False
        last = self._solution
        try:
            recording = self.log.recording(None if last is None else last.first)
            few = len(recording.t) < MOST_THOROUGH
            found, thorough = self._found(recording, length, None if anew and few else last)
            self._solution = solution_of(found, thorough, hold)
        except SeatrialError as error:
            self._problem = str(error)
            return False
        self._problem = ""
        return self._state(stepped(self._solution, self._solution.going.at()))

    def _state(self, found: Model) -> bool:
        """Make it the estimate; not where rounding leaves its covariance indefinite, as of a few poses."""
        variance = np.diag(found.covariance)
        if variance.min(initial=0.0) < 0.0:
            return False
        size = np.sqrt(variance)
        own = size > 0.0
        inside = found.covariance[np.ix_(own, own)] / np.outer(size[own], size[own])
        if (
            not np.isfinite(inside).all()
            or np.linalg.eigvalsh(inside).min(initial=0.0) < INDEFINITE
        ):
            return False
        self._model = found
        return True

    def _found(
        self, recording: Recording, length: float, last: Solution | None
    ) -> tuple[Fit, float]:
        """What is due of a warm and a thorough search, and the length [s] of the drive at the last thorough one.

        Raises SeatrialError where there is no solution.
        """
        many = len(recording.t) >= MOST_THOROUGH
        if last is not None and (many or length < THOROUGH_GROWTH * last.thorough):
            found = warm(last.fit, recording)
            if found is not None:
                return found, last.thorough
            if many:
                raise IdentificationError(NO_MAXIMUM)
        check_recordings([recording], self.vehicle)
        find_roles(self.vehicle, [recording])
        begin = self._begin(last)
        short = self._short_problem(recording)
        if short is not None:
            return self._early(short, begin), 0.0
        return fit([recording], self.vehicle, settings=self._settings, begin=begin), length

    def _short_problem(self, recording: Recording) -> Problem | None:
        """The problem of a recording with fewer blocks than parameters, which `identify` refuses; else None."""
        whole, _ = with_estimated_stages(self.vehicle, [recording])
        problem = problem_with(whole, self.vehicle, [recording], self._settings)
        try:
            with_enough_blocks(problem)
        except IdentificationError:
            return replace(problem, block=SHORTEST_BLOCK)
        return None

    def _early(self, problem: Problem, begin: StartValues | None) -> Fit:
        """The maximum of the likelihood, with standard errors for white innovations."""
        at = maximised(problem, problem.recordings, begin, hold=False)
        return Fit.of(at, sandwich_covariance(at), self._settings)

    def _begin(self, last: Solution | None) -> StartValues | None:
        """Where a thorough search begins."""
        if last is None:
            return None if self._start is None else StartValues.of_model(self._start)
        values = dict(zip(last.fit.problem.names, last.fit.theta.tolist(), strict=True))
        return StartValues(values, last.fit.noise)

    def _go_on(self, last: Solution, hold: int) -> bool:
        """The estimate with the poses since, up to `hold` [ns] before the newest: a linearised step."""
        span = self.log.span
        until = 0 if span is None else span[1] - hold
        before = last.going.newest
        if until - before < (STEP if hold else 1):
            return False
        try:
            part = self.log.recording(self.log.before(before, CONTEXT))
            last.going.advance(part, until)
        except (RecordingError, ValueError):
            return False  # no usable pose near: the next search covers it
        at = last.going.at()
        if last.going.newest == before or not np.isfinite(at.runs.cost):
            return False
        return self._state(stepped(last, at))


def _waiting(length: float) -> str:
    return (
        f"{length:.0f} s of poses so far: the first estimate needs {FIRST_LENGTH:.0f} s or more. "
        "Drive pulses of every axis, in both directions"
    )
