# SPDX-License-Identifier: MIT
"""How a signal arrived: its rate and gaps, and what its clock has to do with the recorder's."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from seatrial.util.frames import Array, Mask, Stamps

FEW = 20  # steps, of which no rhythm can be seen
SILENCE = 10.0  # a hole in a rhythm is longer than this many periods ...
SHORTEST_SILENCE = 0.5  # [s] ... and than this
REPEATED = 0.1  # share of rows like the one before that a log of changes has at most: of buttons
GOES_ON = 0.15  # of its spread that a command changes by after a rest
BLOCKS = 40  # that a recording is cut into to look for steps of its clock
LEAST_BLOCK = 10  # messages
NEAR = 5  # blocks to either side that a step is measured with,
LASTING = 3  # and so many are needed: a queue that empties late is no step
CLEAN = 0.8  # share of a step by which all blocks before and after it are apart
STEP = 0.05  # [s] a clock that is set moves by more than this
STRAY = 10.0  # [s] a stamp that is further off from those around it says nothing of the clock
SURE = 4.0  # a drift is more than this many times what transport makes of it


class Clock(str, Enum):
    """Where stamps come from."""

    HEADER = "header"
    ARRIVAL = "arrival in the bag"  # asked for, or the message has no header
    ZERO = "arrival in the bag, as its headers hold no time"
    COLUMN = "column of the table"


@dataclass(frozen=True)
class Delay:
    """Arrival in the bag minus stamp: transport, plus what the clocks are apart.

    A clock that is ahead makes it negative, one that runs fast or is set forward makes it fall.
    """

    least: float  # [s] stray stamps aside
    median: float  # [s]
    most: float  # [s]
    drift: float  # [s] from the first tenth to the last, steps aside; 0: none to be seen
    step: float  # [s] largest sudden change that lasts; 0: none
    step_at: float  # [s] from the first message
    step_stamp: int  # [ns] last stamp before it

    def __str__(self) -> str:
        """Least and most, in words."""
        low, high = self.least, self.most
        if high < 0:
            return f"{_span(-high, -low)} after arrival"
        if low < -0.0005:
            return f"{time_text(-low)} after to {time_text(high)} before arrival"
        return f"{_span(max(low, 0.0), high)} before arrival"


@dataclass(frozen=True)
class Stream:
    """One topic or table as it was recorded."""

    role: str  # poses, commands, scales
    source: str  # topic, or file
    kind: str  # message type, or table
    clock: Clock
    count: int
    rate: float  # [Hz] by the median step; 0 with fewer than two stamps
    longest: float  # [s] longest step
    jitter: float  # [s] standard deviation of the steps, gaps aside
    duplicated: int  # stamps equal to the one before
    backward: int  # stamps before the one before
    on_change: bool  # written when something changed rather than in a rhythm
    delay: Delay | None = None  # where both stamp and arrival are known
    publishers: int = 1
    cut: bool = False  # the recording is a part of this, which is counted whole


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
        int((steps == 0).sum()), int((steps < 0).sum()), beat(forward) is None, delay, publishers,
    )  # fmt: skip


def beat(steps: Array) -> float | None:
    """Period of a rhythm [s]; None if steps [s] have none. Bursts at even times are one, too."""
    if len(steps) < FEW:
        return None
    middle, high, top = (float(x) for x in np.percentile(steps, [50, 90, 98]))
    if high < 2.0 * middle:
        return middle
    return high if top < 1.3 * high else None


def only_changes(t: Array, values: Array) -> bool:
    """Whether rows (n, inputs) at t (n,) [s] were written when something changed: silence is rest.

    Either they have no rhythm, or no row is like the one before, and after a silence the values
    go on from where they were.
    """
    steps = np.diff(t)
    period = beat(steps)
    if period is None:
        return True
    silent = steps > silence(period)
    change = np.abs(np.diff(values, axis=0))
    repeated = float((change == 0).all(axis=1).mean())
    if not silent.any() or repeated > REPEATED:
        return False
    spread = np.maximum(values.std(axis=0), 1e-300)
    return float(np.median((change[silent] / spread).max(axis=1))) < GOES_ON


def silence(period: float) -> float:
    """How long a rhythm must be silent for a hole [s]."""
    return max(SILENCE * period, SHORTEST_SILENCE)


def longest_rising(stamps: Stamps, *, strict: bool = True) -> Mask:
    """The most stamps (n,) that can be kept so that those kept rise.

    One stamp far ahead of its time is left out, rather than all that follow it. Where either of
    two may stay, it is the one that keeps the rhythm.
    """
    steps = np.diff(stamps)
    if np.all(steps > 0 if strict else steps >= 0):
        return np.ones(len(stamps), dtype=bool)
    longest = _longest(stamps, strict=strict)
    even = np.flatnonzero(_without_odd(stamps, steps, strict=strict))
    even = even[_longest(stamps[even], strict=strict)]
    chosen = even if len(even) >= len(longest) else longest
    keep = np.zeros(len(stamps), dtype=bool)
    keep[chosen] = True
    return keep


def _longest(stamps: Stamps, *, strict: bool) -> NDArray[np.int64]:
    """Indices of a longest rising choice."""
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
    chosen = []
    i = last[-1]
    while i >= 0:
        chosen.append(i)
        i = int(before[i])
    return np.array(chosen[::-1], dtype=np.int64)


def _without_odd(stamps: Stamps, steps: Stamps, *, strict: bool) -> Mask:
    """All but the worse of each two neighbours of which one must go and either could."""
    period = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
    i = np.flatnonzero(steps <= 0 if strict else steps < 0)
    i = i[(i >= 1) & (i + 2 < len(stamps))]
    i = i[(stamps[i + 1] > stamps[i - 1]) & (stamps[i] < stamps[i + 2])]
    late, early = (np.abs(s - period) for s in (steps[i - 1], steps[i + 1]))
    keep = np.ones(len(stamps), dtype=bool)
    keep[np.where(late <= early, i + 1, i)] = False
    return keep


def rhythm(stream: Stream) -> str:
    """Its rate in words."""
    if not stream.on_change or stream.count < FEW:
        return f"{stream.rate:.4g} Hz"
    return f"{stream.rate:.4g} Hz{' unevenly' if stream.role == 'poses' else ' while it changes'}"


def time_text(seconds: float) -> str:
    """In ms; from 10 s on in seconds."""
    return f"{seconds:.6g} s" if seconds >= 10.0 else f"{1e3 * seconds:.0f} ms"


def _delay(stamps: Stamps, arrival: Stamps) -> Delay:
    late = (arrival - stamps).astype(np.float64) * 1e-9
    size = max(1, min(len(late), max(LEAST_BLOCK, len(late) // BLOCKS)))
    whole = np.sort(late[: len(late) // size * size].reshape(-1, size), axis=1)
    medians = whole[:, size // 2]
    spread = float(np.median(whole[:, size * 9 // 10] - whole[:, size // 10]))
    block = np.minimum(np.arange(len(late)) // size, len(medians) - 1)
    sane = np.abs(late - medians[block]) < STRAY
    at, step = _step(stamps, arrival, late, medians, max(STEP, SURE * spread))
    level = late - np.where(np.arange(len(late)) >= at, step, 0.0)
    return Delay(
        float(late[sane].min()), float(np.median(late)), float(late[sane].max()),
        _drift(level, spread), step,
        float((arrival[at] - arrival[0]) * 1e-9) if step else 0.0, int(stamps[at - 1]) if step else 0,
    )  # fmt: skip


def _step(
    stamps: Stamps, arrival: Stamps, late: Array, medians: Array, least: float
) -> tuple[int, float]:
    """First message after the largest lasting change of the delay, and the change [s]; 0, 0: none."""
    n = len(medians)
    if n < 2:
        return 0, 0.0
    slope = float(np.median(np.diff(medians))) if n > 2 * LASTING else 0.0
    flat = medians - slope * np.arange(n)
    change = np.array(
        [np.median(flat[k : k + NEAR]) - np.median(flat[max(0, k - NEAR) : k]) for k in range(1, n)]
    )
    k = int(np.argmax(np.abs(change))) + 1
    if abs(change[k - 1]) < least:
        return 0, 0.0
    size = len(late) // n
    begin, end = max(0, k - NEAR) * size, min(n, k + NEAR) * size
    near = late[begin:end] - slope * np.arange(begin, end) / size
    middle = k * size - begin
    off = [np.abs(near - np.median(part)) for part in (near[:middle], near[middle:])]
    nearer = np.cumsum(off[0] - off[1])
    i = int(np.argmin(nearer[:-1])) + 1
    step, at = float(np.median(near[i:]) - np.median(near[:i])), begin + i
    if abs(step) < least:
        return 0, 0.0
    rising = np.sign(step) * flat
    before, after = rising[: at // size][-NEAR:], rising[-(-at // size) :][:NEAR]
    apart = float(after.min() - before.max()) if min(len(before), len(after)) >= LASTING else 0.0
    # else it must be seen in the stamps, not in when the messages came
    odd = [abs(int(s[at] - s[at - 1]) - float(np.median(np.diff(s)))) for s in (stamps, arrival)]
    return (at, step) if apart > CLEAN * abs(step) or odd[0] > odd[1] else (0, 0.0)


def _drift(late: Array, spread: float) -> float:
    """Change of the least delays from the first tenth to the last [s]; 0 if transport explains it."""
    tenth = max(1, len(late) // 10)
    first, last = np.percentile(late[:tenth], 10), np.percentile(late[-tenth:], 10)
    drift = float(last - first)
    return drift if abs(drift) > SURE * spread / np.sqrt(tenth) else 0.0


def _span(low: float, high: float) -> str:
    """Two times [s] that are not negative, as one where they are alike."""
    (small, unit), (large, other) = (time_text(x).split() for x in (low, high))
    if unit == other:
        return f"{small} {unit}" if small == large else f"{small} to {large} {unit}"
    return f"{small} {unit} to {large} {other}"
