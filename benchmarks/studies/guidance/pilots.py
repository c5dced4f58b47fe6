# SPDX-License-Identifier: MIT
"""Controllers: poses as they arrive in, commands to both thrusters out."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.studies.guidance.boat import SETTLING, TICK
from benchmarks.studies.tracking.pilots import Differences, Filtered, OnSource, wrapped
from seatrial.control import Course, Reference, TrackingController, Tuning, WaitingReference
from seatrial.util.frames import Array

SMOOTHING = 0.4  # [s] of differenced poses
# [s] of the course about the point passed last, in which the nearest is sought
BACK, AHEAD = 2.0, 4.0
TRACK_STEP = 0.05  # [s]
INTEGRAL = 0.2  # [1/s] of the hand-tuned controllers, times their proportional gain


class Tuned(OnSource):
    """`seatrial.TrackingController` on our odometry."""

    def __init__(self, tuning: Tuning) -> None:
        super().__init__(Filtered(tuning.model))
        self.controller = TrackingController(tuning)

    def wanted(self, t: float, course: Course, eta: Array) -> tuple[Reference, Reference]:
        """The reference at t [s] and as far ahead as the thrusters are late; eta (3,): the boat's pose."""
        del eta
        return course.at(t - SETTLING), course.at(t - SETTLING + self.controller.gains.lead)

    def command(self, t: float, course: Course) -> Array:
        """As the controller has it."""
        eta, nu = self.source.motion(t)
        values = self.controller.command(t, eta, nu, *self.wanted(t, course, eta))
        self.source.commanded(t, values)
        return values


class Waiting(Tuned):
    """The same with a reference that waits for the boat."""

    def __init__(self, tuning: Tuning) -> None:
        super().__init__(tuning)
        self._reference: WaitingReference | None = None

    def wanted(self, t: float, course: Course, eta: Array) -> tuple[Reference, Reference]:
        """As of `Tuned`."""
        guidance = self.controller.gains.guidance
        assert guidance is not None
        if self._reference is None:
            self._reference = WaitingReference(course, guidance.radius)
        now = self._reference.at(t - SETTLING, eta)
        return now, self._reference.later(self.controller.gains.lead)


@dataclass(frozen=True)
class HandGains:
    """In command units."""

    heading: tuple[float, float]  # per rad, rad/s
    speed: float  # per m/s
    ahead: float  # [m] look-ahead distance


class ByHand(OnSource):
    """PID of the heading, PI of the speed, plain line of sight to the nearest point of the course.

    On the newest pose and its filtered difference, as on many boats.
    """

    def __init__(self, gains: HandGains) -> None:
        super().__init__(Differences(SMOOTHING))
        self.gains = gains
        self.sums = np.zeros(2)  # of the heading's and the speed's error
        self.passed = 0.0  # [s] time of the course's point that was nearest

    def command(self, t: float, course: Course) -> Array:
        """The along-track error adds 0.3 of itself a second to the wanted speed."""
        g, wanted = self.gains, course.at(t - SETTLING)
        eta, nu = self.source.motion(t)
        speed = float(np.hypot(*wanted.rate[:2]))
        self.passed, near = nearest(course, self.passed, eta)
        c, s = np.cos(near[2]), np.sin(near[2])
        across = c * (eta[1] - near[1]) - s * (eta[0] - near[0])
        along = c * (wanted.eta[0] - near[0]) + s * (wanted.eta[1] - near[1])
        turn = wrapped(near[2] - np.arctan(across / g.ahead) - eta[2])
        surge = speed + 0.3 * along - nu[0]
        self.sums = np.clip(self.sums + TICK * INTEGRAL * np.array([turn, surge]), -0.5, 0.5)
        yaw = g.heading[0] * (turn + self.sums[0]) - g.heading[1] * nu[2]
        thrust = g.speed * (surge + self.sums[1])
        yaw = float(np.clip(yaw, -1.0, 1.0))
        thrust = float(np.clip(thrust, abs(yaw) - 1.0, 1.0 - abs(yaw)))
        return np.array([thrust - yaw, thrust + yaw])


def nearest(course: Course, passed: float, eta: Array) -> tuple[float, Array]:
    """Time [s] and pose (3,) of the course's nearest point, near the one that was passed last."""
    times = np.clip(np.arange(passed - BACK, passed + AHEAD, TRACK_STEP), 0.0, course.duration)
    poses = track(course)[np.round(times / TRACK_STEP).astype(int)]
    at = int(np.argmin(np.hypot(*(poses[:, :2] - eta[:2]).T)))
    return float(times[at]), np.asarray(poses[at])


@cache
def track(course: Course) -> Array:
    """Poses (n, 3) every `TRACK_STEP`."""
    times = np.arange(0.0, course.duration + 0.1, TRACK_STEP)
    return np.array([course.at(float(t)).eta for t in times])
