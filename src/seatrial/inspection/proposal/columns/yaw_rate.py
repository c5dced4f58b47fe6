# SPDX-License-Identifier: MIT
"""A yaw rate among the columns: the derivative of the heading, with its sign and unit."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from seatrial.boat.schema import TO_SI, Column
from seatrial.inspection.proposal.columns.heading import Psi
from seatrial.inspection.proposal.columns.heading_sense import rate_factor
from seatrial.inspection.proposal.columns.signals import (
    LEAST_CORRELATION,
    Heading,
    column_of,
    is_gyro,
    shown,
    yaw_rates,
)
from seatrial.inspection.proposal.columns.stamps import StampFound, find_stamp
from seatrial.inspection.proposal.sources import Recognised, Sureness
from seatrial.io.columns import Tables, TableSeen
from seatrial.util.frames import Array

YawRate = tuple[TableSeen, str, dict[str, Any], Recognised]  # the last: how it was recognised
RATE_SLACK = 0.3  # of a slope of 1, of a yaw rate in the unit that is tried


def seconds_of(table: TableSeen, found: StampFound) -> Array:
    """Stamps (n,) [s]; NaN where a row has none."""
    column = Column(**found.entry)
    rows = np.ones(len(table.values), dtype=bool)
    if np.isfinite(table.numbers(column.column)).any():
        rows = np.isfinite(table.numbers(column.column))
    out = np.full(len(rows), np.nan)
    out[rows] = table.table.stamps(column, rows) * 1e-9
    return out


def find_yaw_rate(
    path: Path, tables: Tables, heading: Heading, psi: Psi, given: Mapping[str, str]
) -> YawRate | None:
    """A yaw rate that agrees with the heading: of a gyro it is used, another is mentioned."""
    if "yaw_rate" in given:
        pairs = [column_of(path, tables, given["yaw_rate"], "--pose")]
    else:
        pairs = [(t, n) for t in tables for n in yaw_rates(t)]
        pairs.sort(key=lambda pair: not is_gyro(pair[1]))
    stamp = find_stamp(heading.table)
    if stamp is None:
        return None
    for table, name in pairs:
        entry = _rate_entry(table, name, heading, psi, stamp)
        if entry is None and "yaw_rate" not in given:
            continue
        sure, why = Sureness.CERTAIN, "name; it is the derivative of the heading, and of a gyro"
        if "yaw_rate" in given:
            sure, why = Sureness.CHOSEN, "--pose"
        elif not is_gyro(name):
            sure = Sureness.GUESS
            why = "check: of a gyro it adds information; of a filter leave it out"
        others = tuple(n for _, n in pairs if n != name)
        found = Recognised("yaw rate", shown(table, name), why, sure, others)
        return table, name, entry or {"column": name}, found
    return None


def _rate_entry(
    table: TableSeen, name: str, heading: Heading, psi: Psi, stamp: StampFound
) -> dict[str, Any] | None:
    """Sign and unit of a yaw rate by the heading; None where it is not its derivative."""
    at = seconds_of(heading.table, stamp)
    values = heading.values * TO_SI[psi.entry.get("unit", "rad")] * psi.entry.get("sign", 1)
    rate = table.numbers(name)
    if table is not heading.table:
        own = find_stamp(table)
        if own is None:
            return None
        there = seconds_of(table, own)
        good = np.isfinite(there) & np.isfinite(rate)
        if not good.any() or np.any(np.diff(there[good]) < 0):
            return None
        rate = np.interp(at, there[good], rate[good], left=np.nan, right=np.nan)
    slope, correlation = rate_factor(at, values, rate)
    if abs(correlation) < LEAST_CORRELATION:
        return None
    for unit in ("rad", "deg"):
        if abs(abs(slope) / TO_SI[unit] - 1) < RATE_SLACK:
            entry: dict[str, Any] = {"column": name} | ({"unit": unit} if unit == "deg" else {})
            return entry | ({"sign": -1} if slope < 0 else {})
    return None
