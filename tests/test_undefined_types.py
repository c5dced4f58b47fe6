# SPDX-License-Identifier: MIT
"""Bags without the definitions of their messages, as .db3 before Iron with types of one's own: inspect and init."""

import pytest
from bag_tools import drive, old_db3, vehicle
from init_tools import refused
from inspect_tools import said

import seatrial
from seatrial.util.errors import RecordingError

POSE, JOY, OTHER = "/slam/pose", "/joy", "/rosout"
WHY = (
    "the bag has no definition of boat_msgs/Motors: their fields can't be read; record it as .mcap"
)


def bag(folder, *strange):
    """Poses, sticks and texts; some topics have a type that only its packages know."""
    sent = [
        s._replace(type="boat_msgs/msg/Motors", fields={}) if s.topic in strange else s
        for s in drive()
    ]
    return old_db3(folder, sent, qos=True)


@pytest.mark.parametrize("options", [(), ("--pose", f"x={POSE}/x,y={POSE}/y"), ("--commands", JOY)])
def test_init_says_why_no_topic_has_a_pose(tmp_path, capsys, options):
    """Found with a public log of navigation sensors, all four topics of which have types of its own."""
    path = bag(tmp_path / "run", POSE, JOY, OTHER)
    line = refused(capsys, path, "-o", tmp_path / "v.yaml", *options)
    assert f"no topic has a type of poses; {WHY}" in line
    assert (
        "convert it with ros2 bag convert, where the packages of its messages are installed" in line
    )
    assert (
        "The topics are /joy (boat_msgs/Motors); /rosout (boat_msgs/Motors); /slam/pose (boat"
        in line
    )


@pytest.mark.parametrize(
    ("strange", "options", "expected"),
    [
        ((POSE,), (), f"no topic has a type of poses; name one with --pose; {WHY}"),
        ((JOY,), (), f"no topic has a type of commands; name one with --commands; {WHY}"),
        ((JOY,), ("--commands", JOY), f"topic {JOY}: the bag has no definition of boat_msgs/Motors"),
        ((POSE,), ("--pose", f"x={POSE}/x,y={POSE}/y,heading={POSE}/z"), f"topic {POSE}: the bag has no"),
        ((POSE,), ("--pose", POSE), f"topic {POSE}: the bag has no definition of boat_msgs/Motors"),
        ((POSE,), ("--pose", f"x={POSE}/x,y={POSE}/y"), f"name one with --pose; {WHY}"),
    ],
)  # fmt: skip
def test_init_where_some_topics_can_be_read(tmp_path, capsys, strange, options, expected):
    path = bag(tmp_path / "run", *strange)
    assert expected in refused(capsys, path, "-o", tmp_path / "v.yaml", *options)


def test_a_topic_of_no_use_may_have_any_type(tmp_path, capsys):
    path = bag(tmp_path / "run", OTHER)
    line = refused(capsys, path, "-o", tmp_path / "v.yaml")
    assert "3 s do not show which of axes_0, axes_1, axes_3 move the boat" in line


def test_fields_of_an_unknown_type_in_a_vehicle_file_are_refused(tmp_path):
    path, field = bag(tmp_path / "run", POSE), {"field": "x"}
    boat = vehicle(pose={"topic": POSE, "x": field, "y": field, "psi": field})
    with pytest.raises(RecordingError, match=f"topic {POSE}: the bag has no definition of boat"):
        seatrial.read(path, boat)


def test_inspect_says_it_in_place_of_fields_that_nobody_can_name(tmp_path, look):
    lines = said(look(bag(tmp_path / "all", POSE, JOY, OTHER))[0])
    assert [line.startswith("no topic looks like") for line in lines] == [True, True, False]
    assert not any("init takes fields" in line for line in lines)
    assert lines[2].startswith(WHY)
    lines = said(look(bag(tmp_path / "joy", JOY))[0])
    assert [line.partition(".")[0] for line in lines[:1]] == [
        "no topic looks like commands by its type"
    ]
    assert "init takes fields of any type" in lines[0]
    assert lines[1].startswith(WHY)
    assert said(look(bag(tmp_path / "other", OTHER))[0]) == []
