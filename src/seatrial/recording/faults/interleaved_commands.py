# SPDX-License-Identifier: MIT
"""Commands of two sources that are mixed row by row: two nodes on one topic, two loggers in one table."""

import numpy as np

from seatrial.recording.signal import Signal
from seatrial.util.format import joined, percent

LEAST_LEAP = 0.05  # of an input's range; a change below may be the flicker of a digit
UNDONE = 0.1  # of a leap, most that is left of it a row later
LONGEST_FLASH = 0.2  # [s] from before a leap to after its return: no driver gives so short a pulse
MIXED_SHARE = 0.5  # of the leaps that are undone at once


def interleaving_doubt(commands: Signal) -> list[str]:
    """The doubt where most changes of a command are undone by the next row."""
    known = np.isfinite(commands.values).all(axis=1)
    values, t = commands.values[known], 1e-9 * (commands.stamps - commands.stamps[:1])[known]
    if len(values) < 3:
        return []
    size = np.ptp(values, axis=0)
    leap, left = np.abs(np.diff(values, axis=0))[:-1], np.abs(values[2:] - values[:-2])
    leaps = (leap > LEAST_LEAP * size) & (size > 0.0)
    undone = leaps & (left < UNDONE * leap) & (t[2:] - t[:-2] < LONGEST_FLASH)[:, None]
    mixed = undone.sum(axis=0) > MIXED_SHARE * leaps.sum(axis=0)
    if not mixed.any():
        return []
    share = undone[:, mixed].sum() / leaps[:, mixed].sum()
    names = joined([name for name, one in zip(commands.names, mixed, strict=True) if one])
    return [
        f"{percent(share)} of the changes of {names} are undone by the next row: do two sources command the "
        "thrusters, such as a joypad and an idle autopilot on one topic? Thrust is wrong then. Record what the "
        "thrusters get, or take out the rows of the other source"
    ]
