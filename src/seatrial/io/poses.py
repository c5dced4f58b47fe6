# SPDX-License-Identifier: MIT
"""Poses in SI units, of the boat's origin and in forward-left-up axes, from what sensors gave."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.schema import TO_SI, Column
from seatrial.boat.vehicle import Vehicle
from seatrial.io.signals import checked_unit, in_own_unit, scaled
from seatrial.recording.delays import heading_at_positions
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Axes, Stamps, earth_offset

ANGLE_UNITS = ("rad", "deg")
LENGTH_UNITS = ("m", "cm", "mm")
LARGEST_POSE = 1e9  # [m], [rad] a larger value is not a pose
UNITS_OF_POSES = {"x": LENGTH_UNITS, "y": LENGTH_UNITS, "psi": ANGLE_UNITS, "yaw_rate": ANGLE_UNITS}
NO_FIX = 1e-6  # [deg] from latitude and longitude 0, where a receiver without a fix is
LARGEST_LATITUDE, LARGEST_LONGITUDE = 90.0, 360.0  # [deg]
EARTH_RADIUS = 6.371e6  # [m] mean
FAR = 2e4  # [m] from the origin, beyond which the plane that touches the earth is no map


def pose_columns(vehicle: Vehicle) -> list[Column]:
    """x, y and psi of the vehicle file, their units checked."""
    columns = vehicle.file.pose.columns
    for name, column in columns.items():
        checked_unit(column, f"{vehicle.source}: pose: {name}", UNITS_OF_POSES[name])
    return [*columns.values()]


def of_origin(eta: Array, vehicle: Vehicle, stamps: Stamps | None = None) -> Array:
    """Poses (n, 3) of the boat's origin, forward-left-up, from those of the measured point in the file's axes.

    stamps: (n,) [ns], to turn the lever arm by the heading of the position's time.
    """
    eta = eta.copy()
    eta[np.abs(eta) > LARGEST_POSE] = np.nan
    psi, (position, heading) = eta[:, 2], vehicle.delays
    if stamps is not None:
        psi = heading_at_positions(stamps, psi, position - heading)
    ahead, second = vehicle.file.pose.lever or (0.0, 0.0)
    if ahead or second:  # a position is known without a heading, too
        eta[:, :2] -= earth_offset(psi, ahead, second)
    return eta * vehicle.axes.signs


def heading_of(values: Array, column: Column) -> Array:
    """Heading (n,) [rad] from a raw column; of a quaternion's the values are its yaw [rad]."""
    if column.quaternion:
        values = values / TO_SI[column.unit or "rad"]
    return scaled(values, column)


def degrees_of(raw: Array, columns: Sequence[Column]) -> Array:
    """Latitude and longitude (n, 2) [deg] from raw ones; NaN without a fix."""
    degrees = np.column_stack([in_own_unit(raw[:, i], c) for i, c in enumerate(columns)])
    degrees[(np.abs(degrees) <= NO_FIX).all(axis=1)] = np.nan
    return degrees


def in_plane(raw: Array, columns: Sequence[Column], vehicle: Vehicle) -> Array:
    """Positions (n, 2) [m] in the file's axes from raw latitude and longitude (n, 2).

    In the plane that touches the earth (WGS84) at the origin: x east and y north in forward-left-up, x north
    and y east in forward-right-down axes. NaN without a fix. Raises RecordingError where they are no degrees.
    """
    import pymap3d

    lat, lon = degrees_of(raw, columns).T
    known = np.isfinite(lat) & np.isfinite(lon)
    out = np.full((len(raw), 2), np.nan)
    if not known.any():
        raise RecordingError(
            f"{vehicle.source}: pose: latitude: {len(raw)} positions, none with a fix (all are 0 or empty); "
            "record when the receiver has one"
        )
    for name, values, most in (
        ("latitude", lat, LARGEST_LATITUDE),
        ("longitude", lon, LARGEST_LONGITUDE),
    ):
        largest = float(np.abs(values[known]).max())
        if largest > most:
            raise RecordingError(
                f"{vehicle.source}: pose: {name} reaches {largest:.6g} deg; give its scale (1.0e+7 for whole "
                "numbers of 1e-7 deg)"
            )
    origin = vehicle.file.pose.origin or (float(lat[known][0]), float(lon[known][0]))
    east, north, _ = pymap3d.geodetic2enu(lat[known], lon[known], 0.0, *origin, 0.0)
    far = float(np.median(np.hypot(east, north)))
    if far > FAR:
        raise RecordingError(
            f"{vehicle.source}: pose: origin {origin[0]:.4f}, {origin[1]:.4f} is {far / 1e3:.0f} km from the "
            "positions; give one near them, or leave it out"
        )
    second = vehicle.axes is Axes.FRD
    out[known] = np.column_stack([north, east] if second else [east, north])
    return out


def lengths_of_degrees(raw: Array, columns: Sequence[Column]) -> Array:
    """East and north (n, 2) [m] on a sphere, each of its own column (n, 2) of latitude and longitude.

    For the steps in which the log moves; NaN without a fix.
    """
    lat, lon = degrees_of(raw, columns).T
    shrunk = np.cos(np.radians(np.nanmedian(lat)))
    return np.asarray(EARTH_RADIUS * np.radians(np.column_stack([shrunk * lon, lat])))
