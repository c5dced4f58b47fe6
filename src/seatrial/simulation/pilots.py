# SPDX-License-Identifier: MIT
"""Simulated operators: a person with a joypad and a boat in a small pool."""

from abc import ABC, abstractmethod

import numpy as np

from seatrial import _core
from seatrial.simulation.plan import OperatorEntry, Pool
from seatrial.util.frames import AXES, Array

BRAKING = 0.12  # [m/s^2] deceleration by full reverse that the operator expects
LOOK_AHEAD = 0.5  # [s]
CUSHION = 0.10  # [m] in addition to the margin
SMALLEST_AREA = 0.05  # [m] half-size of the area in which the boat may stop, at least
OFF_COURSE_HEADING = 0.5  # [rad] above it a pulse is corrected, too
HEADING_DEADBAND = 0.15  # [rad] a smaller error is not corrected
POSITION_DEADBAND = 0.2  # [m] a smaller offset is not corrected
TURN_BACK = 0.4  # of the free half-length: beyond it a pulse is towards the middle


class Operator(ABC):
    """Observes the boat at intervals and moves the sticks."""

    def __init__(self, entry: OperatorEntry, pool: Pool, rng: np.random.Generator) -> None:
        self.entry, self.rng = entry, rng
        half = np.array([pool.length, pool.width]) / 2 - pool.margin
        # [m] half-size of the area in which the boat may stop
        self.safe = np.maximum(half - CUSHION, SMALLEST_AREA)

    @abstractmethod
    def drive(self, t: float, x: Array) -> Array:
        """Stick positions F (3,) in -1..1 for the state x = [x, y, psi, u, v, r] at t [s]."""

    def start_heading(self) -> float:
        """Heading [rad] at the trial's start."""
        return 0.0

    def look(self, t: float, x: Array) -> Array:
        """The sticks; away from a wall if the boat is too fast for it."""
        guard = self._guard(x)
        return _limited(self.drive(t, x) if guard is None else guard)

    def _guard(self, x: Array) -> Array | None:
        """Full stick away from a wall that is within the stopping distance."""
        velocity = _earth(x[2], x[3:5])
        stop = x[:2] + velocity * LOOK_AHEAD + velocity * np.abs(velocity) / (2 * BRAKING)
        outside = (np.abs(stop) > self.safe) & (stop * velocity >= 0)
        if not (outside[0] or outside[1]):
            return None
        away = np.where(outside, -np.sign(stop), 0.0)
        sticks = _body(x[2], away)
        return np.array([sticks[0], sticks[1], -1.0 * x[5]]) / max(1.0, float(np.abs(sticks).max()))


class PulseOperator(Operator):
    """Pulses of random size and length in one axis; the others only for station keeping."""

    def __init__(
        self, axis: int, entry: OperatorEntry, pool: Pool, rng: np.random.Generator
    ) -> None:
        super().__init__(entry, pool, rng)
        self.axis = axis
        self.until = 0.0  # [s] end of the present pulse or pause
        self.pulsing = False
        self.sticks = np.zeros(3)

    def start_heading(self) -> float:
        """Sway pulses are along the pool's length, too."""
        return np.pi / 2 if self.axis == 1 else 0.0

    def drive(self, t: float, x: Array) -> Array:
        """The current pulse, or a correction in the pauses."""
        if t >= self.until:
            self._next(t, x)
        sticks = self.sticks.copy() if self.pulsing else np.zeros(3)
        off_course = abs(_wrapped(x[2] - self.start_heading())) > OFF_COURSE_HEADING
        if not self.pulsing or (off_course and self.axis != 2):
            sticks += self._correction(x)
        return sticks

    def _next(self, t: float, x: Array) -> None:
        self.pulsing = not self.pulsing
        low, high = self.entry.pulse if self.pulsing else self.entry.pause
        self.until = t + self.rng.uniform(low, high)
        size = self.rng.uniform(*self.entry.amplitude[AXES[self.axis]])  # type: ignore[index]
        side = self.rng.choice([-1.0, 1.0])
        if self.axis < 2:
            along = float(_body(x[2], x[:2])[self.axis])
            if abs(along) > TURN_BACK * self.safe[0]:
                side = -np.sign(along)
        self.sticks = self.rng.normal(0.0, self.entry.crosstalk * size, 3)
        self.sticks[self.axis] = side * size

    def _correction(self, x: Array) -> Array:
        """Back to the line of the pulses, if the boat is off it."""
        sticks = np.zeros(3)
        if self.axis != 2:
            off = _wrapped(x[2] - self.start_heading())
            if abs(off) > HEADING_DEADBAND:
                sticks[2] = min(max(-1.0 * off - 0.8 * x[5], -0.5), 0.5)
        place, speed = _body(x[2], x[:2]), x[3:5]
        for axis in {0, 1} - {self.axis}:
            if abs(place[axis]) > POSITION_DEADBAND:
                sticks[axis] = min(max(-1.2 * place[axis] - 2.0 * speed[axis], -0.6), 0.6)
        return sticks


