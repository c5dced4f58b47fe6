# SPDX-License-Identifier: MIT
"""The heading's entry in the vehicle file: unit, zero and sense, by name, values and motion."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from seatrial.boat.schema import TO_SI
from seatrial.inspection.proposal.columns.heading_sense import (
    COMPASS,
    MOST_RADIANS,
    PLAIN,
    Sense,
    by_motion,
    unit_of,
)
from seatrial.inspection.proposal.columns.names import Grade, read_name
from seatrial.inspection.proposal.columns.signals import Heading, Position, stated_unit
from seatrial.inspection.proposal.sources import Ask, Sureness
from seatrial.util.frames import Array, Axes

COMPASS_WORDS = ("compass", "heading", "hdg", "hdt", "azimuth", "kurs", "true", "magnetic", "ned")
EAST_QUESTION = "The boat points east. What does {heading} read?"
READS = {  # in the order of a compass
    "90 degrees: clockwise from north, as a compass": COMPASS,
    "0: counter-clockwise from east, as in ROS and mathematics": PLAIN,
}


@dataclass(frozen=True)
class Psi:
    """The heading's entry, and its values in the file's axes."""

    entry: dict[str, Any]
    values: Array  # (n,) [rad] psi
    sure: Sureness
    why: str


def psi_of(position: Position, heading: Heading, raw: Array, axes: Axes, ask: Ask | None) -> Psi:
    """Unit, sign and offset of the heading in the file's axes."""
    name = heading.names[0]
    unit, shown_unit = _unit(position, heading, raw)
    radians = raw * TO_SI[unit or "rad"]
    motion = sense_by_motion(position, heading, raw)
    sense, sure, why = _sense(position, heading, motion)
    geographic = position.east_north is not None
    if ask is not None and geographic and sure is not Sureness.CERTAIN:
        answers = sorted(READS, key=lambda text: READS[text] != sense)
        sense = READS[ask(EAST_QUESTION.format(heading=heading.in_question), answers)]
        sure, why = Sureness.CHOSEN, "answered"
    sign, offset = sense.sign, -sense.sign * sense.offset
    if axes is Axes.FRD and geographic:  # from north, clockwise
        sign, offset = -sense.sign, sense.sign * (90 - sense.offset)
    offset = (offset + 180) % 360 - 180
    entry: dict[str, Any] = {"column": name}
    if len(heading.names) > 1:
        entry = {"quaternion": list(heading.names)}
    if shown_unit:
        entry["unit"] = unit
    if heading.scale != 1.0:
        entry["scale"] = heading.scale
    if sign < 0:
        entry["sign"] = -1
    if offset:
        turned = offset if unit == "deg" else round(float(np.radians(offset)), 9)
        entry["offset"] = turned * heading.scale
    if heading.grade is Grade.PART:
        sure = Sureness.GUESS
    elif sure is Sureness.LIKELY and sense == PLAIN and unit_of(raw) and not is_compass(heading):
        sure, why = Sureness.CERTAIN, f"{why}; it wraps, in {unit}"
    return Psi(entry, sign * (radians - np.radians(offset)), sure, why)


def sense_by_motion(position: Position, heading: Heading, raw: Array) -> Sense | None:
    """The sense in which the heading (n,) as written follows the motion; None: not clear."""
    unit, _ = _unit(position, heading, raw)
    return by_motion(*position.plane, raw * TO_SI[unit or "rad"])


def is_compass(heading: Heading) -> bool:
    """Whether the name is of a compass heading, clockwise from north."""
    return any(word in COMPASS_WORDS for word in read_name(heading.names[0]).words)


def _unit(position: Position, heading: Heading, raw: Array) -> tuple[str, bool]:
    """The heading's unit, and whether the file states it; empty: for the motion to show."""
    stated = stated_unit(heading.table, heading.names[0])
    if len(heading.names) > 1:
        return "", False
    if stated in ("rad", "deg"):
        return stated, stated == "deg"
    unit = unit_of(raw)
    wide = not unit and float(np.nanmax(np.abs(raw))) > MOST_RADIANS
    if not unit and position.east_north is not None:
        unit = "deg" if wide else "rad"
    elif wide and by_motion(*position.plane, raw) is None:
        unit = "deg" if by_motion(*position.plane, raw * TO_SI["deg"]) is not None else ""
    return unit, unit == "deg"


def _sense(
    position: Position, heading: Heading, motion: Sense | None
) -> tuple[Sense, Sureness, str]:
    """Zero and sense of the heading from its name, its range and the motion."""
    geographic = position.east_north is not None
    quaternion = len(heading.names) > 1
    usual = COMPASS if geographic and not quaternion else PLAIN
    what = {COMPASS: "0 is north, clockwise", PLAIN: "0 is along x, counter-clockwise"}
    name = "quaternion" if quaternion else "name"
    if motion is None:
        certain = usual is COMPASS and is_compass(heading) and np.nanmin(heading.values) >= 0
        sure = Sureness.CERTAIN if certain else Sureness.LIKELY
        unseen = "" if certain else ", not seen in the motion"
        return usual, sure, f"{name}; {what[usual]}{unseen}"
    turned = (motion.offset - usual.offset) % 360
    if motion.sign == usual.sign and turned == 180 and quaternion:  # of a body with any axes
        return usual, Sureness.GUESS, f"{name}; {what[usual]}; the boat moves mostly astern: check"
    if motion.sign == usual.sign and turned in (0, 180):
        return usual, Sureness.CERTAIN, f"{name}; {what[usual]}, as the boat moves"
    if motion in what:
        return motion, Sureness.LIKELY, f"{name}; {what[motion]}, by the motion: check"
    sense = "counter-clockwise" if motion.sign > 0 else "clockwise"
    return (
        usual, Sureness.GUESS,
        f"{name}; check: the boat moves as if it were {sense} with {motion.offset} deg added",
    )  # fmt: skip
