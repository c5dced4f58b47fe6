# SPDX-License-Identifier: MIT
"""The test for a change of the boat where poses do not count, or do not tell: what is left out is no evidence."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from changed_boats import drives_by_cause, findings, known_model, sent

from seatrial.evaluation.comparison.cause_candidates import BATTERY, NO_CHANGE, ONE_THRUSTER
from seatrial.monitoring import change_test
from seatrial.monitoring.change_detector import CONFIRMATION, CONFIRMED, PASSING, ChangeDetector
from seatrial.monitoring.change_space import THRUSTER_CHANGE, change_space
from seatrial.monitoring.change_test import (
    fitted_changes,
    linear_evidences,
    linearised,
    log_ratio,
    mean_over_noises,
)
from seatrial.monitoring.recent_log import RecentLog
from seatrial.monitoring.window_likelihood import Quadratic, Window, windows
from seatrial.onboard.boat_change import ChangeState
from seatrial.util.frames import NS_PER_S
from seatrial.util.progress import show_progress
from tests.boats.scenes import vehicle_of
from tests.boats.weather import towed

model, drives = known_model, drives_by_cause
# [s]: tests are at 16.3 s and 18.3 s
TOWED_FROM, TOWED_TO, LONGER, SECONDS = 16.4, 18.2, 25.0, 40.0


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


def diverging(plain, least):
    """`Window.quadratic` of a boat that diverges in windows longer than `least` [s]."""

    def quadratic(self, boat, theta):
        return None if self.recording.duration > least else plain(self, boat, theta)

    return quadratic


def test_a_change_in_which_the_model_diverges_is_not_withdrawn(model, drives, monkeypatch):
    """The boat changed so much that nothing can be fitted to the window after the notice: the next one tells."""
    rows = sent(drives[BATTERY])
    before, after = split(rows, PASSING + CONFIRMATION + 3.0)
    detector = ChangeDetector(model)
    detector._noticed = rows[0][0]
    plain = Window.quadratic
    monkeypatch.setattr(Window, "quadratic", diverging(plain, CONFIRMATION - 1.0))
    assert not findings(detector, before)
    assert detector._noticed > rows[0][0]
    monkeypatch.setattr(Window, "quadratic", plain)
    assert [one.state for one in findings(detector, after)] == [ChangeState.CONFIRMED]


def test_where_the_unchanged_boat_can_not_be_fitted_nothing_is_compared(model, drives, monkeypatch):
    space = change_space(model)
    several = windows(model, drives[NO_CHANGE].cut(10.0, 20.0))[:1]
    quadratics = linearised(space, several)
    assert {NO_CHANGE, BATTERY} < {
        one.change.cause for one in fitted_changes(space, several, quadratics, 1)
    }
    plain = change_test._fitted
    monkeypatch.setattr(
        change_test, "_fitted",
        lambda space, change, *rest: None if change.cause == NO_CHANGE else plain(space, change, *rest),
    )  # fmt: skip
    assert fitted_changes(space, several, quadratics, 1) == []


class Known:
    """A window that knows one parameter alone, to a standard error, whatever the boat."""

    def __init__(self, space, place, value, error):
        self.at, self.place, self.value, self.error = space.theta, place, value, error

    def quadratic(self, _boat, theta):
        information = np.zeros((len(theta), len(theta)))
        information[self.place, self.place] = self.error**-2.0
        return Quadratic(theta, 0.0, information @ (self._moved() - theta), information)

    def _moved(self):
        moved = self.at.copy()
        moved[self.place] = self.value
        return moved


@pytest.mark.parametrize(("gain", "size"), [(0.5, -0.48), (0.1, -0.87), (-0.3, -1.0)])
def test_a_thruster_that_gives_nothing_has_an_interval_too(model, gain, size):
    """Below no thrust there is nothing: the error is that of the side on which the thruster may be."""
    space = change_space(model)
    error = 0.1
    (place,) = [space.gains["F_2"]]
    window = Known(space, place, gain, error)
    start = window.quadratic(None, space.theta)
    change = next(c for c in space.changes if c.cause == ONE_THRUSTER and c.what == "F_2")
    found = change_test._fitted(space, change, window, start)
    assert found.size == pytest.approx(size, abs=0.01)
    # a normal prior of the size, and a measurement of it
    assert found.error == pytest.approx((THRUSTER_CHANGE**-2.0 + error**-2.0) ** -0.5, rel=1e-3)
    assert found.covariance[place, place] == pytest.approx(found.error**2, rel=1e-3)


def test_rows_that_come_while_others_are_dropped_are_kept():
    """The source's thread adds rows, that of the test drops those of a clock that was set back."""
    log, added = RecentLog(vehicle_of("MP"), 1e6), threading.Event()

    def add():
        for i in range(10_000):
            log.add("pose", i, np.zeros(3))
        added.set()

    thread = threading.Thread(target=add)
    thread.start()
    while not added.is_set():
        log.drop_after(10_000)  # none of them
    thread.join()
    assert len(log._rows["pose"]) == 10_000


def test_a_test_for_a_change_can_be_ended_at_each_of_its_steps(model, drives):
    """A server that ends does not wait for it: a step is one filter's run at most."""
    rows, steps = sent(drives[BATTERY].cut(0.0, 40.0)), [0]
    detector = ChangeDetector(model)
    with show_progress(lambda _: steps.append(steps.pop() + 1)):
        for stamp, kind, values in rows:
            detector.use(kind, stamp, values)
            if detector.look() is not None:
                break
            steps.append(0)
    # the full test of the window that shows the change: each noise, then each change
    assert steps[-1] > 2 * len(change_space(model).changes)


def test_errors_of_a_model_that_its_covariance_states_are_no_change(model, drives):
    """A short recording's model is off by far more than a long one's: both hypotheses have its errors.

    Odds of 20 to 1 are exceeded by chance in one of 20 at the most.
    """
    recording = drives[NO_CHANGE].cut(20.0, 60.0)
    wide, ratios = 49.0 * model.covariance, []  # as of a recording that is as much shorter
    values, vectors = np.linalg.eigh(wide)
    n = len(model.coefficients)
    for seed in range(20):
        draw = np.random.default_rng(seed).normal(size=len(values))
        off = vectors @ (np.sqrt(np.maximum(values, 0.0)) * draw)
        moved = replace(model, coefficients=model.coefficients + off[:n])
        found = []
        for covariance in (wide, model.covariance):
            space = change_space(replace(moved, covariance=covariance))
            quadratics = linearised(space, windows(space.own, recording)[:3])
            logs = linear_evidences(space, quadratics)
            found.append(log_ratio(mean_over_noises(space, logs)))
        ratios.append(found)
    stated, ignored = np.array(ratios).T
    assert np.count_nonzero(stated > CONFIRMED) <= 1
    assert np.median(ignored) > CONFIRMED
