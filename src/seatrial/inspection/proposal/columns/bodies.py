# SPDX-License-Identifier: MIT
"""Which of several rigid bodies of a motion capture is the boat."""

from pathlib import Path

import numpy as np

from seatrial.inspection.proposal.columns.names import read_name
from seatrial.io.columns import Tables, TableSeen
from seatrial.io.tables.capture_table import PLACES
from seatrial.util.errors import RecordingError

BOAT_WORDS = frozenset(
    ("boat", "vessel", "ship", "usv", "asv", "vehicle", "robot", "catamaran", "hull")
)
FARTHER = 5.0  # times as far as any other body


def likeliest_body(tables: Tables) -> TableSeen | None:
    """The only one that is named as a boat, else the one that moves much farther than the others; None: neither.

    None also where one of the tables is no body of a motion capture.
    """
    if not all(table.table.captured for table in tables):
        return None
    named = [t for t in tables if BOAT_WORDS.intersection(read_name(t.table.name).words)]
    if len(named) == 1:
        return named[0]
    far = sorted(tables, key=_extent)
    return far[-1] if _extent(far[-1]) > FARTHER * _extent(far[-2]) else None


def refuse_takes(path: Path, tables: Tables) -> None:
    """Raise RecordingError where the bodies are in several files: takes, one after the other."""
    takes = list(dict.fromkeys(t.table.path.name for t in tables))
    if len(takes) > 1 and all(t.table.captured for t in tables):
        raise RecordingError(
            f"{path}: {len(takes)} takes: {', '.join(takes)}; put each into a folder of its own with the "
            "commands, and give all folders; or name the only one with the boat, --pose TABLE"
        )


def _extent(table: TableSeen) -> float:
    """[m] along the axis on which the body moves farthest."""
    places = np.column_stack([table.numbers(name) for name in PLACES])
    places = places[np.isfinite(places).all(axis=1)]
    return float(np.ptp(places, axis=0).max()) if len(places) else 0.0
