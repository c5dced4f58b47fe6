# SPDX-License-Identifier: MIT
"""Tables with the faults that real logs have, made from the tables of clean trials.

Each function takes poses (n, 4) t, x, y, psi and commands (m, 4) t and three inputs, and gives the text of
poses.csv and of commands.csv.
"""

from collections.abc import Callable

import numpy as np

FAULTS: dict[str, Callable[..., tuple[str, str]]] = {}
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

    return (
        table(("t", "x", "y", "psi"), stamped(poses)),
        table(("t", *INPUTS), stamped(commands)),
    )


@fault
def latitude_longitude(poses, commands, rng):
    """Degrees of latitude and longitude, new on every second row, and a compass."""
    held = poses.copy()
    held[1::2, 1:3] = poses[0 : 2 * (len(poses) // 2) : 2, 1:3]
    north, east = held[:, 2], held[:, 1]
    latitude = 63.4016 + north / 111_461.5  # [m] of a degree at this latitude, WGS 84
    longitude = 10.3149 + east / (111_593.9 * np.cos(np.deg2rad(63.4016)))
    heading = np.mod(90 - np.rad2deg(poses[:, 3]), 360)
    rows = np.column_stack([poses[:, 0], latitude, longitude, heading])
    return table(("t", "lat", "lon", "psi"), rows, "%.12g"), plain(commands)
