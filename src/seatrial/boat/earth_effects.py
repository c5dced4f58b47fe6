# SPDX-License-Identifier: MIT
"""Current and wind of a recording as size and direction, in the words of the recording's own frame."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import atan2, degrees, hypot

from seatrial.boat.schema import PoseSource, RecordingEntry, as_column
from seatrial.boat.vehicle import Vehicle
from seatrial.util.frames import Axes

UNITS = {"current": "m/s", "wind": "m/s^2"}  # of effects in earth axes, by kind
POINTS = (
    "north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west",
)  # fmt: skip
FIRST_AXES = {  # words in the name of x, where the position is east and north
    Axes.FLU: frozenset(("e", "east", "easting", "rechtswert", "ost")),
    Axes.FRD: frozenset(("n", "north", "northing", "hochwert", "nord")),
}


@dataclass(frozen=True)
class EarthEffect:
    """An effect with a direction over ground."""

    kind: str  # current, wind
    size: float
    error: float  # standard error of the size
    unit: str
    direction: str  # to which the current flows or the wind blows: 37 deg (north-east)


def earth_effects(vehicle: Vehicle, entry: RecordingEntry) -> Iterator[EarthEffect]:
    """Those that were estimated of a recording."""
    for kind, unit in UNITS.items():
        names = f"{kind}_x", f"{kind}_y"
        if all(name in entry.effects for name in names):
            x, y = (entry.effects[name] for name in names)
            ex, ey = (entry.errors.get(name, 0.0) for name in names)
            size = hypot(x, y)
            error = hypot(x * ex, y * ey) / size if size > 0.0 else hypot(ex, ey)
            yield EarthEffect(kind, size, error, unit, direction(vehicle, x, y))


def direction(vehicle: Vehicle, x: float, y: float) -> str:
    """Where a vector of the model's world (x, and y to its left) points to.

    As a bearing from north, clockwise, where the pose is east and north; else as the angle from x towards y
    of the file's axes.
    """
    second = vehicle.axes.lateral_sign * y
    if not _knows_north(vehicle.file.pose, vehicle.axes):
        return f"{round(degrees(atan2(second, x)))} deg from x towards y"
    north, east = (x, second) if vehicle.axes is Axes.FRD else (second, x)
    bearing = degrees(atan2(east, north)) % 360.0
    return f"{bearing:.0f} deg ({POINTS[round(bearing / 45.0) % 8]})"


def _knows_north(pose: PoseSource, axes: Axes) -> bool:
    """Whether positions are latitude and longitude, or columns named east and north."""
    x = as_column(pose.x)
    words = re.findall(r"[a-z]+", f"{x.column} {x.field}".lower())
    return pose.latitude is not None or not FIRST_AXES[axes].isdisjoint(words)


def forces_as_noise(recordings: Iterable[RecordingEntry]) -> list[str]:
    """Kinds of effects of a model's recordings, which it states as process noise: on board they are not known."""
    names = {name.partition("_")[0] for entry in recordings for name in entry.effects}
    return [kind for kind in ("current", "wind", "trim") if kind in names]
