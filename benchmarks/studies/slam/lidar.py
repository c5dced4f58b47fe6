# SPDX-License-Identifier: MIT
"""A scanning LiDAR like the paper's SICK TiM571: 270 degrees in thirds of a degree, 15 Hz."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.studies.slam.se2 import between, transform
from seatrial.simulation.scene import Scene
from seatrial.util.frames import Array

RATE = 15.0  # [Hz] turns of the mirror
FIELD = np.deg2rad(270.0)
BEAMS = 811
FARTHEST = 25.0  # [m]
NOISE = 0.02  # [m] statistical error, standard deviation
BIAS = 0.06  # [m] largest systematic error
ANGLES = np.linspace(-0.5 * FIELD, 0.5 * FIELD, BEAMS)  # [rad] from forward, to port positive
TIMES = ANGLES / (2.0 * np.pi * RATE)  # [s] from the scan's stamp, at which it looks forward

Poses = Callable[[Array], Array]  # times (n,) [s] to poses (n, 3)


@dataclass(frozen=True)
class Scan:
    """One turn. The sensor sits in the boat's origin and looks ahead."""

    stamp: float  # [s] of the beam that looks forward
    t: Array  # (n,) [s] of every beam that met something
    points: Array  # (n, 2) [m], in the boat's frame at that beam's own time

    @property
    def end(self) -> float:
        """When the scan is complete [s]."""
        return self.stamp + float(TIMES[-1])


def scan(scene: Scene, poses: Poses, stamp: float, bias: float, rng: np.random.Generator) -> Scan:
    """What is measured around `stamp` [s] from a boat that moves on meanwhile."""
    t = stamp + TIMES
    at = poses(t)
    true = scene.ranges(at[:, :2], at[:, 2] + ANGLES)
    measured = true + bias + rng.normal(0.0, NOISE, BEAMS)
    seen = (measured > 0.0) & (measured < FARTHEST)
    directions = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=-1)
    return Scan(stamp, t[seen], (measured[:, None] * directions)[seen])


def undistorted(found: Scan, poses: Poses) -> Array:
    """Points (n, 2) as the boat would have seen them all at the stamp, had it moved as `poses`."""
    at, reference = poses(found.t), poses(np.array([found.stamp]))
    return transform(between(reference, at), found.points)
