# SPDX-License-Identifier: MIT
"""The test for a change and the stamps of its rows: pauses, late rows, a clock that is set back."""

from dataclasses import replace

import numpy as np
import pytest
from changed_boats import drives_by_cause, findings, known_model, sent

from seatrial.evaluation.comparison.cause_candidates import BATTERY, NO_CHANGE
from seatrial.monitoring.change_detector import ChangeDetector
from seatrial.monitoring.change_space import change_space
from seatrial.monitoring.recent_log import RecentLog
from seatrial.monitoring.running_likelihood import RunningLikelihood
from seatrial.onboard.boat_change import ChangeState
from seatrial.onboard.live.protocol import NANO

model, drives = known_model, drives_by_cause


def test_the_next_test_follows_a_clock_that_is_set_back(model, drives):
    rows = sent(drives[NO_CHANGE].cut(0.0, 30.0))
    detector = ChangeDetector(model)
    for stamp, kind, values in rows:
        ahead = 3600 * NANO if 5 * NANO < stamp - rows[0][0] < 6 * NANO else 0
        detector.use(kind, stamp + ahead, values)
        detector.look()
    assert detector._next is not None
    assert detector._next <= rows[-1][0] + 2 * NANO


@pytest.mark.parametrize(
    "gap", [10, *(pytest.param(s, marks=pytest.mark.system) for s in (3, 35, 120))]
)
def test_a_pause_of_the_poses_does_not_end_the_test(model, drives, gap):
    """Lifted out, loaded, put back: the change is noticed after the pause."""
    before = sent(drives[NO_CHANGE].cut(0.0, 15.0))
    changed = sent(drives[BATTERY].cut(0.0, 40.0))
    shift = before[-1][0] + gap * NANO - changed[0][0]
    detector = ChangeDetector(model)
    assert not findings(detector, before)
    after = findings(detector, [(t + shift, kind, values) for t, kind, values in changed])
    assert [change.state for change in after] == [ChangeState.NOTICED]
    assert (after[0].stamp - changed[0][0] - shift) / NANO < 30.0


def test_running_filters_begin_again_where_the_boat_diverges(model, drives, monkeypatch):
    """There are windows again of the poses after that, and of no earlier ones."""
    space, log = change_space(model), RecentLog(model.vehicle, 60.0)
    rows = sent(drives[NO_CHANGE].cut(0.0, 24.0))
    for stamp, kind, values in rows:
        log.add(kind, stamp, values)
    origin, now = rows[0][0], rows[-1][0]
    running = RunningLikelihood(model, space.wider, space.theta, 42.0)
    true_sums = RunningLikelihood._sums

    def sums(self):
        found = true_sums(self)
        return (replace(found[0], cost=np.inf), *found[1:]) if diverges else found

    monkeypatch.setattr(RunningLikelihood, "_sums", sums)
    for stamp in range(origin, now, 2 * NANO):
        diverges = origin + 9 * NANO < stamp < origin + 11 * NANO
        running.advance(log, origin, stamp)
    assert running.window(origin + 9 * NANO, 20) is not None
    assert running.window(origin + 5 * NANO, 20) is None


def test_rows_of_a_clock_that_is_set_back_do_not_mix_with_later_ones(model, drives):
    """By 30 s: when the stamps come by again, the rows of the first time are gone."""
    first = sent(drives[NO_CHANGE].cut(0.0, 30.0))
    later = sent(drives[BATTERY].cut(0.0, 75.0))
    shift = first[0][0] - later[0][0]
    detector = ChangeDetector(model)
    assert not findings(detector, first)
    after = findings(detector, [(t + shift, kind, values) for t, kind, values in later])
    assert [change.state for change in after] == [ChangeState.NOTICED, ChangeState.CONFIRMED]


def test_a_change_is_not_withdrawn_for_want_of_poses(model, drives):
    rows, detector = sent(drives[NO_CHANGE].cut(0.0, 20.0)), ChangeDetector(model)
    findings(detector, rows)
    detector._noticed = rows[-1][0]  # and no pose for a minute
    after = [(stamp + 80 * NANO, kind, values) for stamp, kind, values in rows]
    assert not findings(detector, after[: len(after) // 20])
    assert detector._noticed > rows[-1][0]


def test_the_log_keeps_the_last_seconds_only(model):
    log = RecentLog(model.vehicle, 5.0)
    for i in range(2000):
        stamp = i * NANO // 50
        log.add("pose", stamp, [0.01 * i, 0.0, 0.0])
        log.add("command", stamp, [0.1, 0.0, 0.0])
    log.add("pose", 2000 * NANO // 50, [np.nan, 0.0, 0.0])
    recording = log.recording(0, 1999 * NANO // 50)
    assert 5.0 <= recording.duration < 5.1
    assert log.newest == 1999 * NANO // 50


def test_late_rows_take_their_place(model, drives):
    rows = sent(drives[NO_CHANGE].cut(0.0, 10.0))
    late = [*rows]
    for i in range(10, len(rows) - 3, 7):
        late[i], late[i + 2] = late[i + 2], late[i]
    in_order, shuffled = RecentLog(model.vehicle, 60.0), RecentLog(model.vehicle, 60.0)
    for log, some in ((in_order, rows), (shuffled, late)):
        for stamp, kind, values in some:
            log.add(kind, stamp, values)
    a, b = (log.recording(rows[0][0], rows[-1][0]) for log in (in_order, shuffled))
    np.testing.assert_array_equal(a.eta, b.eta)
    np.testing.assert_array_equal(a.commands.values, b.commands.values)
