# SPDX-License-Identifier: MIT
"""What no log can tell: asked at a terminal, else assumed and stated; and what names of thrusters say."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from seatrial.boat.findings import Finding, FindingKind
from seatrial.inspection.proposal.axes import asked_axes
from seatrial.inspection.proposal.by_name import ThrustersUnknownError
from seatrial.inspection.proposal.propose import Proposal, init
from seatrial.inspection.proposal.sources import (
    MOORE_PENROSE,
    Choices,
    Place,
    lever_of,
    one_each,
    thrusters_of,
)
from seatrial.io.formats import is_log
from seatrial.util.errors import SeatrialError
from seatrial.util.format import joined
from seatrial.util.frames import Axes
from seatrial.util.questions import Questions

T = TypeVar("T")
LAST_QUARTER = "the last quarter of each recording"
BOW, STERN = "the bow", "the stern"
BOW_QUESTION = """\
Which end of the boat does the heading of the log point to? It decides which way is forward on the stick."""
SIDES_QUESTION = (
    "Driven ahead, {names} turn the boat as thrusters on the other side do. What is to be changed?"
)
OTHER_END = "the heading points to the other end of the boat"
OTHER_NAMES = "nothing: {names} are on the other side than their names say"
LEVER_QUESTION = (
    "Where is the measured point (GNSS antenna, markers, SLAM frame) from the boat's origin? The origin is the "
    "middle of the thrusters where they stand around the boat; of thrusters at the stern only, it is the boat's "
    "centre of mass. Give metres ahead and metres to {side}, such as '0.35 -0.1'. Enter: not known"
)
THRUSTERS_QUESTION = (
    "Where are the thrusters{of}? {needed}For each x ahead [m], y to {side} [m] and direction of thrust [deg] "
    "from forward towards {side}, such as '0.2 0.2 135; 0.2 -0.2 -135; ...'. Enter: {enter}"
)
NEEDED = (
    "Needed here: they are driven in the same {count} combinations (an allocation), so the log does not show what "
    "each does. "
)
STILL_NEEDED = "Without these places there is no model: measure them on the boat.\n"
SCHEME_QUESTION = "How does the boat's software allocate forces to thrusters?"
SCHEMES = (MOORE_PENROSE, "always-forward")
ESTIMATE, LEAVE = "yes, or perhaps: estimate it with the model", "no: leave it out"
EFFECT_QUESTIONS = {
    FindingKind.UNMODELLED_LEVER_ARM: "the measured point were {size:.2f} m from the boat's origin",
    FindingKind.UNMODELLED_CURRENT: "there was a current of {size:.2f} m/s",
    FindingKind.UNMODELLED_TRIM: "a steady force turned with the boat (trim, an uneven hull)",
    FindingKind.UNMODELLED_WIND: "a steady force had one direction over ground (wind)",
    FindingKind.UNMODELLED_DELAY: "positions were {size:.2f} s late",
}
AT_ORIGIN = "the measured point is the boat's origin (pose: {lever: [x, y]})"
TEST_QUESTION = "Which recording tests the model, and is not used to identify it?"
SIDES = {"port|left": 1.0, "starboard|stbd|right": -1.0}  # y of a thruster, forward-left-up
PART = re.compile(r"[A-Za-z]+")


def choices_of(path: Path, given: Choices, ask: Questions | None) -> Choices:
    """Choices for `init`, with the answers on axes, bow and measured point."""
    choose = None if ask is None else ask.choose
    axes = asked_axes(path, given, choose)
    given = replace(given, axes=axes, axes_answered=ask is not None)
    if ask is not None and not is_log(path):  # an autopilot defines its bow
        given = replace(given, stern=ask.choose(BOW_QUESTION, (BOW, STERN)) == STERN)
    if ask is None or given.lever is not None:
        return given
    lever = _answered(ask, LEVER_QUESTION.format(side=_side(given)), lever_of)
    return given if lever is None else replace(given, lever=lever)


def _answered(ask: Questions | None, question: str, read: Callable[[str], T]) -> T | None:
    """A typed answer, asked again until it can be read; None: not known."""
    asked = question
    while ask is not None and (answer := ask.text(asked)):
        try:
            return read(answer)
        except SeatrialError as error:
            asked = f"{error}\n{question}"
    return None


def proposed(
    logs: Sequence[Path], given: Choices, ask: Questions | None, *, salvage: bool
) -> tuple[Proposal, Choices]:
    """The proposal of `init`, with the thrusters where they must be known, or are worth it."""
    choose = None if ask is None else ask.choose
    first, *more = logs

    def propose() -> Proposal:
        return init(first, *more, choices=given, ask=choose, salvage=salvage)

    question = THRUSTERS_QUESTION.format(of="", needed="", side=_side(given), enter="not known")
    try:
        proposal = propose()
        known = bool(proposal.drive.forces or given.thrusters)
        places = None if known else _answered(ask, question, thrusters_of)
        if places is not None and ask is not None:
            scheme = ask.choose(SCHEME_QUESTION, SCHEMES)
            given = replace(given, thrusters=places, scheme=scheme)
            proposal = propose()
    except ThrustersUnknownError as error:
        given = replace(given, thrusters=_needed_places(error, given, ask))
        proposal = propose()
    wrong = contradicting_names(proposal.drive.forces, given.axes)
    if ask is not None and wrong and not is_log(first):
        said = joined(wrong)
        answers = OTHER_END, OTHER_NAMES.format(names=said)
        if ask.choose(SIDES_QUESTION.format(names=said), answers) == OTHER_END:
            given = replace(given, stern=not given.stern)
            proposal = propose()
    return proposal, given


def _needed_places(
    error: ThrustersUnknownError, given: Choices, ask: Questions | None
) -> tuple[Place, ...]:
    """The places without which there is no model: asked twice. Raises ThrustersUnknownError."""
    needed = NEEDED.format(count=error.count)
    for before, enter in (("", "asked again"), (STILL_NEEDED, "not known, and stop")):
        question = before + THRUSTERS_QUESTION.format(
            of=f" {joined(error.names)}", needed=needed, side=_side(given), enter=enter
        )
        places = _answered(ask, question, lambda a: one_each(thrusters_of(a), error.names))
        if places is not None:
            return places
    if ask is None or given.lever is None:
        raise error
    ahead, aside = given.lever
    raise ThrustersUnknownError(
        f"{error}; what was answered is the option --lever {ahead:g} {aside:g}",
        error.names,
        error.count,
    )


def effect_answered(finding: Finding, ask: Questions) -> bool:
    """Whether an effect that the log shows is estimated with the model."""
    size = {"size": finding.number("size")} if "size" in finding.values else {}
    looks = EFFECT_QUESTIONS[finding.kind].format(**size)
    question = f"The log looks as if {looks}. Can that be? Left out, it is taken for drag, thrust or noise."
    return ask.choose(question, (ESTIMATE, LEAVE)) == ESTIMATE


def assumptions(path: Path, proposal: Proposal, given: Choices, ask: Questions | None) -> list[str]:
    """What is assumed where the user gives no answer."""
    found = []
    if ask is None and not is_log(path):
        known = joined(proposal.sources.notes.get("known axes", []))
        axes = "" if known else f"axes {given.axes} and "
        found.append(
            f"{axes}a heading that points to the bow; else correct axes and pose: psi in vehicle.yaml"
        )
    if ask is None and (wrong := contradicting_names(proposal.drive.forces, given.axes)):
        found.append(
            f"{joined(wrong)} on the other side than the names say: driven ahead, they turn the boat the other "
            "way. If the names are right, the heading points to the stern, or the axes are others"
        )
    if given.lever is None and proposal.drive.lever is None:
        found.append(AT_ORIGIN)
    if not proposal.drive.forces and not given.thrusters:
        found.append(
            "thrusters not known: the usual layout that explains the recordings best, if one does "
            "(thrusters:, allocation:)"
        )
    return found


def _side(given: Choices) -> str:
    """The direction of the file's second axis."""
    return "starboard" if given.axes == Axes.FRD.value else "port"


def contradicting_names(forces: Mapping[str, Mapping[str, Any]], axes: str) -> tuple[str, ...]:
    """Thrusters that turn the boat as those of the other side do, where all with such names do.

    A thruster on the left that drives the boat ahead turns it to the right. forces: of a proposal, in `axes`.
    """
    by_axis = {force["axis"]: force["of"] for force in forces.values()}
    surge, yaw = by_axis.get("surge", {}), by_axis.get("yaw", {})
    left_up = Axes(axes).lateral_sign
    named = {name: side for name in yaw if (side := _named_side(name)) and surge.get(name)}
    wrong = [n for n, side in named.items() if left_up * side * surge[n] * yaw[n] > 0.0]
    return tuple(wrong) if len(wrong) == len(named) else ()


def _named_side(name: str) -> float:
    """1: left, -1: right; 0: the name does not say."""
    words = {word.lower() for word in PART.findall(name.replace("_", " "))}
    found = {side for pattern, side in SIDES.items() if words & set(pattern.split("|"))}
    return found.pop() if len(found) == 1 else 0.0
