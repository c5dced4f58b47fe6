# SPDX-License-Identifier: MIT
"""Pauses of the recorder between two files of a bag: a command that was sent then is lost.

Commands that are sent on change, as by a joypad, hold until the next one. Over a pause they may have changed, so
they are unknown from it to the next message.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.io.bags.bag import LATEST, Bag
from seatrial.io.signals import Rows
from seatrial.util.format import times
from seatrial.util.frames import Stamps

LOST = 3.0  # periods of the busiest topic, without any message: two of its own are lost at least
LEAST_PAUSE = 0.1  # [s] a recorder that closes a file may be late by less, and lose nothing
Pause = tuple[int, int]  # [ns] arrival of the last message before it and of the first one behind it


def pauses(bag: Bag) -> list[Pause]:
    """Those between the files, in their order; none where the bag does not state the times of its files."""
    most = max((topic.messages for topic in bag.topics.values()), default=0)
    length = sum(end - begin for begin, end in bag.spans)
    stated = all(0 <= begin <= end <= LATEST for begin, end in bag.spans)  # else they are damaged
    if len(bag.spans) < 2 or not stated or length == 0 or most == 0:
        return []
    least = max(LOST * length / most, 1e9 * LEAST_PAUSE)
    ends, begins = [end for _, end in bag.spans[:-1]], [begin for begin, _ in bag.spans[1:]]
    return [one for one in zip(ends, begins, strict=True) if one[1] - one[0] > least]


def with_unknown_commands(rows: Rows, arrival: Stamps, found: Sequence[Pause]) -> Rows:
    """Commands with a row that is no number behind the last one before each pause. arrival (n,) [ns]."""
    late = int(np.median(arrival - rows.stamps))
    # stamps of another clock may be anything
    found = [one for one in found if 0 <= one[0] - late < LATEST]
    stamps, values = rows.stamps, rows.values
    paused = [end - late + 1 for end, _ in found]
    for stamp in paused:
        after = int(np.searchsorted(stamps, stamp, side="left"))
        stamps = np.insert(stamps, after, stamp)
        values = np.insert(values, after, np.nan, axis=0)
    return replace(rows, stamps=stamps, values=values, paused=tuple(paused))


def pause_remarks(bag: Bag, found: Sequence[Pause]) -> tuple[str, ...]:
    """What is done about them."""
    if not found:
        return ()
    longest = 1e-9 * max(begin - end for end, begin in found)
    return (
        f"between its {len(bag.spans)} files the recorder lost messages {times(len(found))}, for up to "
        f"{longest:.2g} s: poses from there to the next command are left out, as a command may be lost, too",
    )
