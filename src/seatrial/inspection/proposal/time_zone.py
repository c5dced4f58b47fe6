# SPDX-License-Identifier: MIT
"""Stamps of poses and commands in two time zones: the offset that brings them together, as a proposal."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from seatrial.inspection.proposal.sources import Sources
from seatrial.io.bags.opening import is_bag
from seatrial.io.formats import is_log
from seatrial.io.tables.stamps import TO_NANOSECONDS

CLOCK = "clock"  # key of the note


def in_one_zone(sources: Sources, apart: float) -> Iterator[Sources]:
    """The sources with the stamps of the commands corrected, else with those of the poses; of tables alone.

    apart [s]: commands after poses. Stamps that are written as dates and times take no offset: reading shows it.
    """
    if CLOCK in sources.notes or is_bag(sources.path) or is_log(sources.path):
        return
    side = "ahead of" if apart > 0 else "behind"
    found = f"the clock of the commands is {abs(apart) / 3600:g} h {side} that of the poses, another time zone"
    for key, late in (("commands", apart), ("pose", -apart)):
        spec = getattr(sources, key)
        stamp = _less(spec["stamp"], late)
        note = f"{found}: offset {stamp['offset']:.15g} written to {key}: stamp; check"
        yield replace(
            sources, **{key: spec | {"stamp": stamp}}, notes={**sources.notes, CLOCK: [note]}
        )


def _less(stamp: dict[str, Any], seconds: float) -> dict[str, Any]:
    """The column of stamps, whose values become less by so many seconds."""
    second = 1e9 / TO_NANOSECONDS.get(stamp.get("unit", "s"), 1e9) * stamp.get("scale", 1.0)
    offset = stamp.get("offset", 0.0) + stamp.get("sign", 1) * seconds * second
    return {**stamp, "offset": offset}
