# SPDX-License-Identifier: MIT
"""What the guided path asks in words, and how it reads what is typed."""

import pytest

from seatrial.boat.findings import finding_of
from seatrial.guide import answers
from seatrial.guide.answers import contradicting_names
from seatrial.inspection.proposal.sources import lever_of, one_each, thrusters_of
from seatrial.util.errors import SeatrialError


@pytest.mark.parametrize("text", ["0.3", "0.3 0.2 0.1", "a b", "nan 0", "0.3;0.2", "60 0", "1e9 0"])
def test_a_lever_arm_that_is_none_is_refused(text):
    with pytest.raises(SeatrialError, match="expected two lengths in metres"):
        lever_of(text)


def test_answers_on_thrusters():
    assert thrusters_of("0.3, 0.2, -45; -.3 0 90;") == ((0.3, 0.2, -45.0), (-0.3, 0.0, 90.0))
    with pytest.raises(SeatrialError, match=r"thruster '0\.3 0\.2'"):
        thrusters_of("0.3 0.2 -45; 0.3 0.2")


class Typist:
    """Types these lines; keeps what was asked."""

    def __init__(self, *lines):
        self.lines, self.asked = [*lines], []

    def choose(self, question, options):
        self.asked.append(question)
        return options[0]

    def text(self, question):
        self.asked.append(question)
        return self.lines.pop(0)


def test_a_typed_answer_is_asked_again_until_it_can_be_read():
    typist = Typist("about 0", "0.2 0.2 135", "0.2 0.2 135; 0.2 -0.2 -135")
    names = ["left", "right"]
    places = answers._answered(
        typist, "Where?", lambda answer: one_each(thrusters_of(answer), names)
    )
    assert len(places) == 2
    first, second, third = typist.asked
    assert first == "Where?"
    assert second.endswith("\nWhere?")
    assert third == "1 of 2 thrusters given; one each for left and right, separated by ';'\nWhere?"
    assert answers._answered(Typist(""), "Where?", thrusters_of) is None
    assert answers._answered(None, "Where?", thrusters_of) is None


@pytest.mark.parametrize("kind", answers.EFFECT_QUESTIONS)
def test_an_effect_is_asked_in_plain_words(kind):
    typist = Typist()
    sizes = {"size": 0.375} if "size" in kind.spec.numbers else {}
    assert answers.effect_answered(finding_of(kind, **sizes), typist)
    (question,) = typist.asked
    assert question.startswith("The log looks as if ")
    assert ("0.38 m" in question or "0.38 s" in question) == bool(sizes)
    assert "process noise" not in question


@pytest.mark.parametrize(
    ("names", "wrong"),
    [
        (("left", "right"), True),
        (("port_motor", "stbd"), True),
        (("motor-right", "motor-left"), False),
        (("a", "b"), False),
        (("left", "b"), True),
        (("leftover", "b"), False),
    ],
)
def test_names_of_sides_are_compared_with_what_they_do(names, wrong):
    """The first of the two turns the boat to the left when it drives ahead: it is on the right."""
    forces = {
        "F_u": {"axis": "surge", "of": dict(zip(names, (0.5, 0.5), strict=True))},
        "F_r": {"axis": "yaw", "of": dict(zip(names, (0.5, -0.5), strict=True))},
    }
    assert bool(contradicting_names(forces, "forward-left-up")) == wrong
    mirrored = {**forces, "F_r": {"axis": "yaw", "of": dict(zip(names, (-0.5, 0.5), strict=True))}}
    assert bool(contradicting_names(mirrored, "forward-right-down")) == wrong
