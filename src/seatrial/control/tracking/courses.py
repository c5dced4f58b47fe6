# SPDX-License-Identifier: MIT
"""Feasible reference courses: circles, figures of eight, squares, tracks with rounded corners.

A course is a shape, smooth in a parameter s, and a timetable s(t) that starts and ends at rest with
continuous acceleration. `fitted` finds the shortest duration within thrust and identified speeds.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.control.allocation.steered import steering_of
from seatrial.control.tracking.reference import Reference
from seatrial.control.tuning.linear import LinearBoat, linearise, steady_motions
from seatrial.control.tuning.steered import steered_shares
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array

Jet = tuple[float, float, float]  # a value and its first two derivatives
DEMAND_SHARE = 0.6  # of thrust and identified speeds that a course uses; the rest is for feedback
COURSE_SAMPLES = 600  # of a course, at which its demand is computed
PEAK_BEND = 1.875  # largest bend of a corner over its mean: the peak of 30 z^2 (1 - z)^2
SHARPEST_CORNER = np.radians(150.0)  # [rad] of a track
QUADRATURE_POINTS = 20  # Gauss-Legendre, of a corner
TABLE_POINTS = 4001  # of a shape's arc length
LONGEST_COURSE = 1e4  # [s] a longer course is refused


class Shape(ABC):
    """A path with headings."""

    @abstractmethod
    def at(self, s: float) -> Array:
        """Rows (3, 3): pose x, y [m], psi [rad], and its first two derivatives to s; s from 0 to `length`."""

    @property
    @abstractmethod
    def length(self) -> float:
        """Of s."""

    @property
    def stops(self) -> int:
        """Equal parts of s that start and end at rest."""
        return 1


@dataclass(frozen=True)
class Circle(Shape):
    """Round the origin, forward along the tangent."""

    radius: float  # [m]
    laps: int = 1

    @property
    def length(self) -> float:
        """Radians."""
        return 2.0 * np.pi * self.laps

    def at(self, s: float) -> Array:
        """From (radius, 0) on, counter-clockwise."""
        c, k = self.radius * np.cos(s), self.radius * np.sin(s)
        return np.array([[c, k, s + np.pi / 2], [-k, c, 1.0], [-c, -k, 0.0]])


@dataclass(frozen=True)
class Eight(Shape):
    """Gerono's figure of eight, forward along the tangent: x = a sin s, y = b sin 2s."""

    length_x: float  # [m] a, half of its length
    width_y: float  # [m] b, half of its width
    laps: int = 1

    @property
    def length(self) -> float:
        """Radians."""
        return 2.0 * np.pi * self.laps

    def at(self, s: float) -> Array:
        """From the origin on."""
        a, b = self.length_x, self.width_y
        x = a * np.array([np.sin(s), np.cos(s), -np.sin(s), -np.cos(s)])
        y = b * np.array([np.sin(2 * s), 2 * np.cos(2 * s), -4 * np.sin(2 * s), -8 * np.cos(2 * s)])
        v2 = x[1] ** 2 + y[1] ** 2
        bend = x[1] * y[2] - y[1] * x[2]  # psi' v2
        first = bend / v2
        second = (x[1] * y[3] - y[1] * x[3]) / v2 - 2.0 * first * (x[1] * x[2] + y[1] * y[2]) / v2
        # arctan2 is discontinuous only where the boat heads along -x, which an eight does not
        return np.array(
            [[x[0], y[0], np.arctan2(y[1], x[1])], [x[1], y[1], first], [x[2], y[2], second]]
        )


@dataclass(frozen=True)
class Square(Shape):
    """Round the origin, the heading kept: forward, sideways, backward, sideways; it stops at corners."""

    side: float  # [m]
    laps: int = 1
    heading: float = 0.0  # [rad]

    @property
    def length(self) -> float:
        """Sides."""
        return 4.0 * self.laps

    @property
    def stops(self) -> int:
        """Every side."""
        return 4 * self.laps

    def at(self, s: float) -> Array:
        """From (-side/2, -side/2) on, along x first."""
        corners = 0.5 * self.side * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        k = min(int(s), int(self.length) - 1)
        side = corners[(k + 1) % 4] - corners[k % 4]
        x, y = corners[k % 4] + (s - k) * side
        return np.array([[x, y, self.heading], [side[0], side[1], 0.0], [0.0, 0.0, 0.0]])


