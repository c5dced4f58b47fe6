# SPDX-License-Identifier: MIT
"""Tracks: straight legs between points with rounded corners."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial.control.tracking.shapes import Jet, Shape
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array

PEAK_BEND = 1.875  # largest bend of a corner over its mean: the peak of 30 z^2 (1 - z)^2
SHARPEST_CORNER = np.radians(150.0)  # [rad] of a track
QUADRATURE_POINTS = 20  # Gauss-Legendre, of a corner


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
                corner = points[k + 1] - cut[k + 1] * along
                parts.append(_Part(begin, bend, corner, float(heading), float(turns[k])))
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
