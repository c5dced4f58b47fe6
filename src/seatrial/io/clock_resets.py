# SPDX-License-Identifier: MIT
"""A log whose clock is set back, as where a logger starts again: what follows is a drive of its own.

All signals go back in time as often. Each part keeps its own times, behind the one before and a pause; commands
are unknown in the pause, as between two files of a bag.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from seatrial.io.copies import copies_in
from seatrial.io.signals import Request, Rows
from seatrial.util.format import times
from seatrial.util.frames import Stamps

PAUSE = round(10e9)  # [ns] between two parts: more than latency and lag
ROWS = 10  # to either side of a reset, all earlier than all: a few wrong stamps are no reset
LEAST_PART = 10e9  # [ns] of a drive
LATEST = np.iinfo(np.int64).max // 2  # [ns] of a stamp that can be moved
# of the poses of times that are there before: a block that is written twice goes back, too
MOST_COPIES = 0.1


def apart_by_resets(
    read: Sequence[Rows], requests: Sequence[Request]
) -> tuple[list[Rows], tuple[str, ...]]:
    """The rows with parts one after the other, and a remark; unchanged where the signals do not agree."""
    begins = [_begins(rows.stamps) for rows in read]
    count = len(begins[0]) - 1
    poses = [rows for rows, one in zip(read, requests, strict=True) if one.role == "poses"]
    alike = count > 0 and all(len(each) == count + 1 for each in begins)
    if not alike or any(_is_written_twice(rows) for rows in poses):
        return list(read), ()
    parts = [np.split(r.stamps, each[1:]) for r, each in zip(read, begins, strict=True)]
    shifts, ends = [0], []
    for i in range(count):
        ends.append(max(int(own[i].max()) for own in parts) + shifts[i])
        shifts.append(ends[i] + PAUSE - min(int(own[i + 1].min()) for own in parts))
    if ends[-1] > LATEST or max(shifts) > LATEST:
        return list(read), ()
    back = 1e-9 * max(b - a - PAUSE for a, b in pairwise(shifts))
    text = (
        f"stamps go back in time {times(count)}, by {back:.3g} s or less (a logger that was started again, or "
        f"a clock that was set): read as {count + 1} drives, one after the other"
    )
    return [
        _moved(rows, own, shifts, ends if request.role == "commands" else ())
        for rows, own, request in zip(read, parts, requests, strict=True)
    ], (text,)


def _begins(stamps: Stamps) -> list[int]:
    """Rows where a part begins, 0 the first; only that where a part is short, or few stamps are wrong."""
    begins = [0]
    for i in (np.flatnonzero(np.diff(stamps) < 0) + 1).tolist():
        before, after = stamps[max(begins[-1], i - ROWS) : i], stamps[i : i + ROWS]
        if after.max() < before.min():
            begins.append(i)
    lengths = [np.ptp(part) if len(part) else 0 for part in np.split(stamps, begins[1:])]
    return begins if min(lengths) >= LEAST_PART else [0]


def _is_written_twice(rows: Rows) -> bool:
    """Whether what goes back in time are copies."""
    before = np.maximum.accumulate(rows.stamps)
    again = np.count_nonzero(rows.stamps[1:] <= before[:-1])
    return bool(copies_in(rows).sum() > MOST_COPIES * again)


def _moved(rows: Rows, parts: Sequence[Stamps], shifts: Sequence[int], ends: Sequence[int]) -> Rows:
    """The rows with shifted parts, and at each end a row that is no number."""
    stamps = np.concatenate([part + shift for part, shift in zip(parts, shifts, strict=True)])
    values, at = rows.values, np.cumsum([len(part) for part in parts[:-1]])
    stream = replace(rows.stream, backward=max(0, rows.stream.backward - len(shifts) + 1))
    if len(ends):
        paused = [end + 1 for end in ends]
        stamps = np.insert(stamps, at, paused)
        values = np.insert(values, at, np.nan, axis=0)
        rows = replace(rows, paused=(*rows.paused, *paused))
    return replace(rows, stamps=stamps, values=values, stream=stream)
