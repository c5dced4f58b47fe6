# SPDX-License-Identifier: MIT
"""Timing of signals: rate, gaps, order of stamps; offset, drift and steps of their clock."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from enum import Enum

import numpy as np

from seatrial.util.frames import Array, Index, Mask, Stamps

FEW_STEPS = 20  # steps; fewer show no period
REGULAR = 2.0  # medians, limit of the 90th percentile of the steps of a regular log
BURSTS = 1.3  # 98th over 90th percentile of the steps of regular bursts, at most
CONSECUTIVE = 1.5  # periods; a longer step is a gap and no jitter
SILENT_PERIODS = 10.0  # periods, least length of a hole in a periodic log
SHORTEST_SILENCE = 0.5  # [s] the same
# of the rows, equal to the one before, at most in a log on change (button messages)
REPEATED_SHARE = 0.1
RESUMED_SHARE = 0.15  # of its spread, change of a command over a silence in a log on change
DELAY_BLOCKS = 40  # of a recording, whose median delays show steps of the clock
LEAST_BLOCK_MESSAGES = 10  # in a block
STEP_BLOCKS = 5  # blocks on either side that measure a step of the clock
STEP_LASTING_BLOCKS = 3  # least blocks on either side: a queue that empties late is no step
STEP_SEPARATION = 0.8  # of a step, distance between all blocks before and after it
LEAST_CLOCK_STEP = 0.05  # [s] least step of a clock that is set
STRAY_DELAY = 10.0  # [s] from the block's median: a stray stamp, no property of the clock
STREAM_HEAD = ("messages", "rate", "longest gap")  # of a table of streams
TRANSPORT_SPREADS = 4.0  # of the transport delay, least size of a significant step or drift


class Clock(str, Enum):
    """Source of the stamps."""

    HEADER = "header"
    ARRIVAL = "arrival in the bag"  # chosen in the vehicle file, or the message has no header
    ZERO = "arrival in the bag, as its headers hold no time"
    TRANSFORMS = "headers of its transforms"
    COLUMN = "column of the table"
    LOG = "message of the log"


@dataclass(frozen=True)
class Delay:
    """Arrival in the bag minus stamp: transport plus offset of the clocks.

    A clock that is ahead makes it negative. A fast clock, or one set forward, makes it fall.
    """

    least: float  # [s] stray stamps aside
    median: float  # [s]
    most: float  # [s]
    drift: float  # [s] from the first tenth to the last, without steps; 0: not significant
    step: float  # [s] largest lasting step; 0: none
    step_at: float  # [s] from the first message
    step_stamp: int  # [ns] last stamp before it

    def __str__(self) -> str:
        """Range as text."""
        low, high = self.least, self.most
        if high < 0:
            return f"{_span(-high, -low)} after arrival"
        if low < -0.0005:
            return f"{time_text(-low)} after to {time_text(high)} before arrival"
        return f"{_span(max(low, 0.0), high)} before arrival"


@dataclass(frozen=True)
class Stream:
    """One topic or table as recorded."""

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
    on_change: bool  # written on change rather than periodically
    delay: Delay | None = None  # where both stamp and arrival are known
    publishers: int = 1
    cut: bool = False  # the recording is a part; counts are of the whole stream


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
    """A stream from its stamps (n,) [ns] in the order of the file, and their arrival."""
    steps = np.diff(stamps).astype(np.float64) * 1e-9
    forward = steps[steps > 0]
    period = float(np.median(forward)) if len(forward) else 0.0
    near = forward[forward < CONSECUTIVE * period]
    delay = None
    if arrival is not None and clock is Clock.HEADER and len(stamps):
        delay = _delay(stamps, arrival)
    return Stream(
        role, source, kind, clock, len(stamps), 1.0 / period if period else 0.0,
        float(forward.max()) if len(forward) else 0.0,
        float(np.std(near)) if len(near) else 0.0,
        int((steps == 0).sum()), int((steps < 0).sum()), regular_period(forward) is None, delay, publishers,
    )  # fmt: skip


def regular_period(steps: Array) -> float | None:
    """Period [s] of regular steps [s]; None if they are irregular. Regular bursts have a period, too."""
    if len(steps) < FEW_STEPS:
        return None
    middle, high, top = (float(x) for x in np.percentile(steps, [50, 90, 98]))
    if high < REGULAR * middle:
        return middle
    return high if top < BURSTS * high else None


def only_changes(t: Array, values: Array) -> bool:
    """Whether rows (n, inputs) at t (n,) [s] are a log on change: silence means no change.

    Either the steps are irregular; or no row repeats the one before, and after a silence the values
    continue from where they were.
    """
    steps = np.diff(t)
    period = regular_period(steps)
    if period is None:
        return True
    silent = steps > silence_length(period)
    change = np.abs(np.diff(values, axis=0))
    repeated = float((change == 0).all(axis=1).mean())
    if not silent.any() or repeated > REPEATED_SHARE:
        return False
    spread = np.maximum(values.std(axis=0), 1e-300)
    return float(np.median((change[silent] / spread).max(axis=1))) < RESUMED_SHARE


def silence_length(period: float) -> float:
    """Least length [s] of a hole in a log with this period [s]."""
    return max(SILENT_PERIODS * period, SHORTEST_SILENCE)


def longest_rising(stamps: Stamps, *, strict: bool = True) -> Mask:
    """A longest rising selection (n,) of the stamps.

    One stamp far ahead is left out, rather than all that follow it. Where either of two could stay,
    the one nearer to the period stays.
    """
    steps = np.diff(stamps)
    if np.all(steps > 0 if strict else steps >= 0):
        return np.ones(len(stamps), dtype=bool)
    longest = _longest_rising_index(stamps, strict=strict)
    even = np.flatnonzero(_without_odd(stamps, steps, strict=strict))
    even = even[_longest_rising_index(stamps[even], strict=strict)]
    chosen = even if len(even) >= len(longest) else longest
    keep = np.zeros(len(stamps), dtype=bool)
    keep[chosen] = True
    return keep


def _longest_rising_index(stamps: Stamps, *, strict: bool) -> Index:
    """Indices of a longest rising subsequence (patience sorting)."""
    place = bisect_left if strict else bisect_right
    ends: list[int] = []  # smallest last stamp of a rising subsequence of each length
    last: list[int] = []  # index of that stamp
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
    """All stamps but the worse of each two neighbours of which either could be dropped."""
    period = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
    i = np.flatnonzero(steps <= 0 if strict else steps < 0)
    i = i[(i >= 1) & (i + 2 < len(stamps))]
    i = i[(stamps[i + 1] > stamps[i - 1]) & (stamps[i] < stamps[i + 2])]
    late, early = (np.abs(s - period) for s in (steps[i - 1], steps[i + 1]))
    keep = np.ones(len(stamps), dtype=bool)
    keep[np.where(late <= early, i + 1, i)] = False
    return keep


def rate_text(stream: Stream) -> str:
    """The rate as text."""
    if not stream.on_change or stream.count < FEW_STEPS:
        return f"{stream.rate:.4g} Hz"
    return f"{stream.rate:.4g} Hz{' unevenly' if stream.role == 'poses' else ' while it changes'}"


def stream_cells(stream: Stream) -> tuple[str, str, str]:
    """Cells of `STREAM_HEAD` in a table of streams."""
    timed = (rate_text(stream), f"{stream.longest:.3g} s") if stream.rate > 0.0 else ("", "")
    return str(stream.count), *timed


def time_text(seconds: float) -> str:
    """In ms; from 10 s on in seconds."""
    return f"{seconds:.6g} s" if seconds >= 10.0 else f"{1e3 * seconds:.0f} ms"


def _delay(stamps: Stamps, arrival: Stamps) -> Delay:
    late = (arrival - stamps).astype(np.float64) * 1e-9
    size = max(1, min(len(late), max(LEAST_BLOCK_MESSAGES, len(late) // DELAY_BLOCKS)))
    whole = np.sort(late[: len(late) // size * size].reshape(-1, size), axis=1)
    medians = whole[:, size // 2]
    spread = float(np.median(whole[:, size * 9 // 10] - whole[:, size // 10]))
    block = np.minimum(np.arange(len(late)) // size, len(medians) - 1)
    sane = np.abs(late - medians[block]) < STRAY_DELAY
    least = max(LEAST_CLOCK_STEP, TRANSPORT_SPREADS * spread)
    at, step = _step(stamps, arrival, late, medians, least)
    level = late - np.where(np.arange(len(late)) >= at, step, 0.0)
    return Delay(
        float(late[sane].min()), float(np.median(late)), float(late[sane].max()),
        _drift(level, spread), step,
        float((arrival[at] - arrival[0]) * 1e-9) if step else 0.0, int(stamps[at - 1]) if step else 0,
    )  # fmt: skip


def _step(
    stamps: Stamps, arrival: Stamps, late: Array, medians: Array, least: float
) -> tuple[int, float]:
    """First message after the largest lasting step of the delay, and the step [s]; 0, 0: none."""
    # 1. Between blocks: the largest change of the median delay, the trend removed.
    n = len(medians)
    if n < 2:
        return 0, 0.0
    slope = float(np.median(np.diff(medians))) if n > 2 * STEP_LASTING_BLOCKS else 0.0
    flat = medians - slope * np.arange(n)
    k, change = _largest_change(flat)
    if abs(change) < least:
        return 0, 0.0
    # 2. Within the blocks around it: the message that separates the two levels best.
    size = len(late) // n
    begin, end = max(0, k - STEP_BLOCKS) * size, min(n, k + STEP_BLOCKS) * size
    near = late[begin:end] - slope * np.arange(begin, end) / size
    i, step = _best_separation(near, k * size - begin)
    at = begin + i
    if abs(step) < least:
        return 0, 0.0
    # 3. The step must separate all blocks on both sides.
    rising = np.sign(step) * flat
    before, after = rising[: at // size][-STEP_BLOCKS:], rising[-(-at // size) :][:STEP_BLOCKS]
    lasting = min(len(before), len(after)) >= STEP_LASTING_BLOCKS
    if lasting and after.min() - before.max() > STEP_SEPARATION * abs(step):
        return at, step
    # 4. Otherwise it must be a step of the stamps, not of the arrivals.
    odd = [abs(int(s[at] - s[at - 1]) - float(np.median(np.diff(s)))) for s in (stamps, arrival)]
    return (at, step) if odd[0] > odd[1] else (0, 0.0)


def _largest_change(levels: Array) -> tuple[int, float]:
    """The block (of two or more) before which the level changes most, and the change."""
    changes = [
        np.median(levels[k : k + STEP_BLOCKS]) - np.median(levels[max(0, k - STEP_BLOCKS) : k])
        for k in range(1, len(levels))
    ]
    k = int(np.argmax(np.abs(changes)))
    return k + 1, float(changes[k])


def _best_separation(values: Array, middle: int) -> tuple[int, float]:
    """First value of the second of two levels that change near `middle`, and the step between them."""
    off = [np.abs(values - np.median(part)) for part in (values[:middle], values[middle:])]
    i = int(np.argmin(np.cumsum(off[0] - off[1])[:-1])) + 1
    return i, float(np.median(values[i:]) - np.median(values[:i]))


def _drift(late: Array, spread: float) -> float:
    """Change of the least delays from the first tenth to the last [s]; 0 if transport explains it."""
    tenth = max(1, len(late) // 10)
    first, last = np.percentile(late[:tenth], 10), np.percentile(late[-tenth:], 10)
    drift = float(last - first)
    return drift if abs(drift) > TRANSPORT_SPREADS * spread / np.sqrt(tenth) else 0.0


def _span(low: float, high: float) -> str:
    """Two times [s] >= 0 as a range; one time where they are equal as text."""
    (small, unit), (large, other) = (time_text(x).split() for x in (low, high))
    if unit == other:
        return f"{small} {unit}" if small == large else f"{small} to {large} {unit}"
    return f"{small} {unit} to {large} {other}"