class CourseOperator(Operator):
    """Follows figures of eight, circles and squares in turn, with changes of heading."""

    def __init__(self, entry: OperatorEntry, pool: Pool, rng: np.random.Generator) -> None:
        super().__init__(entry, pool, rng)
        self.size = self.safe * 0.75  # [m]
        self.started = 0.0
        self._choose(0)

    def drive(self, t: float, x: Array) -> Array:
        """Sticks towards a point that moves along the course, in steps of 0.1."""
        phase = (t - self.started) / self.lap
        if phase >= 2.0:
            self.started, phase = t, 0.0
            self._choose((self.kind + 1) % 3)
        target, direction = self._point(phase), self._point(phase + 0.02) - self._point(phase)
        place = _body(x[2], target - x[:2])
        heading = (
            np.arctan2(direction[1], direction[0]) if self.along else 0.8 * np.sin(12.0 * phase)
        )
        turn = _wrapped(heading - x[2])
        yaw = min(max(1.5 * turn, -0.9), 0.9) - 0.5 * x[5]
        sticks = np.array([*(2.5 * place - 2.0 * x[3:5]), yaw])
        return np.asarray(np.round(_limited(sticks) / 0.1) * 0.1)

    def _choose(self, kind: int) -> None:
        self.kind = kind
        self.lap = self.rng.uniform(18.0, 30.0)  # [s]
        self.turn = self.rng.choice([-1.0, 1.0])
        self.along = bool(self.rng.random() < 0.5)  # bow along the course, or heading swings

    def _point(self, phase: float) -> Array:
        angle = 2 * np.pi * phase * self.turn
        if self.kind == 0:  # figure of eight
            return np.asarray(self.size * [np.sin(angle), np.sin(2 * angle)])
        radius = float(self.size.min())
        if self.kind == 1:  # circle
            return np.array([radius * np.cos(angle), radius * np.sin(angle)])
        side = np.array([np.cos(angle), np.sin(angle)])  # square
        return np.asarray(radius * side / float(np.abs(side).max()))


def make_operator(
    drive: str, entry: OperatorEntry, pool: Pool, rng: np.random.Generator
) -> Operator:
    """The operator for a trial."""
    if drive == "courses":
        return CourseOperator(entry, pool, rng)
    return PulseOperator(AXES.index(drive), entry, pool, rng)


def _limited(sticks: Array) -> Array:
    """Within -1..1, faster than np.clip for three numbers."""
    return np.minimum(np.maximum(sticks, -1.0), 1.0)


def _earth(psi: float, body: Array) -> Array:
    """A body-fixed vector (2,) in earth axes."""
    return _core.rotate(np.array([psi]), np.array([[body[0], body[1], 0.0]]), False)[0, :2]


def _body(psi: float, earth: Array) -> Array:
    """An earth-fixed vector (2,) in body axes."""
    return _core.rotate(np.array([psi]), np.array([[earth[0], earth[1], 0.0]]), True)[0, :2]


def _wrapped(angle: float) -> float:
    return float(_core.wrap(np.array([angle]))[0])
