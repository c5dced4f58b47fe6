# SPDX-License-Identifier: MIT
"""How a signal arrived: its rate and gaps, and what its clock has to do with the recorder's."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from enum import Enum

import numpy as np

from seatrial.frames import Array, Mask, Stamps

BLOCKS = 40  # that a recording is cut into to look for steps of its clock
LEAST_BLOCK = 10  # messages
STEP = 0.05  # [s] a clock that is set moves by more than this


class Clock(str, Enum):
    """Where stamps come from."""

    HEADER = "header"
    ARRIVAL = "arrival in the bag"  # asked for, or the message has no header
    ZERO = "arrival in the bag, as its headers hold no time"
    COLUMN = "column of the table"


@dataclass(frozen=True)
class Delay:
    """Arrival in the bag minus stamp: transport, plus what the clocks are apart."""

    least: float  # [s]
    median: float  # [s]
    most: float  # [s]
    drift: float  # [s] from the first tenth to the last
    step: float  # [s] largest sudden change; 0: none
    step_at: float  # [s] from the first message

    def __str__(self) -> str:
        """Least and most, in words."""
        low, high = (round(1e3 * x) for x in (self.least, self.most))
        if low < 0:
            return (
                f"{-high} to {-low} ms after arrival"
                if high < 0
                else f"{low} to {high} ms off arrival"
            )
        return f"{low} to {high} ms before arrival"


@dataclass(frozen=True)
class Stream:
    """One topic or table as it was recorded."""

    role: str  # poses, commands, scales
    source: str  # topic, or file
    kind: str  # message type, or table
    clock: Clock
    count: int
    rate: float  # [Hz] by the median step; 0 with fewer than two
    longest: float  # [s] longest step
    jitter: float  # [s] standard deviation of the steps, gaps aside
    duplicated: int  # stamps equal to the one before
    backward: int  # stamps before the one before
    on_change: bool  # written when something changed rather than in a rhythm
    delay: Delay | None = None  # where both stamp and arrival are known
    publishers: int = 1


def describe(
    role: str,
    source: str,
    kind: str,
    *,
    clock: Clock,
    stamps: Stamps,
    arrival: Stamps | None = None,
    publishers: int = 1,
) -> Stream:
    """A stream from its stamps (n,) [ns] in the order of the file, and when they arrived."""
    steps = np.diff(stamps).astype(np.float64) * 1e-9
    forward = steps[steps > 0]
    period = float(np.median(forward)) if len(forward) else 0.0
    near = forward[forward < 1.5 * period]
    delay = None
    if arrival is not None and clock is Clock.HEADER and len(stamps):
        delay = _delay(stamps, arrival)
    return Stream(
        role, source, kind, clock, len(stamps), 1.0 / period if period else 0.0,
        float(forward.max()) if len(forward) else 0.0,
        float(np.std(near)) if len(near) else 0.0,
        int((steps == 0).sum()), int((steps < 0).sum()), not steady(forward), delay, publishers,
    )  # fmt: skip


def steady(steps: Array) -> bool:
    """Whether steps [s] are those of a rhythm: silence is then a hole, not the absence of change."""
    if len(steps) < 20:
        return False
    return bool(np.percentile(steps, 90) < 2.0 * np.median(steps))


def longest_rising(stamps: Stamps, *, strict: bool = True) -> Mask:
    """The most stamps (n,) that can be kept so that those kept rise.

    One stamp far ahead of its time is left out, rather than all that follow it.
    """
    steps = np.diff(stamps)
    if np.all(steps > 0 if strict else steps >= 0):
        return np.ones(len(stamps), dtype=bool)
    place = bisect_left if strict else bisect_right
    ends: list[int] = []  # smallest last stamp of a rising choice of each length
    last: list[int] = []  # where that stamp is
    before = np.full(len(stamps), -1, dtype=np.int64)
    for i, stamp in enumerate(stamps.tolist()):
        length = place(ends, stamp)
        before[i] = last[length - 1] if length else -1
        if length == len(ends):
            ends.append(stamp)
            last.append(i)
        else:
            ends[length], last[length] = stamp, i
    keep = np.zeros(len(stamps), dtype=bool)
    i = last[-1]
    while i >= 0:
        keep[i] = True
        i = int(before[i])
    return keep


def _delay(stamps: Stamps, arrival: Stamps) -> Delay:
    late = (arrival - stamps).astype(np.float64) * 1e-9
    tenth = max(1, len(late) // 10)
    drift = float(np.median(late[-tenth:]) - np.median(late[:tenth]))
    size = max(LEAST_BLOCK, len(late) // BLOCKS)
    whole = late[: len(late) // size * size].reshape(-1, size)
    step = step_at = 0.0
    if len(whole) > 1:
        medians = np.median(whole, axis=1)
        spread = float(
            np.median(np.percentile(whole, 90, axis=1) - np.percentile(whole, 10, axis=1))
        )
        change = np.diff(medians)
        k = int(np.argmax(np.abs(change)))
        if abs(change[k]) > max(STEP, 4.0 * spread):
            window = late[k * size : (k + 2) * size]
            at = k * size + int(np.argmax(np.abs(np.diff(window)))) + 1
            step, step_at = float(change[k]), float((arrival[at] - arrival[0]) * 1e-9)
    return Delay(float(late.min()), float(np.median(late)), float(late.max()), drift, step, step_at)
