# SPDX-License-Identifier: MIT
"""A scene: surfaces, current, sensors and starts, in one file.

Earth-fixed axes of REP-103: x, y [m], angles counter-clockwise from above.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final, Literal

import numpy as np

from seatrial import _core
from seatrial.boat.schema import Positive, Strict
from seatrial.simulation.sensors import Sensors
from seatrial.util.files import convert, expect_format, read_yaml
from seatrial.util.frames import Array, frozen_array

SCENE_FORMAT: Final = "scene 1"


@dataclass(frozen=True)
class Scene:
    """Surfaces for contact and for the LiDAR.

    segments: (n, 4) x, y of either end [m]
    circles: (m, 3) x, y of the centre, radius [m]
    """

    segments: Array
    circles: Array

    def __post_init__(self) -> None:
        for name, width in (("segments", 4), ("circles", 3)):
            rows = np.reshape(np.asarray(getattr(self, name), dtype=float), (-1, width))
            object.__setattr__(self, name, frozen_array(rows))

    @cached_property
    def core(self) -> _core.Scene:
        """The core's scene."""
        return _core.Scene(self.segments, self.circles)

    def ranges(self, origin: Array, angle: Array) -> Array:
        """Distances (k,) [m] to the first surface from origins (k, 2) along angles (k,) [rad].

        Infinite where a ray meets no surface.
        """
        return self.core.ranges(np.ascontiguousarray(origin), np.ascontiguousarray(angle))

    def distance(self, points: Array) -> Array:
        """From points (k, 2) to the nearest surface (k,) [m]."""
        return self.core.distance(np.ascontiguousarray(points))


def box(x: float, y: float, length: float, width: float, turn: float = 0.0) -> Array:
    """Sides (4, 4) of a box around x, y [m], turned by `turn` [rad]."""
    return _core.box(x, y, length, width, turn)


def pool(length: float, width: float) -> Scene:
    """Four walls around the origin, the length along x [m]."""
    return Scene(box(0.0, 0.0, length, width), np.zeros((0, 3)))


class PoolEntry(Strict, frozen=True):
    """Four walls around the origin."""

    length: Positive  # [m] along x
    width: Positive  # [m]


class BoxEntry(Strict, frozen=True):
    """A box in the water, or a boat that does not move."""

    x: float  # [m]
    y: float  # [m]
    length: Positive  # [m]
    width: Positive  # [m]
    turn_deg: float = 0.0  # [deg]


class PostEntry(Strict, frozen=True):
    """A round post."""

    x: float  # [m]
    y: float  # [m]
    radius: Positive  # [m]


class BoatEntry(Strict, frozen=True):
    """Start of a boat; in the order of the models."""

    start: tuple[float, float, float] = (0.0, 0.0, 0.0)  # x, y [m], psi [rad]
    name: str = ""  # default: the model's
    radius: Positive | None = None  # [m] of the contact disc; default: the core's


class SceneFile(Strict, frozen=True):
    """`scene.yaml`."""

    seatrial: Literal["scene 1"] = SCENE_FORMAT
    name: str = "scene"
    pool: PoolEntry | None = None
    walls: Sequence[tuple[float, float, float, float]] = ()  # x, y of either end [m]
    boxes: Sequence[BoxEntry] = ()
    posts: Sequence[PostEntry] = ()
    current: tuple[float, float] = (0.0, 0.0)  # [m/s] of the water, along x and y
    sensors: Sensors = Sensors()
    boats: Sequence[BoatEntry] = ()

    @property
    def surfaces(self) -> Scene:
        """All surfaces."""
        sides = [] if self.pool is None else [box(0.0, 0.0, self.pool.length, self.pool.width)]
        sides += [np.array(self.walls, dtype=float).reshape(-1, 4)]
        sides += [
            box(b.x, b.y, b.length, b.width, float(np.deg2rad(b.turn_deg))) for b in self.boxes
        ]
        posts = [[p.x, p.y, p.radius] for p in self.posts]
        return Scene(np.vstack(sides), np.array(posts, dtype=float).reshape(-1, 3))


def load_scene(path: str | Path) -> SceneFile:
    """A scene from its file. Raises SeatrialError."""
    return convert(expect_format(read_yaml(Path(path)), SCENE_FORMAT, path), SceneFile, path)
