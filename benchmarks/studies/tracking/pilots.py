# SPDX-License-Identifier: MIT
"""Controllers: poses as they arrive in, commands out.

The PD by hand is what is on many boats: commands from the newest pose and its filtered difference. It
may instead be given our odometry, to separate its effect from that of the gains.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from seatrial import Odometer
from seatrial.boat.model import Model
from seatrial.control import Course, Reference, TrackingController, Tuning
from seatrial.util.frames import Array, body_velocity

SMOOTHING = 0.2  # [s] of differenced poses
NS = 1_000_000_000


@dataclass(frozen=True)
class HandGains:
    """In command units per m, m/s; rad, rad/s."""

    plane: tuple[float, float]
    turn: tuple[float, float]


def wrapped(angle: float) -> float:
    """In (-pi, pi]."""
    return float(np.angle(np.exp(1j * angle)))


class Source(ABC):
    """What tells pose and velocity."""

    @abstractmethod
    def pose(self, stamp: float, eta: Array) -> None:
        """A pose of time stamp [s] arrives."""

    @abstractmethod
    def motion(self, t: float) -> tuple[Array, Array]:
        """Pose and body velocity, as known at t [s]."""

    def commanded(self, t: float, values: Array) -> None:  # noqa: B027 - some need no commands
        """A command that was sent."""


class Pilot(ABC):
    """Steers one run."""

    @abstractmethod
    def pose(self, stamp: float, eta: Array) -> None:
        """A pose of time stamp [s] arrives."""

    @abstractmethod
    def command(self, t: float, course: Course) -> Array:
        """At t [s]."""


class OnSource(Pilot):
    """A pilot whose motion is a source's."""

    def __init__(self, source: Source) -> None:
        self.source = source

    def pose(self, stamp: float, eta: Array) -> None:
        """To the source."""
        self.source.pose(stamp, eta)


class Differences(Source):
    """Velocity over ground of differenced poses, smoothed over a time [s]."""

    def __init__(self, smoothing: float = SMOOTHING) -> None:
        self.smoothing = smoothing
        self.stamp, self.eta, self.rate = -np.inf, np.zeros(3), np.zeros(3)

    def pose(self, stamp: float, eta: Array) -> None:
        """One more."""
        dt = stamp - self.stamp
        if np.isfinite(dt) and dt > 0.0:
            step = eta - self.eta
            step[2] = wrapped(step[2])
            self.rate = self.rate + (step / dt - self.rate) * -np.expm1(-dt / self.smoothing)
        self.stamp, self.eta = stamp, eta

    def motion(self, t: float) -> tuple[Array, Array]:
        """Pose and body velocity, as they were at the newest pose."""
        del t
        return self.eta, body_velocity(self.eta[2:], self.rate[None])[0]


class Filtered(Source):
    """Our odometry: `seatrial.Odometer`, which gets every command."""

    def __init__(self, model: Model) -> None:
        self.odometer = Odometer(model)

    def pose(self, stamp: float, eta: Array) -> None:
        """One more."""
        self.odometer.pose(round(stamp * NS), eta)

    def motion(self, t: float) -> tuple[Array, Array]:
        """Pose and body velocity at t [s]."""
        found = self.odometer.look(round(t * NS))
        return found.pose, found.velocity

    def commanded(self, t: float, values: Array) -> None:
        """A command that was sent."""
        self.odometer.command(round(t * NS), values)


class ByHand(OnSource):
    """A PD in body axes; the command's direction is kept where an input is full."""

    def __init__(self, gains: HandGains, source: Source) -> None:
        super().__init__(source)
        self.p = np.array([gains.plane[0], gains.plane[0], gains.turn[0]])
        self.d = np.array([gains.plane[1], gains.plane[1], gains.turn[1]])

    def command(self, t: float, course: Course) -> Array:
        """P of the pose error, D of the velocity error."""
        eta, nu = self.source.motion(t)
        wanted = course.at(t)
        off = wanted.eta - eta
        off[2] = wrapped(off[2])
        error, rate = body_velocity(np.array([eta[2]] * 2), np.vstack([off, wanted.rate]))
        values = self.p * error + self.d * (rate - nu)
        values = np.asarray(values / max(1.0, np.abs(values).max()))
        self.source.commanded(t, values)
        return values


class Tuned(OnSource):
    """`seatrial.TrackingController` on our odometry."""

    def __init__(self, tuning: Tuning, *, feed_forward: bool = True) -> None:
        super().__init__(Filtered(tuning.model))
        self.controller = TrackingController(tuning, feed_forward=feed_forward)
        self.lead = self.controller.gains.lead

    def command(self, t: float, course: Course) -> Array:
        """As the controller has it."""
        eta, nu = self.source.motion(t)
        ahead: Reference = course.at(t + self.lead)
        values = self.controller.command(t, eta, nu, course.at(t), ahead)
        self.source.commanded(t, values)
        return values
