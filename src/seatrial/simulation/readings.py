# SPDX-License-Identifier: MIT
"""Readings of simulated sensors, forward-left-up."""

from dataclasses import dataclass

from seatrial import _core
from seatrial.util.frames import Array, freeze, frozen_array


@dataclass(frozen=True)
class Reading:
    """A reading of one boat; `values` as in the subclasses.

    boat: its name
    stamp: [s]
    arrival: [s] at the reader
    values: measured, as in the subclasses
    """

    boat: str
    stamp: float
    arrival: float
    values: Array

    def __post_init__(self) -> None:
        freeze(self, "values")


@dataclass(frozen=True)
class PoseReading(Reading):
    """x, y [m], psi [rad] of the measured point by the SLAM, at `stamp`."""

    @property
    def eta(self) -> Array:
        """(3,)."""
        return self.values


@dataclass(frozen=True)
class ImuReading(Reading):
    """Means over a period that ends at `stamp`; the specific force is without gravity."""

    @property
    def yaw_rate(self) -> float:
        """[rad/s]."""
        return float(self.values[0])

    @property
    def acceleration(self) -> Array:
        """(2,) forward, left [m/s^2] of the origin over ground."""
        return self.values[1:]


@dataclass(frozen=True)
class Scan(Reading):
    """A turn of the LiDAR; `stamp` is the first beam's time, the last is `sweep` later.

    angles: (n,) [rad] from the sensor's direction, positive to port
    sweep: [s]
    nearest: [m]
    farthest: [m]
    """

    angles: Array
    sweep: float
    nearest: float
    farthest: float

    @property
    def ranges(self) -> Array:
        """(n,) [m]; infinite: no surface in range."""
        return self.values


def reading_of(
    row: tuple[int, int, float, float, Array], boat: str, lidar: _core.Lidar | None
) -> Reading:
    """A reading from the core's row: kind, boat, stamp, arrival, values."""
    kind, _, stamp, arrival, values = row
    if kind == 0:
        return PoseReading(boat, stamp, arrival, values)
    if kind == 1:
        return ImuReading(boat, stamp, arrival, values)
    assert lidar is not None
    angles = frozen_array(lidar.angles())
    return Scan(boat, stamp, arrival, values, angles, lidar.sweep(), lidar.nearest, lidar.farthest)