@dataclass(frozen=True)
class ByLength(Shape):
    """A shape along which s is the arc length [m], so that a steady timetable is a steady speed."""

    shape: Shape

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Parameters of the shape, and the lengths [m] up to them."""
        s = np.linspace(0.0, self.shape.length, TABLE_POINTS)
        speed = np.array([np.hypot(*self.shape.at(float(x))[1, :2]) for x in s])
        steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(s)
        return s, np.concatenate([[0.0], np.cumsum(steps)])

    @property
    def length(self) -> float:
        """[m]."""
        return float(self._table[1][-1])

    def at(self, s: float) -> Array:
        """At s [m]."""
        own, lengths = self._table
        pose, first, second = self.shape.at(float(np.interp(s, lengths, own)))
        speed = float(np.hypot(*first[:2]))
        rate = 1.0 / speed
        change = -float(first[:2] @ second[:2]) / speed**4
        return np.array([pose, first * rate, second * rate**2 + first * change])


@dataclass(frozen=True)
class Track(Shape):
    """Straight legs between points, bow first, the corners rounded; s is the arc length [m].

    In a corner the heading is a polynomial of the arc length, with continuous bend and its slope; `radius` [m]
    is the tightest. Raises ControlError where a leg is too short for its corners.
    """

    points: Sequence[tuple[float, float]]  # [m]
    radius: float  # [m]

    def __post_init__(self) -> None:
        if not (len(self.points) > 1 and np.isfinite(self.radius) and self.radius > 0.0):
            raise ControlError(
                f"track of {len(self.points)} points with a radius of {self.radius:g} m: expected two points "
                "or more, and a radius above 0"
            )
        object.__setattr__(self, "points", tuple(self.points))
        short = [k for k, part in enumerate(self._parts) if part.length < 0.0]
        if short:
            raise ControlError(
                f"track: leg {short[0] // 2 + 1} is shorter than its corners of {self.radius:g} m, by "
                f"{-self._parts[short[0]].length:.2g} m; lengthen it, or lower the radius"
            )

    @cached_property
    def _parts(self) -> "tuple[_Part, ...]":
        """Legs and corners in turn."""
        points = np.array(self.points, dtype=float)
        legs = np.diff(points, axis=0)
        headings = np.unwrap(np.arctan2(legs[:, 1], legs[:, 0]))
        turns = np.diff(headings)
        cut = [0.0, *(_corner_cut(float(turn), self.radius) for turn in turns), 0.0]
        parts: list[_Part] = []
        begin = 0.0
        for k, (leg, heading) in enumerate(zip(legs, headings, strict=True)):
            along = leg / np.hypot(*leg)
            straight = float(np.hypot(*leg)) - cut[k] - cut[k + 1]
            parts.append(_Part(begin, straight, points[k] + cut[k] * along, float(heading), 0.0))
            begin += straight
            if k < len(turns):
                bend = PEAK_BEND * abs(float(turns[k])) * self.radius
                parts.append(
                    _Part(
                        begin,
                        bend,
                        points[k + 1] - cut[k + 1] * along,
                        float(heading),
                        float(turns[k]),
                    )
                )
                begin += bend
        return tuple(parts)

    @property
    def length(self) -> float:
        """[m]."""
        return self._parts[-1].begin + self._parts[-1].length

    def at(self, s: float) -> Array:
        """At s [m]."""
        part = next((p for p in self._parts if s < p.begin + p.length), self._parts[-1])
        return part.at(s - part.begin)


@dataclass(frozen=True)
class _Part:
    """A leg, or a corner, of a track."""

    begin: float  # [m] of the arc length
    length: float  # [m]
    start: Array  # (2,) [m]
    heading: float  # [rad] at its start
    turn: float  # [rad]; 0: a leg

    def at(self, s: float) -> Array:
        """Rows (3, 3) as of `Shape.at`, s [m] after its start."""
        psi, bend, change = self._bent(s)
        c, k = np.cos(psi), np.sin(psi)
        if self.turn == 0.0:
            x, y = self.start + s * np.array([c, k])
        else:
            at, weight = np.polynomial.legendre.leggauss(QUADRATURE_POINTS)
            angles = np.array([self._bent(0.5 * s * (1.0 + q))[0] for q in at])
            x, y = self.start + 0.5 * s * np.array(
                [weight @ np.cos(angles), weight @ np.sin(angles)]
            )
        return np.array([[x, y, psi], [c, k, bend], [-k * bend, c * bend, change]])

    def _bent(self, s: float) -> Jet:
        """Heading with its first two derivatives to s."""
        if self.turn == 0.0:
            return self.heading, 0.0, 0.0
        z, per = s / self.length, self.turn / self.length
        share = z**3 * (10.0 - 15.0 * z + 6.0 * z**2)
        slope = 30.0 * z**2 * (1.0 - z) ** 2
        change = 60.0 * z * (1.0 - z) * (1.0 - 2.0 * z)
        return self.heading + self.turn * share, per * slope, per * change / self.length


def _corner_cut(turn: float, radius: float) -> float:
    """Length [m] that a rounded corner takes of each of its legs."""
    if turn == 0.0:
        return 0.0
    if abs(turn) > SHARPEST_CORNER:
        raise ControlError(
            f"track: a corner of {np.degrees(abs(turn)):.0f} degrees; expected at most "
            f"{np.degrees(SHARPEST_CORNER):.0f}: make it of two"
        )
    bend = _Part(0.0, PEAK_BEND * abs(turn) * radius, np.zeros(2), 0.0, turn)
    end = bend.at(bend.length)[0]
    return float(end[1] / np.sin(turn))


def rounded_square(side: float, radius: float, laps: int = 1) -> Track:
    """Counter-clockwise along a square with a corner at the origin, bow first, from the middle of a side on."""
    corners = [(side, 0.0), (side, side), (0.0, side), (0.0, 0.0)] * laps
    return Track(((0.5 * side, 0.0), *corners, (0.5 * side, 0.0)), radius)


def lawn_mower(length: float, spacing: float, lanes: int, radius: float) -> Track:
    """Lanes of a length [m] beside each other, to and fro, from the origin along x."""
    points = []
    for lane in range(lanes):
        ends = (0.0, length) if lane % 2 == 0 else (length, 0.0)
        points += [(x, lane * spacing) for x in ends]
    return Track(tuple(points), radius)


@dataclass(frozen=True)
class Course:
    """A shape and its timetable."""

    shape: Shape
    duration: float  # [s]
    ramp: float = 0.2  # share of each part for acceleration, and the same for deceleration

    def __post_init__(self) -> None:
        if not (np.isfinite(self.duration) and self.duration > 0.0 and 0.0 < self.ramp <= 0.5):
            raise ControlError(
                f"course of {self.duration:g} s with ramps of {self.ramp:g}: expected more than 0 s, and a "
                "share above 0, up to 0.5"
            )

    def at(self, t: float) -> Reference:
        """The reference at t [s]; at rest before the start and after the end."""
        s, rate, change = self.progress(t)
        pose, first, second = self.shape.at(s)
        return Reference(pose, first * rate, second * rate**2 + first * change)

    def progress(self, t: float) -> Jet:
        """s with its first two derivatives to time."""
        part = self.duration / self.shape.stops
        step = self.shape.length / self.shape.stops
        now = min(max(t, 0.0), self.duration)
        k = min(int(now / part), self.shape.stops - 1)
        share, speed, change = timetable((now - k * part) / part, self.ramp)
        return step * (k + share), step * speed / part, step * change / part**2


def timetable(x: float, ramp: float) -> Jet:
    """From 0 to 1 over x from 0 to 1: a smooth start, a steady middle, a smooth end."""
    if x > 0.5:
        share, speed, change = timetable(1.0 - x, ramp)
        return 1.0 - share, speed, -change
    top = 1.0 / (1.0 - ramp)  # speed of the middle
    if x >= ramp:
        return top * (x - 0.5 * ramp), top, 0.0
    z = x / ramp
    height = z**4 * (2.5 - 3.0 * z + z**2)  # integral of the next
    speed = z**3 * (10.0 - 15.0 * z + 6.0 * z**2)
    change = 30.0 * z**2 * (1.0 - z) ** 2
    return top * ramp * height, top * speed, top * change / ramp


def at_speed(shape: Shape, speed: float, ramp: float) -> Course:
    """A shape whose s is the arc length at a speed [m/s], reached and left within `ramp` [s].

    Raises ControlError where one of them is not above 0.
    """
    if not 0.0 < speed < np.inf or not 0.0 < ramp < np.inf:
        raise ControlError(
            f"course at {speed:g} m/s with ramps of {ramp:g} s: expected a speed and ramps above 0"
        )
    duration = shape.length / speed + ramp
    return Course(shape, duration, min(ramp / duration, 0.5))


def fitted(shape: Shape, model: Model, share: float = DEMAND_SHARE) -> Course:
    """The quickest course within `share` of thrust and identified speeds.

    Raises ControlError where the boat can't follow the shape at all.
    """
    boat, most = linearise(model), np.abs(steady_motions(model)).max(axis=0)

    def feasible(duration: float) -> bool:
        return _demand(Course(shape, duration), model, boat, most) <= share

    return Course(shape, _shortest(feasible, model.name))


def _shortest(feasible: Callable[[float], bool], name: str) -> float:
    low, high = 0.0, 1.0
    while not feasible(high):
        low, high = high, 2.0 * high
        if high > LONGEST_COURSE:
            raise ControlError(f"{name}: can't follow this course even in {LONGEST_COURSE:g} s")
    while high - low > 1e-3 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if feasible(middle) else (middle, high)
    return high


def _demand(course: Course, model: Model, boat: LinearBoat, most: Array) -> float:
    """Largest share of commands, thrust and speeds that a course uses."""
    times = np.linspace(0.0, course.duration, COURSE_SAMPLES)
    motions = [course.at(float(t)).body() for t in times]
    nu, nu_dot = (np.array(rows) for rows in zip(*motions, strict=True))
    forces = np.zeros((len(nu), len(model.structure.forces)))
    free = _core.accelerations(
        model.structure.compiled, model.coefficients, np.ascontiguousarray(nu), forces
    )
    speeds = float((np.abs(nu) / most).max())
    if (steering := steering_of(model)) is not None:
        return max(float(steered_shares(steering, nu, nu_dot - free).max()), speeds)
    commands = ((nu_dot - free) * boat.per_authority) @ boat.mix.T
    size = np.abs(commands).max(axis=1)
    # the allocation's limit: the share of the command that remains when its largest input is 1
    full = commands / np.maximum(size, 1e-12)[:, None]
    _, given = _core.allocate(model.vehicle.chain, np.ascontiguousarray(full))
    return max(float((size / given).max()), speeds)
