# SPDX-License-Identifier: MIT
"""The test for a change of the boat where poses do not count, or do not tell: what is left out is no evidence."""

from changed_boats import drives_by_cause, findings, known_model, sent

from seatrial.evaluation.comparison.cause_candidates import NO_CHANGE
from seatrial.monitoring.change_detector import CONFIRMATION, PASSING, ChangeDetector
from seatrial.onboard.boat_change import ChangeState
from seatrial.util.frames import NS_PER_S
from tests.boats.weather import towed

model, drives = known_model, drives_by_cause
TOWED_FROM, TOWED_TO, LONGER, SECONDS = (
    16.4,
    18.2,
    25.0,
    40.0,
)  # [s]: tests are at 16.3 s and 18.3 s


def split(rows, seconds):
    """Rows before and from a time [s] after the first."""
    at = rows[0][0] + round(seconds * NS_PER_S)
    return [r for r in rows if r[0] < at], [r for r in rows if r[0] >= at]


def test_a_tow_that_is_discarded_is_no_change(model, drives):
    rows = sent(towed(drives[NO_CHANGE].cut(0.0, SECONDS), TOWED_FROM, TOWED_TO))
    (noticed,) = findings(ChangeDetector(model), rows)
    assert noticed.state is ChangeState.NOTICED
    before, after = split(rows, TOWED_TO + 0.05)
    detector = ChangeDetector(model)
    assert not findings(detector, before)
    detector.begin_after(before[-1][0])
    assert not findings(detector, after)


def test_a_change_that_was_noticed_is_judged_by_poses_after_what_is_discarded(model, drives):
    """Discarded right after the notice: the confirmation begins then, not within what was discarded."""
    rows = sent(towed(drives[NO_CHANGE], TOWED_FROM, LONGER))
    before, after = split(rows, LONGER)
    detector = ChangeDetector(model)
    assert [one.state for one in findings(detector, before)] == [ChangeState.NOTICED]
    end = before[-1][0]
    detector.begin_after(end)
    (judged,) = findings(detector, after)
    assert judged.state is ChangeState.WITHDRAWN
    assert 0.0 <= (judged.stamp - end) / NS_PER_S - PASSING - CONFIRMATION < 4.0
