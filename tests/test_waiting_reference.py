# SPDX-License-Identifier: MIT
"""A reference that waits for a boat that falls behind."""

import numpy as np
import pytest

from seatrial.control import Course, Track, WaitingReference
from seatrial.util.errors import ControlError

STEP, REACH, LENGTH = 0.1, 2.0, 60.0


@pytest.fixture
def line():
    """60 m along x in 60 s."""
    return Course(Track([[0.0, 0.0], [LENGTH, 0.0]], 1.0), 60.0)


def sailed(course, top):
    """Reference times and positions of a boat that follows at `top` m/s at most."""
    reference, x, rows = WaitingReference(course, REACH), 0.0, []
    for t in np.arange(0.0, 400.0, STEP):
        now = reference.at(float(t), [x, 0.0, 0.0])
        rows.append((reference.time, now.eta[0], x, now.rate[0]))
        x += STEP * min(top, max(0.0, now.rate[0] + (now.eta[0] - x)))
        if reference.ended:
            break
    return np.array(rows)


def test_a_boat_that_keeps_pace_gets_the_course(line):
    rows = sailed(line, 10.0)
    assert rows[-1, 0] == pytest.approx(60.0, abs=6.0)
    assert np.abs(rows[:, 1] - rows[:, 2]).max() < 0.2


def test_a_slow_boat_is_waited_for_and_arrives(line):
    rows = sailed(line, 0.4)
    behind = rows[:, 1] - rows[:, 2]
    assert behind.max() < REACH
    assert rows[-1, 1] == pytest.approx(LENGTH)
    # in the steady middle the reference moves as fast as the boat
    middle = (rows[:, 2] > 20.0) & (rows[:, 2] < 40.0)
    assert rows[middle, 3].mean() == pytest.approx(0.4, abs=0.02)


def test_beyond_the_reach_the_reference_rests(line):
    reference = WaitingReference(line, REACH)
    reference.at(20.0, [line.at(20.0).eta[0], 0.0, 0.0])
    now = reference.at(20.1, [line.at(20.0).eta[0] - 2.5, 0.0, 0.0])
    assert now.rate.tolist() == [0.0, 0.0, 0.0]
    assert reference.later(3.0).eta.tolist() == now.eta.tolist()


def test_a_boat_ahead_does_not_hurry_it(line):
    reference = WaitingReference(line, REACH)
    now = reference.at(20.0, [50.0, 0.0, 0.0])
    np.testing.assert_allclose(now.rows, line.at(20.0).rows)
    np.testing.assert_allclose(reference.later(1.5).rows, line.at(21.5).rows)


@pytest.mark.parametrize("reach", [0.0, -1.0, np.inf, np.nan])
def test_a_reach_is_a_distance(line, reach):
    with pytest.raises(ControlError, match="reach"):
        WaitingReference(line, reach)
