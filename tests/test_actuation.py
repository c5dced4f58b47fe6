# SPDX-License-Identifier: MIT
"""Weights of thrusters in a force: a lever arm of the measured point does not make identical ones unequal."""

import numpy as np
import pytest

from seatrial.inspection.proposal.actuation import thrusters, weights
from seatrial.inspection.proposal.channels import LONGEST_LEVER, Channels

CLEAR = np.array([[True, True], [False, False], [True, True]])
T = np.full((3, 2), 100.0)


def gains(surge, turn, lever=0.0):
    """Of two thrusters, seen by a point beside the origin."""
    return np.array([surge + lever * np.array(turn), [0.0, 0.0], turn])


@pytest.mark.parametrize(
    ("seen", "share"),
    [
        *((gains([2.5, 2.5], [0.7, -0.7], lever), 0.5) for lever in (0.0, 0.1, -0.3, 1.4)),
        (gains([0.3, 0.2], [0.9, -0.6]), 0.6),  # they turn the boat unequally
    ],
)
def test_identical_thrusters_have_equal_weights_whatever_the_lever_arm(seen, share):
    np.testing.assert_allclose(weights(0, CLEAR, seen, T), [share, 1.0 - share])
    np.testing.assert_allclose(weights(2, CLEAR, seen, T), [share, share - 1.0])


def test_a_difference_that_takes_too_long_a_lever_arm_stays():
    seen = gains([2.5, 2.5], [0.7, -0.7], 1.1 * LONGEST_LEVER)
    np.testing.assert_allclose(weights(0, CLEAR, seen, T), seen[0] / seen[0].sum())


def test_gains_within_their_errors_are_equal():
    seen = np.array([[1.0, 1.3], [0.0, 0.0], [0.0, 0.0]])
    clear = np.array([[True, True], [False, False], [False, False]])
    np.testing.assert_allclose(weights(0, clear, seen, np.full((3, 2), 5.0)), [0.5, 0.5])
    np.testing.assert_allclose(weights(0, clear, seen, np.full((3, 2), 50.0)), [1 / 2.3, 1.3 / 2.3])


@pytest.mark.parametrize(
    ("turn", "t", "found"),
    [
        ([1.0, -0.8, 0.0], [50.0, 40.0, 1.0], [1 / 1.8, -0.8 / 1.8, 0.0]),
        ([1.0, -0.8, 0.0], [12.5, 10.0, 1.0], [0.5, -0.5, 0.0]),  # no more than errors
        ([1.0, 0.95, 0.0], [np.inf, np.inf, 1.0], [0.5, 0.5, 0.0]),
    ],
)
def test_thrusters_that_do_not_push_alike_keep_their_weights(turn, t, found):
    seen, sure = np.zeros((3, 3)), np.ones((3, 3))
    seen[2], sure[2] = turn, t
    np.testing.assert_allclose(weights(2, seen != 0.0, seen, sure), found)


@pytest.mark.parametrize(
    ("t", "gains"),
    [
        # 40 s of a twin-screw boat; a minute of station keeping
        ([[8.3, 5.5], [0.6, -1.0], [-13.8, 13.3]], [[0.19, 0.19], [0.0, 0.0], [-0.60, 0.58]]),
        ([[5.0, 6.2], [-2.5, 1.8], [-8.9, 4.6]], [[0.09, 0.1], [0.0, 0.0], [-0.14, 0.12]]),
    ],
)
def test_the_second_of_two_thrusters_drives_an_axis_that_the_first_one_just_drives(t, gains):
    found = channels(t, gains)
    assert found.shared
    _, remarks, forces = thrusters(found)
    assert forces == {
        "F_u": {"axis": "surge", "of": {"left": 0.5, "right": 0.5}},
        "F_r": {"axis": "yaw", "of": {"left": -0.5, "right": 0.5}},
    }
    assert all("surge" in text and "yaw" in text for text in remarks.values())


def test_a_stick_does_not_drive_what_another_one_clearly_does():
    found = channels([[30.0, 5.5], [0.0, 0.0], [4.0, 40.0]], [[0.2, 0.1], [0.0, 0.0], [0.2, 0.6]])
    assert not found.shared
    assert found.clear.tolist() == [[True, False], [False, False], [False, True]]


def channels(t, gains):
    """Of two channels, driven alike."""
    names, driven = ("left", "right"), np.ones((100, 2), dtype=bool)
    columns = {name: {"column": name} for name in names}
    return Channels(names, columns, np.array(t), np.array(gains), np.array([0.3, 0.3]), driven)
