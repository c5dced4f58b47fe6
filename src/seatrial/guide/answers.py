# SPDX-License-Identifier: MIT
"""What no log can tell: asked at a terminal, else assumed and stated."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from seatrial.inspection.proposal.axes import asked_axes
from seatrial.inspection.proposal.inputs import ThrustersUnknownError
from seatrial.inspection.proposal.propose import Proposal, init
from seatrial.inspection.proposal.sources import (
    MOORE_PENROSE,
    Choices,
    lever_of,
    thrusters_of,
)
from seatrial.io.formats import is_log
from seatrial.util.format import joined
from seatrial.util.frames import Axes
from seatrial.util.questions import Questions

LAST_QUARTER = "the last quarter of each recording"
BOW, STERN = "the bow", "the stern"
BOW_QUESTION = """\
Which end of the boat does the heading of the log point to? It decides which way is forward on the stick."""
LEVER_QUESTION = (
    "Where is the measured point (GNSS antenna, markers, SLAM frame) from the boat's origin, usually the middle "
    "of the thrusters? Give metres ahead and metres to {side}, such as '0.35 -0.1'. Enter: not known"
)
THRUSTERS_QUESTION = (
    "Where are the thrusters{of}? For each x ahead [m], y to {side} [m] and direction of thrust [deg] from "
    "forward towards {side}, such as '0.2 0.2 135; 0.2 -0.2 -135; ...'. Enter: not known"
)
SCHEME_QUESTION = "How does the boat's software allocate forces to thrusters?"
SCHEMES = (MOORE_PENROSE, "always-forward")
TEST_QUESTION = "Which recording tests the model, and is not used to identify it?"


def choices_of(path: Path, given: Choices, ask: Questions | None) -> Choices:
    """Choices for `init`, with the answers on axes, bow and measured point."""
    choose = None if ask is None else ask.choose
    axes = asked_axes(path, given, choose)
    given = replace(given, axes=axes, axes_answered=ask is not None)
    if ask is not None and not is_log(path):  # an autopilot defines its bow
        given = replace(given, stern=ask.choose(BOW_QUESTION, (BOW, STERN)) == STERN)
    if ask is None or given.lever is not None:
        return given
    answer = ask.text(LEVER_QUESTION.format(side=_side(given)))
    return replace(given, lever=lever_of(answer)) if answer else given


def proposed(
    logs: Sequence[Path], given: Choices, ask: Questions | None, *, salvage: bool
) -> tuple[Proposal, Choices]:
    """The proposal of `init`, with the thrusters where they must be known, or are worth it."""
    choose = None if ask is None else ask.choose
    first, *more = logs

    def propose() -> Proposal:
        return init(first, *more, choices=given, ask=choose, salvage=salvage)

    try:
        proposal = propose()
        known = bool(proposal.drive.forces or given.thrusters)
        answer = "" if known or ask is None else ask.text(_thrusters_question("", given))
        if answer:
            assert ask is not None
            given = replace(
                given, thrusters=thrusters_of(answer), scheme=ask.choose(SCHEME_QUESTION, SCHEMES)
            )
            proposal = propose()
    except ThrustersUnknownError as error:
        answer = "" if ask is None else ask.text(_thrusters_question(joined(error.names), given))
        if not answer:
            raise
        given = replace(given, thrusters=thrusters_of(answer))
        proposal = propose()
    return proposal, given


def _thrusters_question(names: str, given: Choices) -> str:
    return THRUSTERS_QUESTION.format(of=f" {names}" if names else "", side=_side(given))


def test_of(names: Sequence[str], ask: Questions) -> str:
    """The recording that tests the model, or the last quarter of each."""
    return ask.choose(TEST_QUESTION, (LAST_QUARTER, *names))


def assumptions(path: Path, proposal: Proposal, given: Choices, ask: Questions | None) -> list[str]:
    """What is assumed where the user gives no answer."""
    found = []
    if ask is None and not is_log(path):
        known = joined(proposal.sources.notes.get("known axes", []))
        axes = "" if known else f"axes {given.axes} and "
        found.append(f"{axes}a heading that points to the bow (init --axes, psi: {{sign: -1}})")
    if given.lever is None and proposal.drive.lever is None:
        found.append(
            "the measured point is the boat's origin, unless the motion shows a lever arm (pose: {lever: [x, y]})"
        )
    if not proposal.drive.forces and not given.thrusters:
        found.append(
            "thrusters not known, so that no dead zone is estimated (thrusters:, allocation:)"
        )
    return found


def _side(given: Choices) -> str:
    """The direction of the file's second axis."""
    return "starboard" if given.axes == Axes.FRD.value else "port"
