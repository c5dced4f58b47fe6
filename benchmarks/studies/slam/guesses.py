# SPDX-License-Identifier: MIT
"""Where a SLAM may think the boat is before it has matched a scan: motion since the last match."""

from abc import ABC, abstractmethod

import numpy as np

import seatrial
from benchmarks.studies.slam.drives import Drive
from benchmarks.studies.slam.lidar import Poses
from benchmarks.studies.slam.se2 import between, compose, exponential, logarithm
from seatrial.util.frames import Array

HOLD = 1.0  # [s] at most, that a velocity is taken to stay
WINDOW = 2.0  # [s] that a pose may be late
KNOTS = 9  # times at which the predictor is asked over a scan; between, straight lines


class Guess(ABC):
    """Told of every accepted match; says where the boat is at times since the last one."""

    def __init__(self, t: float, pose: Array) -> None:
        self.t, self.pose = t, pose

    @abstractmethod
    def since(self, t: Array) -> Array:
        """Motion (n, 3) from the last accepted match to times t (n,) [s]."""

    def poses(self, t: Array) -> Array:
        """Poses (n, 3) at times (n,) [s]."""
        return compose(self.pose, self.since(t))

    def hear(self, now: float) -> None:  # noqa: B027 - most need no commands
        """All commands that were sent up to `now` [s]."""

    def accepted(self, t: float, pose: Array) -> None:
        """A match that the SLAM took, of time t [s]."""
        self.t, self.pose = t, pose


class ConstantPose(Guess):
    """The boat is where it was."""

    def since(self, t: Array) -> Array:
        """None."""
        return np.zeros((len(t), 3))


class ConstantVelocity(Guess):
    """The boat moves on as between the last two accepted matches, along an arc."""

    def __init__(self, t: float, pose: Array) -> None:
        super().__init__(t, pose)
        self.velocity = np.zeros(3)

    def since(self, t: Array) -> Array:
        """At the velocity of the last two matches, for a while."""
        return exponential(np.minimum(t - self.t, HOLD)[:, None] * self.velocity)

    def accepted(self, t: float, pose: Array) -> None:
        """With the velocity that leads there from the one before."""
        self.velocity = logarithm(between(self.pose, pose)) / (t - self.t)
        super().accepted(t, pose)


class ModelOdometry(Guess):
    """The predictor, driven by the commands and corrected by the SLAM's own accepted matches."""

    def __init__(self, t: float, pose: Array, model: seatrial.Model, driven: Drive) -> None:
        super().__init__(t, pose)
        self.predictor = seatrial.Predictor(model, window=WINDOW)
        self.drive, self.heard = driven, 0
        self.accepted(t, pose)

    def since(self, t: Array) -> Array:
        """By the predictor's poses at both times."""
        knots = t if len(t) <= KNOTS else np.linspace(t[0], t[-1], KNOTS)
        found = np.array([self.predictor.at(time).pose for time in knots.tolist()])
        found[:, 2] = np.unwrap(found[:, 2])
        at = np.column_stack([np.interp(t, knots, found[:, i]) for i in range(3)])
        return between(self.reference, at)

    def hear(self, now: float) -> None:
        """Stamped by the joypad's clock, as the model expects them."""
        drive = self.drive
        while self.heard < len(drive.command) and drive.command_sent[self.heard] <= now:
            self.predictor.command(drive.command_t[self.heard], drive.command[self.heard])
            self.heard += 1

    def accepted(self, t: float, pose: Array) -> None:
        """Odometry begins anew at what the predictor makes of it."""
        super().accepted(t, pose)
        self.predictor.pose(t, pose)
        self.reference = self.predictor.at(t).pose


class TrueMotion(Guess):
    """Perfect odometry: the bound for any."""

    def __init__(self, t: float, pose: Array, truth: Poses) -> None:
        super().__init__(t, pose)
        self.truth = truth

    def since(self, t: Array) -> Array:
        """By the truth at both times."""
        return between(self.truth(np.array([self.t])), self.truth(t))
