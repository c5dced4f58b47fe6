# SPDX-License-Identifier: MIT
"""The estimate while the boat drives is that of `identify` on what was driven."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from conftest import at_length

import seatrial
from seatrial.identification.first_search import maximised
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.growing_filter import GrowingFilter
from seatrial.identification.problem_setup import problem_with
from seatrial.identification.selection.actuator_stages import with_estimated_stages
from seatrial.identification.selection.terms.candidates import with_usual_terms
from seatrial.identification.solution import OutputErrorSettings
from seatrial.identification.uncertainty.covariance import SHORTEST_BLOCK
from seatrial.poolside import live_estimator, live_solution
from seatrial.poolside.drive_log import DriveLog, SignalRows
from seatrial.poolside.live_estimator import LiveEstimator
from seatrial.poolside.live_prediction import LivePrediction
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.util.errors import RecordingError
from tests.boats.live_drives import holonomic, rows, twin_in_wind

SECOND = 1_000_000_000  # [ns]
SELDOM = 3 * SECOND  # where the estimate at the end counts, and not those before
DRIVES = {"holonomic": holonomic, "twin in wind": twin_in_wind}


@pytest.fixture(scope="module", params=["holonomic", at_length("twin in wind")])
def drive(request):
    """The vehicle and a recording of three minutes."""
    return DRIVES[request.param](180.0, seed=5, rate=10.0)


@pytest.fixture(scope="module")
def whole(drive, once):
    """The model by `identify` of all of it."""
    vehicle, recording = drive
    return once(f"live-{vehicle.name}", lambda _: seatrial.identify([recording], vehicle))[1]


def live(estimator, found, every=SECOND // 2):
    """The estimator after these rows, at work every so often; how often the estimate changed."""
    due = changes = 0
    for stamp, kind, values in found:
        estimator.use(kind, stamp, values)
        if stamp >= due:
            changes += estimator.work()
            due = stamp + every
    return changes + estimator.work(ended=True)


def apart(model, other):
    """Distance in the other's standard errors, of every estimated parameter."""
    values, expected = (np.concatenate([m.coefficients, m.constants]) for m in (model, other))
    errors = np.array(list(other.standard_errors.values()))
    return np.abs(values - expected)[errors > 0] / errors[errors > 0]


@pytest.mark.system
def test_the_estimate_at_the_end_is_that_of_identify(drive, whole):
    vehicle, recording = drive
    estimator = LiveEstimator(vehicle)
    changes = live(estimator, rows(recording))
    model = estimator.model()
    assert estimator.problem == ""
    assert estimator.lag == 0.0
    assert changes > 200  # twice a second, from the first estimate on
    assert model.parameters == whole.parameters
    assert apart(model, whole).max() < 0.1
    ratio = np.sqrt(np.diag(model.covariance)[:7] / np.diag(whole.covariance)[:7])
    assert np.all((ratio > 0.8) & (ratio < 1.25))


@pytest.mark.system
def test_effects_are_those_of_identify():
    vehicle, recording = twin_in_wind(150.0, seed=6, rate=10.0)
    estimator = LiveEstimator(vehicle, effects=("wind",))
    live(estimator, rows(recording), SELDOM)
    whole = seatrial.identify([recording], vehicle, effects=("wind",))
    assert apart(estimator.model(), whole).max() < 0.1
    (entry,), (expected,) = estimator.model().recordings, whole.recordings
    for name, value in expected.effects.items():
        assert entry.effects[name] == pytest.approx(value, abs=0.5 * expected.errors[name])


def test_the_log_is_the_recording(drive):
    vehicle, recording = drive
    log = DriveLog(vehicle)
    shuffled = list(rows(recording))
    for i in range(0, len(shuffled) - 7, 7):  # late by some rows
        shuffled[i], shuffled[i + 5] = shuffled[i + 5], shuffled[i]
    for stamp, kind, values in shuffled:
        assert log.add(kind, stamp, values)
    found = log.recording()
    for name in ("stamps", "raw", "eta", "valid", "segment"):
        np.testing.assert_array_equal(getattr(found, name), getattr(recording, name))
    np.testing.assert_array_equal(found.commands.stamps, recording.commands.stamps)
    np.testing.assert_array_equal(found.commands.values, recording.commands.values)
    assert found.faults == recording.faults


