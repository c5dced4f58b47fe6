# SPDX-License-Identifier: MIT
"""Axes of a recording: what the log shows of them, and a question that its user can answer."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from seatrial.inspection.proposal.columns.heading import is_compass
from seatrial.inspection.proposal.columns.pose import heading_and_sense
from seatrial.inspection.proposal.columns.signals import positions
from seatrial.inspection.proposal.sources import Ask, Choices
from seatrial.io.bags.opening import is_bag
from seatrial.io.columns import read_tables
from seatrial.io.formats import is_log
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Axes

TURN_QUESTION = "The boat turns to the left (to port). What does {heading} do?"
HEADING_OF_LOG = "the heading of the log"
RISES = "it rises: counter-clockwise, as in ROS and mathematics"
FALLS = "it falls: clockwise, as a compass"


@dataclass(frozen=True)
class HeadingSeen:
    """The heading of a table, as its name, values and the motion of the boat show it."""

    text: str  # how a question names it
    # whether it rises from x towards y; a compass rises from y (north) to x (east)
    from_x_to_y: bool
    compass: bool  # whether it looks as if it rose clockwise
    # whether east and north are known, or the axes are right-handed with a known one up
    known_axes: bool


def asked_axes(path: Path, choices: Choices, ask: Ask | None) -> str:
    """The axes of an autopilot, of east and north, or of motion capture; else by the answer of `ask`; without it
    the usual ones.

    No other log shows whether y points to port or to starboard: a world and its mirror image fit the same numbers.
    The sense in which the heading turns decides it, together with that in which x leads to y.
    """
    if is_log(path):
        return Axes.FRD.value
    if ask is None:
        return Axes.FLU.value
    seen = heading_seen(path, choices)
    if _only_captures(path) if seen is None else seen.known_axes:
        return Axes.FLU.value
    options = (FALLS, RISES) if seen is not None and seen.compass else (RISES, FALLS)
    heading = HEADING_OF_LOG if seen is None else seen.text
    rises = ask(TURN_QUESTION.format(heading=heading), options) == RISES
    y_to_port = rises == (seen is None or seen.from_x_to_y)
    return Axes.FLU.value if y_to_port else Axes.FRD.value


def heading_seen(path: Path, choices: Choices) -> HeadingSeen | None:
    """The heading of a table; None of a bag, or where its columns are not clear."""
    if is_bag(path):
        return None
    try:
        position, heading, sense = heading_and_sense(path, read_tables(path), choices)
    except RecordingError:
        return None
    clockwise = sense is not None and sense.sign < 0
    return HeadingSeen(
        heading.in_question,
        not clockwise,
        clockwise or (is_compass(heading) and float(np.nanmin(heading.values)) >= 0.0),
        position.east_north is not None or position.right_handed,
    )


def _only_captures(path: Path) -> bool:
    """Whether all positions, of whichever body, are those of motion capture."""
    if is_bag(path):
        return False
    try:
        found = positions(read_tables(path))
    except RecordingError:
        return False
    return bool(found) and all(position.right_handed for position in found)
