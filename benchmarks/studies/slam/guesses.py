# SPDX-License-Identifier: MIT
"""Initial guesses of a scan matcher: motion since the last match."""

from abc import ABC, abstractmethod

import numpy as np

import seatrial
from benchmarks.studies.slam.drives import Drive
from benchmarks.studies.slam.lidar import Poses
from benchmarks.studies.slam.se2 import between, compose, exponential, logarithm
from seatrial.util.frames import Array

HOLD = 1.0  # [s] at most, that a velocity is taken to stay
WINDOW = 2.0  # [s] that a pose may be late
KNOTS = 9  # predictions over a scan; linear between them


class Guess(ABC):
    """A prediction of the pose since the last accepted match."""

    def __init__(self, t: float, pose: Array) -> None:
        self.t, self.pose = t, pose

    @abstractmethod
    def since(self, t: Array) -> Array:
        """Motion (n, 3) from the last accepted match to times t (n,) [s]."""

    def poses(self, t: Array) -> Array:
        """Poses (n, 3) at times (n,) [s]."""
        return compose(self.pose, self.since(t))

    def commands_until(self, now: float) -> None:  # noqa: B027 - most need no commands
        """Take all commands that were sent up to `now` [s]."""

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
        self.drive, self.taken = driven, 0
        self.accepted(t, pose)

    def since(self, t: Array) -> Array:
        """By the predictor's poses at both times."""
        knots = t if len(t) <= KNOTS else np.linspace(t[0], t[-1], KNOTS)
        found = np.array([self.predictor.at(time).pose for time in knots.tolist()])
        found[:, 2] = np.unwrap(found[:, 2])
        at = np.column_stack([np.interp(t, knots, found[:, i]) for i in range(3)])
        return between(self.reference, at)

    def commands_until(self, now: float) -> None:
        """Stamped by the joypad's clock, as the model expects them."""
        drive = self.drive
        while self.taken < len(drive.command) and drive.command_sent[self.taken] <= now:
            self.predictor.command(drive.command_t[self.taken], drive.command[self.taken])
            self.taken += 1

    def accepted(self, t: float, pose: Array) -> None:
        """Odometry restarts at the predictor's corrected pose."""
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