def test_the_log_takes_the_lever_arm_off():
    vehicle, recording = holonomic(20.0, seed=1)
    lever = np.array([0.3, -0.1])
    log = DriveLog(vehicle.with_lever((0.3, -0.1)))
    for stamp, kind, values in rows(recording):
        if kind == "pose":
            c, s = np.cos(values[2]), np.sin(values[2])
            log.add(kind, stamp, values + np.append(np.array([[c, -s], [s, c]]) @ lever, 0.0))
        else:
            log.add(kind, stamp, values)
    np.testing.assert_allclose(log.recording().eta, recording.eta, atol=1e-12)


def test_positions_and_headings_of_their_own_rates_are_one_recording():
    vehicle, recording = holonomic(60.0, seed=1, rate=10.0)
    estimator = LiveEstimator(vehicle)
    found = []
    for stamp, kind, values in rows(recording):
        if kind == "pose":
            found += [
                (stamp, "position", values[:2]),
                (stamp + SECOND // 40, "heading", values[2:]),
            ]
        else:
            found.append((stamp, kind, values))
    live(estimator, sorted(found, key=lambda r: r[0]), SELDOM)
    assert estimator.log.recording().asynchronous is not None
    assert estimator.model() is not None, estimator.problem
    assert estimator.model().values["X_F"] > 0.0


def test_rows_that_are_not_finite_are_dropped():
    vehicle, _ = holonomic(5.0, seed=1)
    log = DriveLog(vehicle)
    assert not log.add("pose", 1, (0.0, np.nan, 0.0))
    assert not log.add("command", 1, (np.inf, 0.0, 0.0))
    assert log.poses == log.rows("command") == 0
    assert log.span is None


def test_the_oldest_rows_make_room_and_it_is_stated():
    vehicle, recording = holonomic(60.0, seed=1)
    log = DriveLog(vehicle, most_rows=500)
    for stamp, kind, values in rows(recording):
        log.add(kind, stamp, values)
    assert log.poses <= 500 and log.rows("command") <= 500
    assert log.bytes <= 2 * 500 * (5 * 8 + 5 * 8)
    assert "dropped" in log.message and "500 rows" in log.message
    assert log.span[1] == recording.stamps[-1]
    assert log.recording().stamps[-1] == recording.stamps[-1]


@pytest.mark.system
@pytest.mark.parametrize("clock", ["set", "one pose"])
def test_a_clock_that_jumps_does_not_end_the_estimate(clock):
    vehicle, recording = holonomic(120.0, seed=5, rate=10.0)
    found = list(rows(recording))
    begin, jump = found[0][0], 50_000_000 * SECOND
    if clock == "set":  # a computer without a battery gets its time from the network
        found = [(s - jump * (s < begin + 5 * SECOND), *rest) for s, *rest in found]
    else:
        at = next(
            i for i, row in enumerate(found) if row[0] > begin + 5 * SECOND and row[1] == "pose"
        )
        found[at] = (found[at][0] + jump, *found[at][1:])
    estimator = LiveEstimator(vehicle)
    for i, (stamp, kind, values) in enumerate(found):
        estimator.use(kind, stamp, values)
        if i % 200 == 0:
            estimator.work()
    assert estimator.log.length == pytest.approx(120.0, abs=10.0)
    assert estimator.lag < 10.0
    assert estimator.model() is not None, estimator.problem
    whole = seatrial.identify([estimator.log.recording()], vehicle)
    assert apart(estimator.model(), whole).max() < 1.0


def test_equal_stamps_stay_in_the_order_of_arrival():
    found = SignalRows(1)
    for stamp, value in ((2, 1.0), (2, 2.0), (1, 0.0), (2, 3.0), (1, 0.5)):
        found.add(stamp, np.array([value]))
    assert found.stamps.tolist() == [1, 1, 2, 2, 2]
    assert found.between(1, 2)[1][:, 0].tolist() == [0.0, 0.5, 1.0, 2.0, 3.0]
    assert found.holding(2, 2)[0].tolist() == [2, 2, 2]


@pytest.mark.parametrize("effects", [(), ("current", "lever")])
def test_the_filter_in_parts_has_the_sums_of_the_whole(effects):
    vehicle, recording = twin_in_wind(90.0, seed=2)
    begin = [recording.cut(None, 60.0)]
    whole, _ = with_estimated_stages(vehicle, begin)
    problem = problem_with(whole, vehicle, begin, OutputErrorSettings(effects=effects))
    problem = replace(problem, block=SHORTEST_BLOCK)
    at = maximised(problem, begin, None, hold=False)
    log = DriveLog(vehicle)
    for stamp, kind, values in rows(recording):
        log.add(kind, stamp, values)
    problem, newest = at.runs.problem, int(recording.stamps[-1])
    going = GrowingFilter(problem, at.theta, at.noise)
    going.begin(recording.origin + 55 * SECOND)
    for until in range(recording.origin + 56 * SECOND, newest + SECOND, SECOND // 3):
        going.advance(log.recording(log.before(going.newest, 100)), until)
    same = replace(problem, recordings=(log.recording(),))
    whole, parts = filter_along(same, at.theta, at.noise), going.at().runs
    assert going.newest == newest
    assert parts.cost == pytest.approx(whole.cost, rel=1e-10)
    np.testing.assert_allclose(parts.gradient, whole.gradient, rtol=1e-8, atol=1e-6)
    np.testing.assert_allclose(parts.information, whole.information, rtol=1e-8)
    np.testing.assert_allclose(going.state, whole.by_recording[0].state[-1], rtol=1e-8, atol=1e-10)


@pytest.mark.system
def test_of_a_long_drive_the_older_half_is_condensed(monkeypatch):
    monkeypatch.setattr(live_solution, "MOST_SEARCHED", 750)
    monkeypatch.setattr(live_estimator, "MOST_THOROUGH", 700)
    vehicle, recording = holonomic(240.0, seed=7, rate=10.0)
    estimator = LiveEstimator(vehicle)
    live(estimator, rows(recording))
    whole = seatrial.identify([recording], vehicle)
    searched = estimator._solution.fit.problem
    assert searched.prior is not None
    assert len(searched.recordings[0].t) < 1000 < len(recording.t)
    assert apart(estimator.model(), whole).max() < 0.5
    ratio = np.sqrt(np.diag(estimator.model().covariance)[:12] / np.diag(whole.covariance)[:12])
    assert np.all((ratio > 0.7) & (ratio < 1.4))


@pytest.mark.system
def test_a_discarded_interval_does_not_count():
    vehicle, recording = holonomic(110.0, seed=8, rate=10.0)
    touched = recording.raw.copy()
    during = (recording.t > 80.0) & (recording.t < 90.0)
    touched[during, :2] += 0.2 * np.sin(3.0 * recording.t[during])[:, None]
    estimator = LiveEstimator(vehicle)
    live(estimator, rows(replace(recording, raw=touched)), SELDOM)
    off = estimator.model()
    first, last = (recording.origin + round(s * SECOND) for s in (79.9, 90.1))
    estimator.discard(first, last)
    assert estimator.work()
    left = estimator.log.recording()
    assert FaultKind.EXCLUDED in {f.kind for f in left.faults}
    clean = seatrial.identify([recording], vehicle)
    kept = seatrial.identify([left], vehicle)
    assert apart(estimator.model(), kept).max() < 0.1
    assert apart(estimator.model(), clean).max() < apart(off, clean).max()


@pytest.mark.system
def test_what_hinders_the_estimate_is_stated():
    vehicle, recording = holonomic(60.0, seed=9, rate=10.0)
    estimator = LiveEstimator(vehicle)
    assert "Drive pulses" in estimator.problem
    assert not estimator.work()
    found = list(rows(recording))
    # a boat that waits, and no commands at all
    live(estimator, (r for r in found if r[1] == "pose"))
    assert estimator.model() is None
    assert "no commands" in estimator.problem
    # commands of one axis only
    estimator = LiveEstimator(vehicle)
    live(estimator, ((s, k, v * [1, 0, 0] if k == "command" else v) for s, k, v in found))
    assert estimator.model() is None
    assert "sway is never excited" in estimator.problem
    # the drive begins in earnest later: the estimate comes
    later = holonomic(120.0, seed=10, rate=10.0)[1]
    shift = int(recording.stamps[-1]) + SECOND
    live(estimator, ((s + shift, k, v) for s, k, v in rows(later)), SELDOM)
    assert estimator.problem == ""
    assert estimator.model() is not None


def test_of_an_automatic_structure_the_usual_terms_are_estimated():
    vehicle, recording = holonomic(90.0, seed=13, rate=10.0)
    estimator = LiveEstimator(vehicle.with_automatic_structure())
    live(estimator, rows(recording))
    model = estimator.model()
    assert model is not None, estimator.problem
    usual = with_usual_terms(vehicle.with_automatic_structure())
    assert model.structure.coefficients == usual.structure.coefficients
    assert apart(model, seatrial.identify([recording], usual)).max() < 0.1


@pytest.mark.system
def test_a_start_model_is_the_estimate_until_there_is_one():
    vehicle, recording = holonomic(120.0, seed=11, rate=10.0)
    known = seatrial.identify([holonomic(150.0, seed=12, rate=10.0)[1]], vehicle)
    estimator = LiveEstimator(vehicle, start=known)
    assert estimator.model() is known
    live(estimator, rows(recording), SELDOM)
    assert apart(estimator.model(), seatrial.identify([recording], vehicle)).max() < 0.1


def test_rows_come_in_while_a_thread_works(drive):
    vehicle, recording = drive
    estimator, ended = LiveEstimator(vehicle), threading.Event()

    def work():
        while not ended.is_set():
            estimator.work()
            ended.wait(0.001)

    worker = threading.Thread(target=work)
    worker.start()
    for stamp, kind, values in rows(recording, until=120.0):
        estimator.use(kind, stamp, values)
    while estimator.work(ended=True):
        pass
    ended.set()
    worker.join()
    estimator.work(ended=True)
    assert estimator.model() is not None, estimator.problem
    with pytest.raises(RecordingError):
        estimator.log.recording(0, 1)


def test_predictions_are_as_good_as_the_model_states(drive, whole):
    _, recording = drive
    prediction = LivePrediction()
    assert prediction.states() == ()
    prediction.reload(whole)
    for stamp, kind, values in rows(recording):
        prediction.use(kind, stamp, values)
    states = prediction.states()
    assert [s.axis for s in states] == ["surge", "sway", "yaw"]
    for state in states:
        assert len(state.t) == len(state.predicted) == len(state.measured) == 240
        assert state.t[-1] - state.t[0] == pytest.approx(60.0, abs=1.0)
        assert state.t[-1] > recording.duration - 1.0
        assert state.rms < 0.7 * state.constant
        assert 0.6 < state.rms / state.expected < 1.6
        assert np.sqrt(np.mean(np.subtract(state.predicted, state.measured) ** 2)) == pytest.approx(
            state.rms
        )
    # where the boat was touched, none counts that reaches into it; those after it do
    first = next(stamp for stamp, kind, _ in rows(recording) if kind == "pose")
    prediction.discard(first + 150 * SECOND + 1, first + 160 * SECOND + 1)
    left = tuple(t for t in states[0].t if t <= 150.0 or t > 161.0)
    assert prediction.states()[0].t == left != states[0].t
