# SPDX-License-Identifier: MIT
"""The pool with posts and boxes: where a ray ends, and how far a point is from the next surface."""

from dataclasses import dataclass

import numpy as np

from seatrial.frames import Array
from seatrial.plan import Pool

POOL = Pool(length=12.0, width=5.0, margin=0.5)


@dataclass(frozen=True)
class Scene:
    """Surfaces that a LiDAR sees."""

    segments: Array  # (n, 4) x, y of either end [m]
    circles: Array  # (m, 3) x, y of the centre, radius [m]

    def ranges(self, origin: Array, angle: Array) -> Array:
        """Distances (k,) [m] to the first surface from origins (k, 2) along angles (k,) [rad].

        Infinite where a ray meets none.
        """
        ray = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        hits = [self._to_segments(origin, ray), self._to_circles(origin, ray)]
        return np.asarray(np.min(np.concatenate(hits, axis=1), axis=1, initial=np.inf))

    def _to_segments(self, origin: Array, ray: Array) -> Array:
        """(k, n): origin + distance ray = begin + share edge, by Cramer's rule."""
        begin, edge = self.segments[:, :2], self.segments[:, 2:] - self.segments[:, :2]
        off = begin[None] - origin[:, None]
        turn = _cross(ray[:, None], edge[None])
        safe = np.where(turn == 0.0, np.nan, turn)
        distance = _cross(off, edge[None]) / safe
        share = _cross(off, ray[:, None]) / safe
        return np.where((distance > 0.0) & (share >= 0.0) & (share <= 1.0), distance, np.inf)

    def _to_circles(self, origin: Array, ray: Array) -> Array:
        """(k, m): the nearer intersection."""
        off = self.circles[None, :, :2] - origin[:, None]
        along = np.sum(off * ray[:, None], axis=-1)
        square = self.circles[:, 2] ** 2 - _cross(off, ray[:, None]) ** 2
        distance = along - np.sqrt(np.maximum(square, 0.0))
        return np.where((square >= 0.0) & (distance > 0.0), distance, np.inf)

    def distance(self, points: Array) -> Array:
        """From points (k, 2) to the nearest surface (k,) [m]."""
        begin, edge = self.segments[:, :2], self.segments[:, 2:] - self.segments[:, :2]
        off = points[:, None] - begin[None]
        share = np.clip(np.sum(off * edge, axis=-1) / np.sum(edge**2, axis=-1), 0.0, 1.0)
        straight = np.linalg.norm(off - share[..., None] * edge, axis=-1)
        centre = np.linalg.norm(points[:, None] - self.circles[None, :, :2], axis=-1)
        return np.asarray(
            np.min(np.hstack([straight, np.abs(centre - self.circles[:, 2])]), axis=1)
        )


def box(x: float, y: float, length: float, width: float, turn: float = 0.0) -> Array:
    """Sides (4, 4) of a box around x, y [m], turned by `turn` [rad]."""
    half = 0.5 * np.array([length, width])
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    c, s = np.cos(turn), np.sin(turn)
    corners = corners @ np.array([[c, s], [-s, c]]) + [x, y]
    return np.hstack([corners, np.roll(corners, -1, axis=0)])


def pool_scene() -> Scene:
    """Walls, two posts and a box along the middle, a box and a ladder at the walls."""
    return Scene(
        np.vstack([
            box(0.0, 0.0, POOL.length, POOL.width),
            box(2.4, -0.1, 0.5, 0.4, turn=0.4),
            box(-4.6, 2.2, 0.8, 0.6),
            box(3.6, -2.4, 0.5, 0.2),
        ]),
        np.array([[0.0, 0.1, 0.15], [-2.6, -0.2, 0.1]]),
    )  # fmt: skip


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
