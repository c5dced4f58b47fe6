# SPDX-License-Identifier: MIT
"""Headings that are the course over ground are doubted; headings of a boat that is driven ahead only are not."""

import numpy as np
import pytest
from survey_boat import driven

import seatrial
from seatrial.recording.faults.course_heading import course_doubt
from seatrial.recording.from_poses import make_recording


def ahead(rng):
    return rng.uniform(0.5, 1.0)


def either(rng):
    return rng.uniform(-0.3, 0.3)


def nothing(rng):
    return 0.0


def drive(speed=ahead, turn=either):
    return driven({}, [speed, turn], seconds=120.0, idle=0.0, noise=(0.005, 0.005, 0.01))


def with_course(recording):
    """Its headings are the directions of motion, as of a GNSS receiver."""
    over = 3  # poses to either side
    moved = np.gradient(recording.raw[:, :2], axis=0)
    smooth = np.column_stack([np.convolve(z, np.ones(2 * over + 1), "same") for z in moved.T])
    eta = np.column_stack([recording.raw[:, :2], np.unwrap(np.arctan2(*smooth.T[::-1]))])
    return make_recording("course", recording.stamps, eta, recording.commands)


def test_a_course_in_place_of_the_heading_is_doubted_by_inspect_and_identify():
    vehicle, recording = drive()
    course = with_course(recording)
    (doubt,) = course_doubt(course)
    assert "course over ground" in doubt
    assert (
        f"course: {doubt}" in seatrial.identify([course], vehicle, method="equation-error").warnings
    )
    assert doubt in " ".join(str(seatrial.inspect([course], vehicle)).split())


@pytest.mark.parametrize("turn", [either, nothing])
def test_the_heading_of_a_boat_that_goes_ahead_only_is_one(turn):
    _, recording = drive(turn=turn)
    assert course_doubt(recording) == []


def test_a_straight_track_tells_nothing():
    _, recording = drive()
    rng = np.random.default_rng(1)
    eta = rng.normal(size=recording.raw.shape) * (0.005, 0.005, 0.01)
    eta[:, 0] += 0.4 * recording.t
    straight = make_recording("straight", recording.stamps, eta, recording.commands)
    assert course_doubt(straight) == []


def test_a_boat_at_rest_tells_nothing():
    _, recording = drive(nothing, nothing)
    assert course_doubt(recording) == []
