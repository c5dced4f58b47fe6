# SPDX-License-Identifier: MIT
"""Walls: distances, the middle, and their file."""

import numpy as np
import pytest

from seatrial.poolside.area import Area, read_walls, rectangle
from seatrial.util.errors import FileError

# an L: the notch is at its upper right
ELBOW = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 2.0], [2.0, 4.0], [0.0, 4.0]]


def test_distances_from_a_rectangle_are_those_of_its_nearest_side():
    pool = rectangle(3.6, 2.4, x=1.0)
    assert pool.margin(1.0, 0.0) == pytest.approx(1.2)
    assert pool.margin(2.7, 0.0) == pytest.approx(0.1)
    assert pool.margin(1.0, 1.5) == pytest.approx(-0.3)
    assert pool.margin(3.1, 1.6) == pytest.approx(-np.hypot(0.3, 0.4))  # from the corner
    assert pool.size == pytest.approx(3.6 * 2.4)
    assert pool.middle == pytest.approx((1.0, 0.0))


@pytest.mark.parametrize("turn", [1, -1])
def test_an_area_with_a_notch_has_its_middle_inside_in_either_direction(turn):
    elbow = Area(np.array(ELBOW[::turn]))
    assert elbow.margin(3.0, 3.0) == pytest.approx(-1.0)
    assert elbow.margin(2.5, 1.5) == pytest.approx(0.5)
    assert elbow.size == pytest.approx(12.0)
    assert elbow.margin(*elbow.middle) > 1.1  # in the elbow; 1 m in either arm


def test_a_path_is_as_clear_as_the_nearest_place_on_it():
    path = np.array([[-1.0, 0.0], [1.0, 0.5]])
    assert rectangle(3.6, 2.4).margins(path).min() == pytest.approx(0.7)


def test_walls_are_a_size_or_a_file(tmp_path):
    assert np.array_equal(read_walls("3.6x2.4").corners, rectangle(3.6, 2.4).corners)
    path = tmp_path / "walls.yaml"
    path.write_text("seatrial: area 1\ncorners: [[0, 0], [4, 0], [4, 2]]\n")
    assert read_walls(path).size == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [("no.yaml", "no such file"), ("0x2", "around an area"), ("3..2x4", "not a length")],
)  # fmt: skip
def test_walls_that_are_none_are_refused(text, message):
    with pytest.raises(FileError, match=message):
        read_walls(text)


def test_two_corners_are_no_area():
    with pytest.raises(FileError, match="three corners"):
        Area(np.zeros((2, 2)))
