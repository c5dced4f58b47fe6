# SPDX-License-Identifier: MIT
"""A course whose reference waits for a boat that falls behind: path following instead of trajectory tracking.

Skjetne, Fossen and Kokotovic (Automatica 40, 2004), the manoeuvring problem: the path is the task, its speed is
given up where the boat cannot keep pace. The time tau along the course runs at d tau / dt = 1 - behind / reach,
within 0 and 1, where `behind` is the distance along the course by which the boat lags.
"""

import numpy as np
from numpy.typing import ArrayLike

from seatrial.control.tracking.courses import Course
from seatrial.control.tracking.reference import Reference
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array

SLOWEST = 1e-3  # [m/s] a reference below it has no course to lag along


class WaitingReference:
    """References along a course for a controller; t [s] counts from the course's start.

    reach: distance [m] behind the reference at which it stands still; `guidance.radius` of the gains suits
    (docs/tune.md). Raises ControlError where it is not positive.
    """

    def __init__(self, course: Course, reach: float) -> None:
        if not (np.isfinite(reach) and reach > 0.0):
            raise ControlError(f"reach {reach:g} m: expected a distance above 0")
        self.course, self.reach = course, reach
        self.time = 0.0  # [s] tau: how far along the course's timetable the reference is
        self.pace = 1.0  # [-] d tau / dt
        self._last = 0.0  # [s] of the last call

    @property
    def ended(self) -> bool:
        """Whether the reference is at the course's end."""
        return self.time >= self.course.duration

    def at(self, t: float, eta: ArrayLike) -> Reference:
        """The reference at t [s] for a boat at the pose eta (3,). Call it with rising t."""
        self.time += self.pace * max(0.0, t - self._last)
        self._last = max(0.0, t)
        self.pace = self._pace(self.course.at(self.time), np.asarray(eta, dtype=float))
        return self.later(0.0)

    def later(self, lead: float) -> Reference:
        """The reference `lead` [s] after that of the last `at`, for a boat that lags no more and no less.

        The change of the pace itself is left out of the acceleration.
        """
        one = self.course.at(self.time + self.pace * lead)
        return Reference(one.eta, self.pace * one.rate, self.pace**2 * one.acceleration)

    def _pace(self, now: Reference, eta: Array) -> float:
        velocity = now.rate[:2]
        speed = float(np.hypot(*velocity))
        if speed < SLOWEST:
            return 1.0
        behind = float(velocity @ (now.eta[:2] - eta[:2])) / speed
        return float(np.clip(1.0 - behind / self.reach, 0.0, 1.0))
