# SPDX-License-Identifier: MIT
"""Shapes of courses: circle, figure of eight, square, and any shape by its arc length."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial.util.frames import Array

Jet = tuple[float, float, float]  # a value and its first two derivatives
TABLE_POINTS = 4001  # of a shape's arc length


class Shape(ABC):
    """A path with headings."""

    @abstractmethod
    def at(self, s: float) -> Array:
        """Rows (3, 3): pose x, y [m], psi [rad], and its first two derivatives to s; s from 0 to `length`.

        psi is continuous: it is not wrapped.
        """

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
        # from -y on, as an eight never heads along +y, where arctan2 then jumps
        psi = np.arctan2(x[1], -y[1]) - np.pi / 2
        return np.array([[x[0], y[0], psi], [x[1], y[1], first], [x[2], y[2], second]])


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
