# SPDX-License-Identifier: MIT
"""Stamps of the poses by the clock of the commands, where a table has two columns of stamps."""

import numpy as np

from seatrial.inspection.proposal.columns.names import read_name
from seatrial.inspection.proposal.columns.stamps import (
    TIME_UNITS,
    StampFound,
    find_stamp,
    given_stamp,
)
from seatrial.inspection.proposal.columns.yaw_rate import seconds_of
from seatrial.inspection.proposal.sources import Sureness
from seatrial.io.columns import PER_SECOND, TableSeen
from seatrial.recording.other_clock import FACTOR_SLACK
from seatrial.util.errors import RecordingError

ZONES = 26 * 3600.0  # [s] by which clocks in two time zones may differ
# [s] since 1970, above which stamps are dates: no clock counts from a start for 31 years
DATES = 1e9


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


def stamp_beside(table: TableSeen, main: TableSeen, stamp: StampFound) -> StampFound | None:
    """The stamps of another table by the clock of the main one: of the same name, else those that overlap."""
    own = find_stamp(table)
    if own is None:
        return None
    if stamp.entry["column"] in own.others:
        return given_stamp(table, stamp.entry["column"])
    return by_clock_of(table, own, main, stamp)


def as_long_as(
    poses: TableSeen, of_poses: StampFound, commands: TableSeen, stamp: StampFound
) -> StampFound:
    """The stamps of the commands, in a larger unit where they last as long as the poses in it.

    By their rate the unit is too small where a row is a change, and changes are seconds apart.
    """
    if poses is commands or stamp.sure is Sureness.CHOSEN or read_name(stamp.entry["column"]).unit:
        return stamp
    length, own = (float(np.ptp(_span(*one))) for one in ((poses, of_poses), (commands, stamp)))
    given = stamp.entry.get("unit", "s")
    for unit in TIME_UNITS[: TIME_UNITS.index(given)] if given in TIME_UNITS else ():
        longer = own * PER_SECOND[given] / PER_SECOND[unit]
        if abs(longer - length) < FACTOR_SLACK * length:
            entry = {"column": stamp.entry["column"]} | ({} if unit == "s" else {"unit": unit})
            why = f"name; they last as long as the poses in {unit}"
            return StampFound(entry, why, Sureness.LIKELY, stamp.others)
    return stamp


def _span(table: TableSeen, stamp: StampFound) -> tuple[float, float]:
    """The first and the last stamp [s]."""
    t = seconds_of(table, stamp)
    t = t[np.isfinite(t)]
    return (float(t.min()), float(t.max())) if len(t) else (np.nan, np.nan)


def _apart(one: tuple[float, float], other: tuple[float, float]) -> float:
    """[s] between two spans; 0 where they overlap."""
    return max(0.0, one[0] - other[1], other[0] - one[1])
