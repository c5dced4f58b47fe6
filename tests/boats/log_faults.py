# SPDX-License-Identifier: MIT
"""Tables with the faults that real logs have, made from the tables of clean trials.

Each function takes poses (n, 4) t, x, y, psi and commands (m, 4) t and three inputs, and gives the text of
poses.csv and of commands.csv.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from seatrial.boat.vehicle import Vehicle, vehicle_from

FAULTS: dict[str, Callable[..., tuple[str, str]]] = {}
HOME = (63.4016, 10.3149)  # latitude, longitude [deg]
EARTH, SQUARED = 6378137.0, 0.00669437999  # [m] WGS 84: equatorial radius, eccentricity squared
INPUTS = ("F_u", "F_v", "F_r")


def fault(function):
    """Enter it under its name."""
    FAULTS[function.__name__] = function
    return function


def table(names, rows, form="%.9g") -> str:
    lines = [",".join(v if isinstance(v, str) else form % v for v in row) for row in rows]
    return "\n".join([",".join(names), *lines]) + "\n"


def plain(commands) -> str:
    return table(("t", *INPUTS), commands)


@fault
def held_position(poses, commands, rng):
    """An autopilot's log: the position is new on every second row, the heading on every row."""
    held = poses.copy()
    held[1::2, 1:3] = poses[0 : 2 * (len(poses) // 2) : 2, 1:3]
    return table(("t", "x", "y", "psi"), held), plain(commands)


@fault
def empty_position(poses, commands, rng):
    """The same with empty cells."""
    gone = poses.copy()
    gone[1::2, 1:3] = np.nan
    return table(("t", "x", "y", "psi"), gone).replace("nan", ""), plain(commands)


@fault
def valid_alternating(poses, commands, rng):
    """The same with a column that marks the rows whose position is new."""
    marked = np.column_stack([poses, np.arange(len(poses)) % 2 == 0])
    return table(("t", "x", "y", "psi", "ok"), marked), plain(commands)


@fault
def arrival_bursts(poses, commands, rng):
    """Motion capture over wireless: stamps of arrival, the network stalls."""
    t = poses[:, 0]
    arrival = t + rng.exponential(6e-4, len(t))
    start = t[0]
    while start < t[-1]:
        start += rng.exponential(4.0)
        for _ in range(rng.integers(1, 4)):
            length = rng.uniform(0.08, 0.22)
            waits = (t >= start) & (t < start + length)
            arrival[waits] = start + length + np.cumsum(rng.exponential(6e-5, waits.sum()))
            start += length
    late = np.column_stack([arrival, poses[:, 1:]])
    return table(("t", "x", "y", "psi"), late[np.argsort(arrival, kind="stable")]), plain(commands)


@fault
def pwm_zero_disarmed(poses, commands, rng):
    """PWM of 1500 +- 400 us, and 0 while disarmed."""
    pulses = np.round(1500 + 400 * commands[:, 1:])
    t = commands[:, 0]
    still = np.abs(commands[:, 1:]).max(axis=1) < 1e-9
    pulses[still & ((t < t[0] + 4) | (t > t[-1] - 3))] = 0
    return table(("t", "x", "y", "psi"), poses), table(("t", *INPUTS), np.column_stack([t, pulses]))


@fault
def compass(poses, commands, rng):
    """East, north and a heading from north, clockwise."""
    heading = np.round(np.mod(90 - np.rad2deg(poses[:, 3]), 360), 3)
    rows = np.column_stack([poses[:, :3], heading])
    return table(("t", "x", "y", "psi"), rows), plain(commands)


@fault
def utm_single_precision(poses, commands, rng):
    """Coordinates of a large map as 32-bit floats: y in steps of 0.5 m."""
    rows = poses.copy()
    rows[:, 1] = (poses[:, 1] + 597123.25).astype(np.float32)
    rows[:, 2] = (poses[:, 2] + 5921456.75).astype(np.float32)
    return table(("t", "x", "y", "psi"), rows, "%.6f"), plain(commands)


@fault
def utm_eight_digits(poses, commands, rng):
    """The same printed with eight digits: x in steps of 0.01 m, y of 0.1 m."""
    rows = [(t, "%.8g" % (x + 597123.25), "%.8g" % (y + 5921456.75), psi) for t, x, y, psi in poses]
    return table(("t", "x", "y", "psi"), rows), plain(commands)


@fault
def unpadded_nanoseconds(poses, commands, rng):
    """Seconds, a point, and nanoseconds without leading zeros."""

    def stamped(rows):
        whole = [round((row[0] + 1744366000) * 1e9) for row in rows]
        return [(f"{n // 10**9}.{n % 10**9}", *row[1:]) for n, row in zip(whole, rows, strict=True)]

    return (table(("t", "x", "y", "psi"), stamped(poses)), table(("t", *INPUTS), stamped(commands)))


@fault
def latitude_longitude(poses, commands, rng):
    """Degrees of latitude and longitude, new on every second row, and a compass."""
    held = poses.copy()
    held[1::2, 1:3] = poses[0 : 2 * (len(poses) // 2) : 2, 1:3]
    sine, cosine = np.sin(np.deg2rad(HOME[0])), np.cos(np.deg2rad(HOME[0]))
    normal = EARTH / np.sqrt(1 - SQUARED * sine**2)
    meridian = EARTH * (1 - SQUARED) / (1 - SQUARED * sine**2) ** 1.5
    latitude = HOME[0] + np.rad2deg(held[:, 2] / meridian)
    longitude = HOME[1] + np.rad2deg(held[:, 1] / (normal * cosine))
    heading = np.mod(90 - np.rad2deg(poses[:, 3]), 360)
    rows = np.column_stack([poses[:, 0], latitude, longitude, heading])
    return table(("t", "lat", "lon", "psi"), rows, "%.12g"), plain(commands)


@fault
def sampled_commands(poses, commands, rng):
    """A logger looks at the commands every 0.1 s, which the vehicle file states."""
    t = np.arange(commands[0, 0], commands[-1, 0], 0.1)
    at = np.searchsorted(commands[:, 0], t, side="right") - 1
    rows = np.column_stack([t, commands[at, 1:]])
    return table(("t", "x", "y", "psi"), poses), plain(rows)


def pose_of(fault: str) -> dict[str, object]:
    """What the vehicle file says of poses in which this fault is known."""
    psi: dict[str, object] = {"column": "psi"}
    if fault in ("compass", "latitude_longitude"):
        psi |= {"unit": "deg", "sign": -1, "offset": 90}
    pose: dict[str, object] = {"file": "poses.csv", "stamp": {"column": "t"}, "psi": psi}
    if fault == "unpadded_nanoseconds":
        pose["stamp"] = {"column": "t", "unit": "s.ns"}
    if fault == "latitude_longitude":
        return pose | {"latitude": "lat", "longitude": "lon"}
    valid = {"valid": "ok"} if fault == "valid_alternating" else {}
    return pose | {"x": "x", "y": "y"} | valid


def vehicle_for(boat: Vehicle, fault: str, **other: object) -> Vehicle:
    """The boat's vehicle file for tables with this fault, which it knows."""
    content = boat.to_mapping()
    content["pose"] = pose_of(fault) | other
    if fault == "pwm_zero_disarmed":
        inputs = {n: {"column": n, "offset": 1500, "scale": 400, "off": 0} for n in boat.inputs}
        content["commands"]["inputs"] = inputs
    if fault == "sampled_commands":
        content["commands"]["sampled"] = True
    if fault == "unpadded_nanoseconds":
        content["commands"]["stamp"] = {"column": "t", "unit": "s.ns"}
    return vehicle_from(content, "vehicle.yaml")


def written(
    trials: Mapping[str, tuple[np.ndarray, np.ndarray]], fault: str, folder: Path
) -> list[Path]:
    """The trials with this fault, as folders of tables."""
    paths = []
    for name, (poses, commands) in trials.items():
        path = folder / name
        path.mkdir()
        texts = FAULTS[fault](poses, commands, np.random.default_rng(3))
        for file, text in zip(("poses.csv", "commands.csv"), texts, strict=True):
            (path / file).write_text(text)
        paths.append(path)
    return paths
