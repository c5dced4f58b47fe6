# SPDX-License-Identifier: MIT
"""What no log can tell: asked at a terminal, else assumed and stated."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from seatrial.inspection.proposal.propose import Proposal
from seatrial.inspection.proposal.sources import MOORE_PENROSE, Choices
from seatrial.io.formats import is_log
from seatrial.util.errors import VehicleError
from seatrial.util.frames import Axes
from seatrial.util.questions import Questions

LONGEST_LEVER = 50.0  # [m] of a small boat; a longer one is in other units
LAST_QUARTER = "the last quarter of each recording"
BOW, STERN = "the bow", "the stern"
AXES_QUESTION = """\
No log tells which way the axes point: when the boat turns to the left, does the heading rise (x forward, y to \
port) or fall (y to starboard)?"""
BOW_QUESTION = """\
Which end of the boat does the heading of the log point to? It decides which way is forward on the stick."""
LEVER_QUESTION = (
    "Where is the measured point (GNSS antenna, markers, SLAM frame) from the boat's origin, usually the middle "
    "of the thrusters? Give metres ahead and metres to {side}, such as '0.35 -0.1'. Enter: not known"
)
THRUSTERS_QUESTION = (
    "The commands are forces. Where are the thrusters? For each x ahead [m], y to {side} [m] and direction of "
    "thrust [deg] from forward towards {side}, such as '0.2 0.2 135; 0.2 -0.2 -135; ...'. Enter: not known"
)
SCHEME_QUESTION = "How does the boat's software allocate forces to thrusters?"
SCHEMES = (MOORE_PENROSE, "always-forward")
TEST_QUESTION = "Which recording tests the model, and is not used to identify it?"


def choices_of(path: Path, given: Choices, ask: Questions | None) -> Choices:
    """Choices for `init`, with the answers on axes, bow and measured point."""
    if is_log(path):  # an autopilot defines its axes and its bow
        given = replace(given, axes=Axes.FRD.value)
    elif ask is not None:
        given = replace(given, axes=ask.choose(AXES_QUESTION, [axes.value for axes in Axes]))
        given = replace(given, stern=ask.choose(BOW_QUESTION, (BOW, STERN)) == STERN)
    if ask is None or given.lever is not None:
        return given
    answer = ask.text(LEVER_QUESTION.format(side=_side(given)))
    return replace(given, lever=lever_of(answer)) if answer else given


def thrusters_of(proposal: Proposal, given: Choices, ask: Questions | None) -> Choices:
    """The same with the thrusters, where the commands are forces and nothing says what they are allocated to."""
    if ask is None or proposal.drive.forces or given.thrusters:
        return given
    answer = ask.text(THRUSTERS_QUESTION.format(side=_side(given)))
    if not answer:
        return given
    found = tuple(_thruster(part) for part in answer.split(";") if part.strip())
    return replace(given, thrusters=found, scheme=ask.choose(SCHEME_QUESTION, SCHEMES))


def test_of(names: Sequence[str], ask: Questions | None) -> str | None:
    """The recording that tests the model; None: the last quarter of each."""
    if ask is None or len(names) < 2:
        return None
    answer = ask.choose(TEST_QUESTION, (LAST_QUARTER, *names))
    return None if answer == LAST_QUARTER else answer


def assumptions(path: Path, proposal: Proposal, given: Choices, ask: Questions | None) -> list[str]:
    """What is assumed where nobody was asked."""
    found = []
    if ask is None and not is_log(path):
        found.append(
            f"axes {given.axes} and a heading that points to the bow (init --axes, psi: {{sign: -1}})"
        )
    if given.lever is None and proposal.drive.lever is None:
        found.append(
            "the measured point is the boat's origin, unless the motion shows a lever arm (pose: {lever: [x, y]})"
        )
    if not proposal.drive.forces and not given.thrusters:
        found.append(
            "thrusters not known, so that no dead zone is estimated (thrusters:, allocation:)"
        )
    return found


def lever_of(text: str) -> tuple[float, float]:
    """Two lengths [m]. Raises VehicleError."""
    numbers = _numbers(text)
    if len(numbers) != 2 or max(map(abs, numbers)) > LONGEST_LEVER:
        raise VehicleError(f"lever arm '{text}': expected two lengths in metres, such as 0.35 -0.1")
    return numbers[0], numbers[1]


def _thruster(text: str) -> tuple[float, float, float]:
    numbers = _numbers(text)
    if len(numbers) != 3 or max(map(abs, numbers[:2])) > LONGEST_LEVER:
        raise VehicleError(
            f"thruster '{text.strip()}': expected x [m], y [m] and direction [deg], such as 0.2 0.2 135"
        )
    return numbers[0], numbers[1], numbers[2]


def _numbers(text: str) -> list[float]:
    """Numbers that spaces or commas divide; none where a word is no number."""
    words = [word for word in re.split(r"[\s,]+", text.strip()) if word]
    if not all(re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)", word) for word in words):
        return []
    return [float(word) for word in words]


def _side(given: Choices) -> str:
    """The direction of the file's second axis."""
    return "starboard" if given.axes == Axes.FRD.value else "port"
