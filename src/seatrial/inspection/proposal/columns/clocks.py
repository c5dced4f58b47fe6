# SPDX-License-Identifier: MIT
"""Stamps of the poses by the clock of the commands, where a table has two columns of stamps."""

import numpy as np

from seatrial.inspection.proposal.columns.stamps import StampFound, given_stamp
from seatrial.inspection.proposal.columns.yaw_rate import seconds_of
from seatrial.inspection.proposal.sources import Sureness
from seatrial.io.columns import TableSeen
from seatrial.util.errors import RecordingError

ZONES = 26 * 3600.0  # [s] by which clocks in two time zones may differ
DATES = (
    1e9  # [s] since 1970, above which stamps are dates: no clock counts from a start for 31 years
)


def by_clock_of(
    poses: TableSeen, stamp: StampFound, commands: TableSeen, other: StampFound
) -> StampFound:
    """The stamps of the poses that overlap those of the commands, or come nearest: dates, or within time zones."""
    if stamp.sure is Sureness.CHOSEN or poses is commands:
        return stamp
    driven = _span(commands, other)
    best, apart = stamp, _apart(_span(poses, stamp), driven)
    for name in stamp.others if apart > 0.0 else ():
        try:
            found = given_stamp(poses, name)
            span = _span(poses, found)
            away = _apart(span, driven)
        except RecordingError:
            continue
        most = apart if min(span[0], driven[0]) > DATES else min(apart, ZONES)
        if away < most:
            why = f"nearest to the stamps of the commands; by {stamp.entry['column']} they are {apart:.4g} s apart"
            best, apart = StampFound(found.entry, why, Sureness.LIKELY, stamp.others), away
    return best


def _span(table: TableSeen, stamp: StampFound) -> tuple[float, float]:
    """The first and the last stamp [s]."""
    t = seconds_of(table, stamp)
    t = t[np.isfinite(t)]
    return (float(t.min()), float(t.max())) if len(t) else (np.nan, np.nan)


def _apart(one: tuple[float, float], other: tuple[float, float]) -> float:
    """[s] between two spans; 0 where they overlap."""
    return max(0.0, one[0] - other[1], other[0] - one[1])
