# SPDX-License-Identifier: MIT
"""A clock that is set while the boat drives: what can't be told apart is left out, and it is said."""

import numpy as np
import pytest
from live_sessions import ROW, SECOND, parted_session

from seatrial.poolside.session.clock_watch import ClockWatch
from seatrial.poolside.sources import SourceEvent

parted = parted_session
TENTH = SECOND // 10


def found(stamps):
    watch = ClockWatch()
    return [one for one in (watch.use(int(s)) for s in stamps) if one is not None]


def test_stamps_that_overlap_those_of_before_are_left_out_once():
    """Set back by 3 s after 20 s: the stamps from 17.1 to 20 s are of two times."""
    stamps = np.concatenate([np.arange(0, 201), np.arange(171, 400)]) * TENTH
    (one,) = found(stamps)
    assert one.overlap == (171 * TENTH, 200 * TENTH)
    assert one.seconds == pytest.approx(2.9)
    assert one.text.endswith("set back by 2.9 s: the poses of 2.9 s are left out")


def test_a_clock_that_is_set_back_before_the_first_row_overlaps_when_it_gets_there():
    stamps = np.concatenate([np.arange(1000, 1101), np.arange(900, 1200)]) * TENTH
    first, second = found(stamps)
    assert (first.overlap, first.seconds) == (None, pytest.approx(20.0))
    assert "begin a new session" in first.text
    assert second.overlap == (1000 * TENTH, 1100 * TENTH)


@pytest.mark.parametrize(
    "stamps",
    [
        np.arange(300) * TENTH,
        np.arange(300) * TENTH + np.where(np.arange(300) == 150, 3600 * SECOND, 0),
        np.arange(300) * TENTH - np.where(np.arange(300) == 150, 5 * SECOND, 0),
        np.arange(300) * TENTH - np.where(np.arange(300) % 2, SECOND // 4, 0),
        np.arange(300) * TENTH - np.where(np.arange(300) % 2, SECOND, 0),
        np.arange(300) * TENTH + np.where(np.arange(300) > 150, 3600 * SECOND, 0),
    ],
    ids=["steady", "one ahead", "one back", "late", "two senders", "set ahead"],
)
def test_other_stamps_set_no_clock_back(stamps):
    assert found(stamps) == []


def test_a_clock_that_was_ahead_for_a_while_overlaps_nothing():
    ahead = (np.arange(300) > 150) & (np.arange(300) < 200)
    (one,) = found(np.arange(300) * TENTH + np.where(ahead, 3600 * SECOND, 0))
    assert one.overlap is None


def test_estimate_predictions_and_recording_leave_the_overlap_out_and_a_mark_says_so(parted):
    one = parted()
    stamps = [*range(201), *range(171, 260)]
    one.source.put(*(SourceEvent("pose", i * TENTH, ROW, i) for i in stamps))
    one.until(lambda state: state.poses == len(stamps))
    one.until(lambda state: state.marks)
    overlap = (171 * TENTH, 200 * TENTH)
    assert [note for note in one.notes if note[0] != "mark"] == [
        (name, *overlap) for name in ("estimate", "prediction", "recording")
    ]
    ((_, text),) = one.session.state().marks
    assert (
        text
        == "pose: the clock of the stamps was set back by 2.9 s: the poses of 2.9 s are left out"
    )
