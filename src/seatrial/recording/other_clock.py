# SPDX-License-Identifier: MIT
"""Poses and commands whose stamps are of two clocks: another unit, or another time zone."""

import numpy as np

from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

FACTORS = (1e3, 1e6, 1e9)  # between s, ms, us and ns
FACTOR_SLACK = 0.2  # of a factor, by which the lengths may differ from it
LENGTH_SLACK = 0.02  # of the length of poses and commands, by which they may differ
SINCE_1970 = 9e8  # [s] least time from a start that is one from 1970
ZONE = 900.0  # [s] time zones differ by multiples of it
# [s] from UTC, of zones of an odd quarter of an hour: Nepal 5:45, Eucla 8:45
QUARTERS_FROM = 18_000.0
ZONE_SLACK = 120.0  # [s] between the beginnings of two parts of one recording
MOST_ZONES = 104  # of 26 h


class OtherEpochError(RecordingError):
    """Stamps from 1970 beside stamps from a start, both of the same length: arrivals may be used."""


class OtherZoneError(RecordingError):
    """Stamps of poses and commands that are whole time zones apart."""

    def __init__(self, message: str, apart: float) -> None:
        super().__init__(message)
        self.apart = apart  # [s] commands after poses


def same_length(poses: Array, commands: Array) -> bool:
    """Whether both last as long: a simulation in real time."""
    lengths = float(np.ptp(poses)), float(np.ptp(commands))
    return abs(lengths[0] - lengths[1]) < LENGTH_SLACK * max(lengths)


def other_unit(poses: Array, commands: Array) -> str:
    """What to say where one of the stamps [s] is in another unit; empty: neither is."""
    lengths = float(np.ptp(poses)), float(np.ptp(commands))
    if min(lengths) <= 0:
        return ""
    ratio = max(lengths) / min(lengths)
    for factor in FACTORS:
        if abs(ratio / factor - 1) < FACTOR_SLACK:
            return (
                f"by their stamps poses last {lengths[0]:.4g} s and commands {lengths[1]:.4g} s, a factor of "
                f"{factor:.0f}: one of them is in another unit; name it in the vehicle file (stamp: unit)"
            )
    return ""


def zones_apart(poses: Array, commands: Array) -> float:
    """Whole time zones [s] by which commands are after poses, by their stamps [s]; 0: it is no such time."""
    ends = (float(commands[end] - poses[end]) for end in (0, -1))
    apart = min(ends, key=lambda s: abs(s - _zones(s) * ZONE))
    zones = _zones(apart)
    if abs(zones) > MOST_ZONES or abs(apart - zones * ZONE) > ZONE_SLACK:
        return 0.0
    return zones * ZONE


def _zones(apart: float) -> int:
    """The nearest number of quarter hours; near UTC zones differ by half hours."""
    quarters = round(apart / ZONE)
    return quarters if abs(quarters * ZONE) >= QUARTERS_FROM else 2 * round(apart / ZONE / 2)


def other_zone(poses: Array, commands: Array) -> str:
    """What to say where the stamps [s] are whole time zones apart; empty: they are not."""
    apart = zones_apart(poses, commands)
    if not apart:
        return ""
    side = "after" if apart > 0 else "before"
    return (
        f"commands are {abs(apart) / 3600:g} h {side} the poses: one of them is in another time zone; "
        f"write both by the same clock, or of a table with stamps in seconds set 'offset: {apart:.0f}' at "
        "commands: stamp"
    )


def other_epoch(poses: Array, commands: Array) -> str:
    """What to say where one of the stamps [s] counts from 1970, and the other from a start; else empty."""
    if abs(float(commands[0] - poses[0])) < SINCE_1970:
        return ""
    late, early = ("commands", "poses") if commands[0] > poses[0] else ("poses", "commands")
    return (
        f"stamps of the {late} count from 1970, those of the {early} from a start: simulated time (use_sim_time), "
        "or time since boot. Stamp both by one clock. For a bag that was recorded in real time, write "
        "'clock: bag' at pose: it uses the times of arrival"
    )
