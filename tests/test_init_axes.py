# SPDX-License-Identifier: MIT
"""The question on axes: its answer is what happens on the water, and the log suggests one."""

import numpy as np
import pytest
from test_init_columns import PSI, pose_of, table

from seatrial.boat.schema import TO_SI
from seatrial.inspection.proposal.axes import FALLS, RISES, asked_axes, heading_seen
from seatrial.inspection.proposal.columns.heading import READS
from seatrial.inspection.proposal.columns.heading_sense import COMPASS, PLAIN
from seatrial.inspection.proposal.columns.names import Named, read_name
from seatrial.inspection.proposal.sources import Choices
from seatrial.util.frames import Axes

FLU, FRD = Axes.FLU.value, Axes.FRD.value
WORLDS = {  # columns as logged: what a left turn does to the heading, and the axes that are true
    "t=t|x=x|y=y|psi=psi": (RISES, FLU),
    "t=t|x=x|y=y|heading=compass": (FALLS, FLU),  # x east, y north
    "t=t|x=y|y=x|heading=compass": (FALLS, FRD),  # x north, y east
    "t=t|x=x|y=y|psi=clockwise": (FALLS, FLU),
    "t=t|x=y|y=x|yaw=psi": (RISES, FRD),  # y to starboard, and yet counter-clockwise
}


class Asked:
    """Gives one answer, and keeps what it was asked."""

    def __init__(self, answer=None):
        self.answer, self.questions, self.options = answer, [], []

    def __call__(self, question, options):
        self.questions.append(question)
        self.options.append(tuple(options))
        return self.answer or options[0]


@pytest.mark.parametrize("columns", WORLDS)
def test_the_answer_gives_the_axes_whatever_the_log_calls_x(columns, tmp_path):
    left_turn, true = WORLDS[columns]
    path = table(tmp_path / "log.csv", columns)
    other = RISES if left_turn == FALLS else FALLS
    assert asked_axes(path, Choices(), Asked(left_turn)) == true
    assert asked_axes(path, Choices(), Asked(other)) == (FRD if true == FLU else FLU)


@pytest.mark.parametrize("columns", [c for c in WORLDS if "heading" in c])
def test_a_boat_with_a_compass_turns_to_the_left_by_the_suggested_answer(columns, tmp_path):
    path = table(tmp_path / "log.csv", columns)
    axes = asked_axes(path, Choices(), asked := Asked())
    assert "The boat turns to the left (to port). What does heading" in asked.questions[0]
    assert asked.options == [(FALLS, RISES)]
    entry = pose_of(path, axes).entries["psi"]
    raw = np.genfromtxt(path, delimiter=",", names=True)["heading"]
    psi = entry.get("sign", 1) * TO_SI["deg"] * (raw - entry.get("offset", 0.0))
    to_left = np.unwrap(psi) * (-1 if axes == FRD else 1)
    np.testing.assert_allclose(np.diff(to_left), np.diff(np.unwrap(PSI)), atol=1e-6)


def test_nothing_is_asked_where_east_and_north_are_known(tmp_path):
    for columns in ("t=t|lat=lat|lon=lon|yaw=compass", "t=t|east=x|north=y|heading=compass"):
        path = table(tmp_path / "log.csv", columns)
        asked = Asked()
        assert asked_axes(path, Choices(), asked) == FLU
        pose_of(path, ask=asked)
        assert asked.questions == []


def test_no_user_or_no_clear_columns_leave_the_usual_axes(tmp_path):
    path = table(tmp_path / "log.csv", "t=t|x=x|y=y|psi=clockwise")
    assert asked_axes(path, Choices(), None) == FLU
    odd = table(tmp_path / "odd.csv", "t=t|a=x|b=y|c=psi")
    assert heading_seen(odd, Choices()) is None
    asked_axes(odd, Choices(), asked := Asked())
    assert asked.questions == [
        "The boat turns to the left (to port). What does the heading of the log do?"
    ]
    named = Choices(pose="x=a,y=b,heading=c")
    assert heading_seen(odd, named).text == "c, the heading of the log,"


@pytest.mark.parametrize("answer", READS)
def test_a_heading_that_the_motion_does_not_show_is_asked_as_the_boat_points_east(answer, tmp_path):
    """A boat that hardly moves: neither name nor motion show the heading's zero."""
    path = table(tmp_path / "log.csv", "t=t|east=z|north=z|yaw=psi")
    found = pose_of(path, ask=(asked := Asked(answer)))
    assert asked.questions == ["The boat points east. What does yaw, the heading of the log, read?"]
    entry = found.entries["psi"]
    sense = {
        PLAIN: {"column": "yaw"},
        COMPASS: {"column": "yaw", "sign": -1, "offset": 1.570796327},
    }
    assert entry == sense[READS[answer]]
    assert found.notes["known axes"] == ["x is east and y is north"]


@pytest.mark.parametrize(
    "name",
    [
        "yaw [rad/s]", "yaw_rad_s", "yaw_rads", "yaw_rad_per_s", "yaw_rad_per_sec", "yawRadPerSec",
        "yaw rad s-1",
    ],
)  # fmt: skip
def test_a_unit_per_second_makes_a_rate_of_a_heading(name):
    assert read_name(name) == Named(("yaw",), "rad", rate=True)


def test_words_that_end_like_a_unit_per_second_are_whole():
    assert read_name("flippers").words == ("flippers",)
