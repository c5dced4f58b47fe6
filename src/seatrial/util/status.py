# SPDX-License-Identifier: MIT
"""How far long work is, and how long it still takes."""

import time
from typing import NamedTuple

TIME_LEFT_AFTER = 1.0  # [s] before, the time left is not estimated
# share done from which on the time left is estimated: stages are not exactly their shares
TIME_LEFT_FROM = 0.2
LONG, LONG_FROM = 20.0, 0.05  # [s] of work that lasts so long it is estimated from this share on


class Status(NamedTuple):
    """How far the work is."""

    stage: str  # names of the stages, the outer one first
    share: float  # of all the work, 0 to 1; never falls
    left: float | None  # [s] estimated; None: too early for an estimate


def time_left(begun: float, share: float) -> float | None:
    """[s] Estimated from the share done since `begun` [s] on the monotonic clock; None: too early."""
    elapsed = time.monotonic() - begun
    if elapsed < TIME_LEFT_AFTER or share < (TIME_LEFT_FROM if elapsed < LONG else LONG_FROM):
        return None
    return elapsed * (1.0 - share) / share


def duration_text(seconds: float) -> str:
    """For people: 12 s, 2 min 5 s, 1 h 3 min."""
    s = round(seconds)
    if s < 60:
        return f"{s} s"
    minutes, s = divmod(s, 60)
    if minutes < 60:
        return f"{minutes} min {s} s"
    return f"{minutes // 60} h {minutes % 60} min"
