# SPDX-License-Identifier: MIT
"""The model's estimate while the boat drives.

Three kinds of work, from cheap to thorough, each due when the drive has grown by a share of itself, so that the
cost per pose is bounded:

- a thorough search, as `identify` does it: noise structure, fit horizon, actuator stages;
- a warm search over the whole drive from the estimate so far, in that structure;
- the filter's run continued by the new poses at the last search's parameters, and a linearised Gauss-Newton step.
"""

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace

from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import present
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.estimator import fit
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.optimiser import Outcome, far_from_poses, search
from seatrial.identification.recording_checks import check_recordings
from seatrial.identification.solution import Fit, OutputErrorSettings, StartValues
from seatrial.identification.uncertainty.covariance import (
    sandwich_covariance,
    with_enough_blocks,
)
from seatrial.identification.uncertainty.dead_zone import with_dead_zone_profile
from seatrial.identification.uncertainty.lag import with_lag_by_square
from seatrial.poolside.drive_log import DriveLog
from seatrial.recording.excitation import find_roles
from seatrial.recording.recording import Recording
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Array

FIRST_LENGTH = 15.0  # [s] of a drive before the first search
RETRY_GROWTH = 1.2  # of the drive, after a search that found no solution
WARM_GROWTH = 1.12  # of the drive, from one warm search to the next
THOROUGH_GROWTH = 1.5  # of the drive, from one thorough search to the next
LEAST_GROWTH = 4.0  # [s] of the drive, between two searches
MOST_THOROUGH = 60_000  # poses: of a longer drive the structure is known
WARM_PASSES = 12  # full ones of a warm search, at most


@dataclass(frozen=True)
class Solution:
    """The last search: its fit and its model."""

    fit: Fit
    model: Model
    until: int  # [ns] stamp of the newest pose that it used


class LiveEstimator:
    """The estimate of a drive that goes on; `use` and `model` from any thread, `work` from one.

    vehicle: with the terms of its structure, as `seatrial.load_vehicle` gives it; start: the model until the drive
    has one of its own, and where the first search begins; effects: as those of `seatrial.identify`.

        estimator = LiveEstimator(vehicle)
        estimator.use("command", stamp, values)   # [ns], (inputs,)
        estimator.use("pose", stamp, (x, y, psi))  # of the measured point, forward-left-up
        while estimator.work():                   # in a thread of its own
            model = estimator.model()             # None: see estimator.problem
    """

    def __init__(
        self, vehicle: Vehicle, *, start: Model | None = None, effects: Sequence[str] = ()
    ) -> None:
        self.vehicle = vehicle
        self.log = DriveLog(vehicle)
        self._settings = OutputErrorSettings(effects=tuple(effects))
        self._start = start
        self._model = start
        self._solution: Solution | None = None
        self._problem = ""
        self._thorough_length = self._length = 0.0  # [s] of the drive at the last searches
        self._lock = threading.Lock()

    def use(self, kind: str, stamp: int, values: Sequence[float] | Array) -> bool:
        """A row of the drive, as of `DriveLog.add`: microseconds. Whether it is finite."""
        return self.log.add(kind, stamp, values)

    def discard(self, start: int, end: int) -> None:
        """Leave out the poses of an interval [ns]; the next `work` estimates without them."""
        self.log.discard(start, end)
        self._length = 0.0

    def model(self) -> Model | None:
        """The current estimate with its covariance; None: there is none yet, and `problem` says why."""
        return self._model

    @property
    def problem(self) -> str:
        """What hinders an estimate, and what to do; empty: nothing."""
        return " ".join(text for text in (self._problem, self.log.message) if text)

    @property
    def lag(self) -> float:
        """Seconds of the drive that the estimate has not used."""
        span, found = self.log.span, self._solution
        return 0.0 if span is None or found is None else 1e-9 * (span[1] - found.until)

    def work(self) -> bool:
        """Do what is due, and return whether the estimate changed: milliseconds, or seconds of a search."""
        span = self.log.span
        length = 0.0 if span is None else 1e-9 * (span[1] - span[0])
        if length < FIRST_LENGTH:
            self._problem = self._problem or _waiting(length)
            return False
        growth = WARM_GROWTH if self._solution else RETRY_GROWTH
        if length < max(growth * self._length, self._length + LEAST_GROWTH):
            return False
        self._length = length
        return self._search(length)

    def _search(self, length: float) -> bool:
        try:
            recording = self.log.recording()
            found = self._warm(recording, length) or self._thorough(recording, length)
        except SeatrialError as error:
            self._problem = str(error)
            return False
        self._solution, self._model, self._problem = found, found.model, ""
        return True

    def _thorough(self, recording: Recording, length: float) -> Solution:
        """The search of `identify`. Raises SeatrialError where it refuses the drive."""
        check_recordings([recording])
        find_roles(self.vehicle, [recording])
        begin = None if self._solution is None else _values(self._solution.fit)
        if begin is None and self._start is not None:
            begin = StartValues.of_model(self._start)
        found = fit([recording], self.vehicle, settings=self._settings, begin=begin)
        self._thorough_length = length
        return _solution(found)

    def _warm(self, recording: Recording, length: float) -> Solution | None:
        """The search from the last estimate in its structure; None where a thorough one is due."""
        if self._solution is None or (
            length > THOROUGH_GROWTH * self._thorough_length and len(recording.t) < MOST_THOROUGH
        ):
            return None
        last = self._solution.fit
        block = self._settings.block
        problem = with_enough_blocks(replace(last.problem, recordings=(recording,), block=block))
        at, outcome = search(
            problem, last.theta, last.noise, least=noise_floor(problem, last.horizon),
            free=present(last.noise), passes=WARM_PASSES,
        )  # fmt: skip
        if outcome not in (Outcome.CONVERGED, Outcome.OUT_OF_STEPS) or far_from_poses(at):
            return None
        covariance = with_lag_by_square(at, with_dead_zone_profile(at, sandwich_covariance(at)))
        at.runs.drop_linearisation()
        return _solution(
            replace(
                last,
                problem=problem,
                theta=at.theta,
                noise=at.noise,
                runs=at.runs,
                covariance=covariance,
            )
        )


def _waiting(length: float) -> str:
    return (
        f"{length:.0f} s of poses so far: the first estimate needs {FIRST_LENGTH:.0f} s or more. "
        "Drive pulses of every axis, in both directions"
    )


def _values(found: Fit) -> StartValues:
    """Where a further search begins."""
    names = found.problem.names
    return StartValues(dict(zip(names, found.theta.tolist(), strict=True)), found.noise)


def _solution(found: Fit) -> Solution:
    recording = found.problem.recordings[0]
    return Solution(found, found.model(), int(recording.stamps[-1]))
