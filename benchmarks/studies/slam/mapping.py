# SPDX-License-Identifier: MIT
"""A map of points and small_gicp's match of a scan to it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.studies.slam.se2 import transform
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Array

try:
    import small_gicp
except ImportError:
    raise SeatrialError(
        "small_gicp is not installed; expected for this study: pip install 'small-gicp>=1.0'"
    ) from None

CELL, SCAN_CELL = 0.05, 0.1  # [m] of the map, and of a scan before it is matched
FARTHEST_CELL = 1 << 31  # more than there are along an axis
NEIGHBOURS = 20  # points that make a covariance: small_gicp's default
HEIGHTS = (0.0, 2.0 * CELL)  # [m] of the copies of a point: of one level all would lie flat
REACH = 1.0  # [m] farthest correspondence: small_gicp's default
FINE = 0.2  # [m] the same once more, from there
ITERATIONS = 40
NEAR = 0.1  # [m] a matched point is that near to the map


@dataclass(frozen=True)
class Match:
    """Where the matcher puts a scan."""

    pose: Array  # (3,)
    converged: bool
    share: float  # of the scan's points that are NEAR the map
    iterations: int


class Map:
    """Means of points in square cells, every scan of one weight. It begins with a scan."""

    def __init__(self, points: Array, pose: Array) -> None:
        self.total: Array = np.zeros((0, 2))
        self.count: Array = np.zeros(0)
        self.insert(points, pose)

    @property
    def points(self) -> Array:
        """(n, 2) [m]."""
        return self.total / self.count[:, None]

    def insert(self, points: Array, pose: Array) -> None:
        """Points (n, 2) [m] of the boat's frame."""
        new = thinned(transform(pose, points), CELL)
        place = cells(np.vstack([self.points, new]), CELL)
        self.total = sums(place, np.vstack([self.total, new]))
        weights = np.concatenate([self.count, np.ones(len(new))])
        self.count = np.asarray(np.bincount(place, weights), dtype=float)
        self.cloud = _Cloud(self.points)

    def match(self, points: Array, guess: Array, reach: float = REACH) -> Match:
        """Points (n, 2) [m] of the boat's frame, from a guess (3,) of the boat's pose."""
        source = _Cloud(thinned(points, SCAN_CELL))
        T, iterations = matrix(guess), 0
        for farthest in (reach, FINE):  # then without what the map has not seen yet
            found = small_gicp.align(
                self.cloud.points, source.points, self.cloud.tree, T,
                registration_type="GICP", max_correspondence_distance=farthest, max_iterations=ITERATIONS,
            )  # fmt: skip
            T, iterations = found.T_target_source, iterations + int(found.iterations)
        pose = np.array([T[0, 3], T[1, 3], np.arctan2(T[1, 0], T[0, 0])])
        placed = np.column_stack([transform(pose, source.flat), np.zeros(len(source.flat))])
        _, squared = self.cloud.tree.batch_nearest_neighbor_search(placed)
        share = float(np.mean(np.asarray(squared) < NEAR**2))
        return Match(pose, bool(found.converged), share, iterations)


class _Cloud:
    """Points of the plane as small_gicp takes them."""

    def __init__(self, flat: Array) -> None:
        self.flat = flat  # (n, 2)
        self.points = small_gicp.PointCloud(lifted(flat))
        self.tree = small_gicp.KdTree(self.points)
        small_gicp.estimate_covariances(self.points, self.tree, NEIGHBOURS)


def lifted(points: Array) -> Array:
    """Points (n, 2) as upright pieces of wall (2 n, 3): level after level."""
    return np.vstack([np.column_stack([points, np.full(len(points), z)]) for z in HEIGHTS])


def matrix(pose: Array) -> Array:
    """A pose (3,) as a homogeneous matrix (4, 4)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    T = np.eye(4)
    T[:2, :2], T[:2, 3] = [[c, -s], [s, c]], pose[:2]
    return T


def thinned(points: Array, cell: float) -> Array:
    """The mean of the points (n, 2) in every square cell (m, 2)."""
    place = cells(points, cell)
    return np.asarray(sums(place, points) / np.bincount(place)[:, None])


def cells(points: Array, cell: float) -> NDArray[np.int64]:
    """Which cell (n,) each point is in, numbered from 0 without gaps."""
    x, y = np.floor(points / cell).astype(np.int64).T
    return np.asarray(np.unique(x * FARTHEST_CELL + y, return_inverse=True)[1])


def sums(place: NDArray[np.int64], points: Array) -> Array:
    """Sums (m, 2) of the points of every cell."""
    return np.column_stack([np.bincount(place, points[:, i]) for i in range(2)])
