# SPDX-License-Identifier: MIT
"""Simulated operators: a person with a joypad and a boat in a pool or on a lake.

A boat without thrust in sway turns back to the middle where one with it brakes sideways, too.
"""

from abc import ABC, abstractmethod

import numpy as np

from seatrial import _core
from seatrial.simulation.plan import OperatorEntry, Pool
from seatrial.util.frames import AXES, Array, Mask

CUSHION = 0.10  # [m] in addition to the margin
SMALLEST_AREA = 0.05  # [m] half-size of the area in which the boat may stop, at least
OFF_COURSE_HEADING = 0.5  # [rad] above it a pulse is corrected, too
HEADING_DEADBAND = 0.15  # [rad] a smaller error is not corrected
POSITION_DEADBAND = 0.2  # [m] a smaller offset is not corrected
TURN_BACK = 0.4  # of the free half-length: beyond it a pulse is towards the middle
HOME = 0.5  # of the free half-size: there a boat without thrust in sway has come back
WAY_BACK = (0.25, 0.6)  # surge stick on its way: across it, and along it


class Operator(ABC):
    """Observes the boat at intervals and moves the sticks."""

    def __init__(
        self, entry: OperatorEntry, pool: Pool, rng: np.random.Generator, *, sway: bool = True
    ) -> None:
        self.entry, self.rng, self.sway = entry, rng, sway
        self.returning = False  # a boat without thrust in sway, from too near a wall
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
        guard = self._guard(x) if self.sway else self._way_back(x)
        return _limited(self.drive(t, x) if guard is None else guard)

    def _beyond(self, x: Array) -> tuple[Array, Mask]:
        """Where the boat can stop (2,) [m], and along which sides of the pool that is outside."""
        velocity, own = _earth(x[2], x[3:5]), self.entry
        stop = x[:2] + velocity * own.look_ahead + velocity * np.abs(velocity) / (2 * own.braking)
        return stop, (np.abs(stop) > self.safe) & (stop * velocity >= 0)

    def _guard(self, x: Array) -> Array | None:
        """Full stick away from a wall that is within the stopping distance."""
        stop, outside = self._beyond(x)
        if not (outside[0] or outside[1]):
            return None
        away = np.where(outside, -np.sign(stop), 0.0)
        sticks = _body(x[2], away)
        return np.array([sticks[0], sticks[1], -1.0 * x[5]]) / max(1.0, float(np.abs(sticks).max()))

    def _way_back(self, x: Array) -> Array | None:
        """Bow to the middle and ahead, from a wall within the stopping distance until the boat is well inside."""
        if self._beyond(x)[1].any():
            self.returning = True
        elif (np.abs(x[:2]) < HOME * self.safe).all():
            self.returning = False
        if not self.returning:
            return None
        turn = _wrapped(np.arctan2(-x[1], -x[0]) - x[2])
        across, along = WAY_BACK
        return np.array([max(across, along * np.cos(turn)), 0.0, 1.5 * turn - x[5]])


class PulseOperator(Operator):
    """Pulses of random size and length in one axis; the others only for station keeping."""

    def __init__(
        self,
        axis: int,
        entry: OperatorEntry,
        pool: Pool,
        rng: np.random.Generator,
        *,
        sway: bool = True,
    ) -> None:
        super().__init__(entry, pool, rng, sway=sway)
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
        if self.axis == 2:
            self.sticks[0] += self.entry.throttle
        self.sticks[self.axis] = side * size

    def _correction(self, x: Array) -> Array:
        """Back to the line of the pulses, if the boat is off it."""
        sticks = np.zeros(3)
        if self.axis != 2:
            off = _wrapped(x[2] - self.start_heading())
            if abs(off) > HEADING_DEADBAND:
                sticks[2] = min(max(-1.0 * off - 0.8 * x[5], -0.5), 0.5)
        if not self.sway:
            return sticks
        place, speed = _body(x[2], x[:2]), x[3:5]
        for axis in {0, 1} - {self.axis}:
            if abs(place[axis]) > POSITION_DEADBAND:
                sticks[axis] = min(max(-1.2 * place[axis] - 2.0 * speed[axis], -0.6), 0.6)
        return sticks


class CourseOperator(Operator):
    """Follows figures of eight, circles and squares in turn, with changes of heading."""

    def __init__(
        self, entry: OperatorEntry, pool: Pool, rng: np.random.Generator, *, sway: bool = True
    ) -> None:
        super().__init__(entry, pool, rng, sway=sway)
        self.size = self.safe * 0.75  # [m]
        self.started = 0.0
        self._choose(0)

    def drive(self, t: float, x: Array) -> Array:
        """Sticks towards a point that moves along the course, in steps of 0.1."""
        phase = (t - self.started) / self.lap
        if phase >= 2.0:
            self.started, phase = t, 0.0
            self._choose((self.kind + 1) % 3)
        offset = self._point(phase) - x[:2]
        place = _body(x[2], offset)
        direction = self._point(phase + 0.02) - self._point(phase) if self.sway else offset
        along = self.along or not self.sway
        heading = np.arctan2(direction[1], direction[0]) if along else 0.8 * np.sin(12.0 * phase)
        turn = _wrapped(heading - x[2])
        yaw = min(max(1.5 * turn, -0.9), 0.9) - 0.5 * x[5]
        sticks = np.array([*(2.5 * place - 2.0 * x[3:5]), yaw])
        if not self.sway:  # it goes round, bow first
            sticks[0] = max(sticks[0], WAY_BACK[0])
        return np.asarray(np.round(_limited(sticks) / 0.1) * 0.1)

    def _choose(self, kind: int) -> None:
        self.kind = kind
        self.lap = self.rng.uniform(*self.entry.lap)  # [s]
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
    drive: str, entry: OperatorEntry, pool: Pool, rng: np.random.Generator, *, sway: bool = True
) -> Operator:
    """The operator for a trial; `sway`: of a boat with thrust in sway."""
    if drive == "courses":
        return CourseOperator(entry, pool, rng, sway=sway)
    return PulseOperator(AXES.index(drive), entry, pool, rng, sway=sway)


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
