# SPDX-License-Identifier: MIT
"""A session's threads: what the page sees of events, marks, discards, faults; and the end, with fakes for the rest."""

import threading
import time
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from waiting import PATIENCE, until

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.poolside.coverage import Coverage
from seatrial.poolside.session.body_velocity import BodyVelocity
from seatrial.poolside.session.live_session import ENDED, Session
from seatrial.poolside.session.parts import Advice, Parts
from seatrial.poolside.session.track import MOST_ROWS, Track
from seatrial.poolside.session.turn import Turn
from seatrial.poolside.sources import SourceEvent
from seatrial.util.errors import FileError, LiveError, RecordingError
from seatrial.util.progress import stage, step

SECOND = 1_000_000_000  # [ns]
ROW = np.array([1.0, 2.0, 0.5])


@pytest.fixture
def vehicle():
    return seatrial.load_vehicle("mallard-mp")


class Queue:
    """A source that the test fills."""

    name, by_columns, problems, behind = "queue", False, (), 0.0
    fault = None  # at the end

    def __init__(self):
        self.events, self.changed, self.closed = [], threading.Condition(), False

    def put(self, *events):
        with self.changed:
            self.events += events
            self.changed.notify_all()

    def __iter__(self):
        while True:
            with self.changed:
                self.changed.wait_for(lambda: self.events or self.closed)
                if not self.events and self.fault is not None:
                    raise self.fault
                if not self.events:
                    return
                event = self.events.pop(0)
            yield event

    def close(self):
        with self.changed:
            self.closed = True
            self.changed.notify_all()

    def now(self):
        return time.time_ns()


class Parted:
    """A session whose parts note what they get."""

    def __init__(self, vehicle, folder, save=None, copy=None):
        self.used, self.notes = [], []
        self.fault, self.advice = None, Advice()
        note = self.notes
        estimator = SimpleNamespace(
            use=lambda *given: self.used.append(given), discard=lambda *given: note.append(("estimate", *given)),
            work=self._work, model=lambda: None, problem="", lag=0.0, trust=1.0, whole=True,
            log=SimpleNamespace(recording=self._recording, doubt="", coarse=False),
        )  # fmt: skip
        recorder = SimpleNamespace(
            use=self._record, mark=lambda *given: note.append(("mark", *given)),
            discard=lambda *given: note.append(("recording", *given)),
            finish=lambda: note.append(("finish",)) or folder / "recording", close=lambda: note.append(("close",)),
        )  # fmt: skip
        health = SimpleNamespace(
            use=lambda *_: None,
            states=lambda _: (),
            check=lambda *_: None,
            remark=lambda *_, **__: None,
        )
        self.looks = []
        prediction = SimpleNamespace(
            use=lambda *_: None, reload=lambda _: None, states=lambda: self.looks.append(1) or (),
            discard=lambda *given: note.append(("prediction", *given)),
        )  # fmt: skip
        detector = SimpleNamespace(
            use=lambda *_: None, due=False, begin_after=lambda *given: note.append(("detector", *given)),
        )  # fmt: skip
        self.source, self.parts_estimator, self.recorder = Queue(), estimator, recorder
        self.health = health
        parts = Parts(
            self.source, estimator, health, recorder, prediction, Coverage(vehicle),
            SimpleNamespace(advise=lambda *_: self.advice), detector,
        )  # fmt: skip
        save = save or (lambda _: {"model": "m.yaml"})
        self.session = Session(vehicle, parts, folder, save=save, copy=copy)
        self.session.start()

    def _work(self, **_):
        if self.fault is not None:
            raise self.fault
        return False

    def _record(self, *_):
        if isinstance(self.fault, FileError):
            raise self.fault

    def _recording(self):
        raise RecordingError("too short")

    def drive(self, count, start=0):
        self.source.put(
            *(
                SourceEvent("pose", (start + i) * SECOND // 10, ROW + 0.01 * i, i)
                for i in range(count)
            )
        )

    def until(self, wanted):
        until(lambda: wanted(self.session.state()), self.session.state)


@pytest.fixture
def parted(vehicle, tmp_path):
    made = []

    def make(**settings):
        made.append(Parted(vehicle, tmp_path, **settings))
        return made[-1]

    yield make
    for one in made:
        one.session.close()


def test_events_are_seen_at_once(parted):
    one = parted()
    assert one.session.state().pose is None
    one.drive(51)
    one.until(lambda state: state.poses == 51)
    state = one.session.state()
    assert state.pose == pytest.approx((1.5, 2.5, 1.0))
    assert state.time == pytest.approx(5.0)
    assert len(one.used) == 51
    following, rows = one.session.track(0)
    assert following == len(rows) == 26  # every 0.2 s
    assert rows[1] == pytest.approx((0.2, 1.02, 2.02, 0.52))
    assert one.session.track(25) == (26, rows[25:])


def test_marks_and_discards_reach_recording_and_estimate(parted):
    one = parted()
    with pytest.raises(LiveError, match="no pose"):
        one.session.mark("early")
    one.drive(101)
    one.until(lambda state: state.poses == 101)
    one.session.mark("gust")
    assert one.session.state().marks == ((10.0, "gust"),)
    one.session.discard(4.0)
    now = 10 * SECOND
    start = now - 4 * SECOND
    assert one.notes == [
        ("mark", now, "gust"), ("estimate", start, now), ("prediction", start, now), ("detector", now),
        ("recording", start, now),
    ]  # fmt: skip
    assert one.session.state().discards == 1
    assert one.session.track(0)[1][-1][0] < 6.0


def test_page_and_source_go_on_while_the_recording_discards(parted):
    """The disk is slow: whole tables are written."""
    one, begun, written = parted(), threading.Event(), threading.Event()
    one.recorder.discard = lambda *_: begun.set() or written.wait(PATIENCE)
    one.drive(101)
    one.until(lambda state: state.poses == 101)
    discarding = threading.Thread(target=one.session.discard, args=(4.0,))
    discarding.start()
    assert begun.wait(PATIENCE)
    one.drive(20, start=101)
    one.until(lambda state: state.poses == 121)
    assert one.session.state().discards == 1
    times = [row[0] for row in one.session.track(0)[1]]
    assert not [t for t in times if 6.0 <= t <= 10.0] and max(times) > 11.0
    assert discarding.is_alive()
    written.set()
    discarding.join(PATIENCE)


def test_faults_of_other_threads_do_not_end_the_one_that_states_them(parted):
    """A fault that comes while the others are being listed."""

    class Growing(dict):
        def items(self):
            for pair in super().items():
                yield pair
                self[f"{pair[0]} again"] = "by a test"

    one = parted()
    one.session._failed = Growing(event="by a test")
    one.until(lambda state: "event: by a test" in state.message)
    one.session._failed = {}
    one.until(lambda state: state.message == "")


def test_discarded_seconds_are_not_driven_and_not_covered(parted, vehicle):
    one = parted()
    command = np.array([1.0, 0.0, 0.0])
    for i in range(101):
        one.source.put(
            SourceEvent("command", i * SECOND // 10, command, i),
            SourceEvent("pose", i * SECOND // 10, ROW + 0.01 * i, i),
        )
    one.until(lambda state: state.poses == 101 and state.coverage)
    one.until(lambda state: sum(map(sum, state.coverage[0].seconds)) > 9.0)
    assert one.session.state().driven == pytest.approx(10.0)
    one.session.discard(4.0)
    one.until(lambda state: sum(map(sum, state.coverage[0].seconds)) < 7.0)
    assert one.session.state().driven == pytest.approx(6.0, abs=0.25)
    assert sum(map(sum, one.session.state().coverage[0].seconds)) == pytest.approx(5.6, abs=1.1)


def test_a_computer_that_falls_behind_is_named_and_not_the_sender(parted):
    one = parted()
    one.drive(3)
    given = []
    one.health.states = lambda now: given.append(now) or ()
    one.source.behind = 3.0
    one.until(lambda state: "this computer is 3.0 s behind" in state.message)
    assert time.time_ns() - given[-1] > 2 * SECOND  # signals are judged at what is used
    one.source.behind = 0.0
    one.until(lambda state: state.message == "")


def test_poses_and_predictions_go_on_while_a_search_runs(parted):
    one = parted()
    begun, searched = threading.Event(), threading.Event()

    def search(**_):
        begun.set()
        searched.wait(PATIENCE)
        return False

    one.parts_estimator.work = search
    assert begun.wait(PATIENCE)
    one.drive(51)
    one.until(lambda state: state.poses == 51)
    looked = len(one.looks)
    one.until(lambda _: len(one.looks) > looked + 2)
    assert one.session.track(0)[0] == 26
    searched.set()


def test_a_bag_that_can_not_be_written_leaves_recording_and_model(parted):
    def copy(_):
        raise FileError("recording.mcap: stamps begin at -1 s")

    one = parted(copy=copy)
    one.drive(3)
    one.until(lambda state: state.poses == 3)
    assert set(one.session.stop()) == {"recording", "model"}
    assert "no mcap: recording.mcap: stamps begin at -1 s" in one.session.state().message
    other = parted(copy=lambda _: {"mcap": "recording.mcap"})
    assert set(other.session.stop()) == {"recording", "mcap", "model"}


def test_what_fails_is_stated_and_all_else_goes_on(parted):
    one = parted()
    one.drive(2)
    one.fault = ZeroDivisionError("by a test")
    one.until(lambda state: "estimate: by a test" in state.message)
    one.fault = FileError("poses.csv: can't be written (No space left on device)")
    one.drive(3, start=2)
    one.until(lambda state: [s.level for s in state.signals] == ["error"])
    (signal,) = one.session.state().signals
    assert (signal.name, signal.finding) == ("recording", str(one.fault))
    one.fault = None
    one.drive(3, start=5)
    one.until(lambda state: state.message == "" and state.signals == () and state.poses == 8)


def test_the_end_of_the_source_is_stated(parted):
    one = parted()
    one.drive(3)
    one.source.close()
    one.until(lambda state: state.message == ENDED)
    assert one.session.drained


@pytest.mark.parametrize("fault", [FileError("poses.csv: became shorter"), KeyError("x")])
def test_a_source_that_fails_is_stated(parted, fault):
    one = parted()
    one.source.fault = fault
    one.drive(3)
    one.source.close()
    one.until(lambda state: str(fault) in state.message)
    assert "source failed" in one.session.state().message
    assert one.session.state().poses == 3


def test_a_fault_of_the_program_ends_no_thread(parted):
    one = parted()
    one.fault = IndexError("by a test")
    one.until(lambda state: "IndexError: by a test" in state.message)
    one.fault = None
    one.until(lambda state: state.message == "")


def test_an_event_that_fails_ends_no_source(parted):
    one = parted()
    take = one.parts_estimator.use

    def use(kind, stamp, values):
        if stamp == 0:
            raise TypeError("by a test")
        take(kind, stamp, values)

    one.parts_estimator.use = use
    one.drive(4)
    one.until(lambda state: state.poses == 4)
    one.source.close()
    one.until(lambda state: state.message == ENDED)
    assert len(one.used) == 3


def test_rows_that_had_arrived_are_recorded_at_the_end(parted):
    one, recorded = parted(), []
    one.recorder.use = lambda *given: recorded.append(given) or time.sleep(0.001)
    one.drive(200)
    one.session.stop()
    assert len(recorded) == 200


def test_the_recording_does_not_end_before_the_rows_that_had_arrived(parted, monkeypatch):
    """A large table that was begun just before, on a slow disk: each time that is waited for takes 20 rows."""
    one, some = parted(), threading.Semaphore(0)
    notes, source = one.notes, one.session._threads[0]
    one.recorder.use = lambda *_: some.acquire() and notes.append("row")
    one.drive(200)

    def join(_):
        wanted = notes.count("row") + 20
        some.release(20)
        until(lambda: notes.count("row") == wanted < 200 or not source.is_alive())

    monkeypatch.setattr(source, "join", join)
    one.session.stop()
    assert notes.count("row") == 200 and notes[-1] == ("finish",)


def test_stop_saves_once_and_shows_its_progress(parted):
    seen = []

    def save(folder):
        with stage("identifying", 0.5):
            seen.append(one.session.state().saving)
        seen.append(one.session.state().saving)
        return {"model": str(folder.parent / "model.yaml")}

    one = parted(save=save)
    one.drive(3)
    one.until(lambda state: state.poses == 3)
    threads = [threading.Thread(target=one.session.stop) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert one.notes.count(("finish",)) == 1
    assert [text.partition(" (")[2] for text in seen] == ["0 %)", "50 %)"]
    assert seen[0] == "identifying (0 %)"
    state = one.session.state()
    assert state.stopped and not state.saving
    assert one.session.stop() == dict(state.saved)
    assert set(dict(state.saved)) == {"recording", "model"}
    with pytest.raises(LiveError, match="over"):
        one.session.discard(1.0)


@pytest.mark.parametrize("fault", [RecordingError, KeyError])
def test_a_drive_without_a_model_keeps_its_recording(parted, fault):
    def save(_):
        raise fault("too short")

    one = parted(save=save)
    assert set(one.session.stop()) == {"recording"}
    told = one.session.state().message
    assert (
        told.startswith("The recording is saved, but there is no model: ") and "too short" in told
    )


def test_a_search_ends_with_the_session(parted):
    """A thread that is left in the core would end the program with an abort."""
    one, begun = parted(), threading.Event()

    def search(**_):
        begun.set()
        while True:
            time.sleep(0.01)
            step(8.0)

    one.parts_estimator.work = search
    assert begun.wait(PATIENCE)
    one.session.close()
    assert not one.session._threads[2].is_alive()
    assert not one.session.state().message


def test_a_search_that_ends_after_the_stop_changes_no_state(parted):
    def save(_):
        raise RecordingError("too short")

    one, going, ended = parted(save=save), threading.Event(), threading.Event()

    def work(**_):
        going.set()
        ended.wait(PATIENCE)
        return False

    one.parts_estimator.work = work
    assert going.wait(PATIENCE)
    one.session.stop()
    state = one.session.state()
    ended.set()
    one.session._threads[2].join(PATIENCE)
    assert not one.session._threads[2].is_alive()
    assert "too short" in state.message
    assert one.session.state() == state


def test_without_a_model_what_is_discarded_is_left_out_too(vehicle, parted):
    one = parted()
    one.session.close()
    assert one.notes == [("finish",)]


def test_what_is_due_leaves_the_core_idle(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    turn = Turn(4.0)
    assert turn.due
    with turn:
        now[0] += 0.5
    now[0] += 3.9
    assert not turn.due
    now[0] += 0.2
    assert turn.due
    with turn:
        now[0] += 3.0  # a heavy one waits for four times as long
    now[0] += 11.9
    assert not turn.due
    now[0] += 0.2
    assert turn.due


def test_the_track_is_in_the_files_own_axes(vehicle):
    content = vehicle.to_mapping() | {"axes": "forward-right-down"}
    turned = Track(vehicle_from(content, "turned"))
    turned.use("pose", 0, ROW)
    assert turned.pose == (1.0, -2.0, -0.5)


def test_positions_and_headings_of_two_sensors_are_one_track(vehicle):
    track = Track(vehicle)
    track.use("position", 0, ROW[:2])
    assert track.pose is None and track.rows == []
    track.use("heading", 1, ROW[2:])
    track.use("position", SECOND, ROW[:2] + 1.0)
    assert track.pose == (2.0, 3.0, 0.5)
    assert track.rows == [(1.0, 2.0, 3.0, 0.5)]
    assert track.poses == 2


@pytest.mark.parametrize("jump", [5e7, -7200.0])
def test_the_time_goes_on_where_a_clock_is_set(vehicle, jump):
    track, velocity = Track(vehicle), BodyVelocity()
    step = SECOND // 10
    for i in range(200):
        stamp = i * step + (round(jump * SECOND) if i >= 100 else 0)
        track.use("pose", stamp, ROW)
        velocity.use("pose", stamp, np.array([0.02 * i, 0.0, 0.0]))
    assert track.newest == stamp  # a discard begins there
    assert track.time == pytest.approx(19.8)  # less the step that no clock shows
    assert len(track.rows) == pytest.approx(100, abs=1)
    assert velocity.nu == pytest.approx([0.2, 0.0, 0.0])


def test_one_pose_of_a_far_stamp_changes_no_time(vehicle):
    track = Track(vehicle)
    for i in range(200):
        track.use("pose", i * SECOND // 10 + (10**17 if i == 100 else 0), ROW)
    assert track.time == pytest.approx(19.7)


def test_driven_is_the_time_under_command(vehicle):
    track = Track(vehicle)
    for i in range(100):
        track.use(
            "command", i * SECOND // 10, np.full(len(vehicle.inputs), 0.5 if i < 30 else 0.01)
        )
        track.use("pose", i * SECOND // 10, ROW)
    assert track.driven == pytest.approx(2.9)
    track.use("command", 10 * SECOND, np.full(len(vehicle.inputs), 0.5))
    track.use("pose", 20 * SECOND, ROW)
    assert track.driven == pytest.approx(2.9)  # a gap is not driven


def test_a_long_track_stays_bounded_over_the_whole_drive(vehicle):
    track = Track(vehicle)
    for i in range(MOST_ROWS + 10):
        track.use("pose", i * SECOND // 5, ROW)
    assert len(track.rows) == MOST_ROWS // 2 + 10
    assert track.changes == 1
    assert track.rows[0][0] == 0.0 and track.rows[-1][0] == pytest.approx(0.2 * (MOST_ROWS + 9))


def test_body_velocity_is_that_of_a_circle():
    """Speed 0.5 m/s ahead and 0.3 rad/s: exact but for the chord of the baseline."""
    velocity, r, u = BodyVelocity(), 0.3, 0.5
    for i in range(60):
        t = 0.02 * i
        eta = np.array(
            [
                u / r * np.sin(r * t),
                u / r * (1.0 - np.cos(r * t)),
                np.remainder(r * t + 3.0, 2 * np.pi),
            ]
        )
        turned = 3.0
        c, s = np.cos(turned), np.sin(turned)
        eta[:2] = c * eta[0] - s * eta[1], s * eta[0] + c * eta[1]
        assert velocity.use("pose", round(t * 1e9), eta)
    assert velocity.nu == pytest.approx([u, 0.0, r], abs=1e-3)


def test_body_velocity_does_not_follow_a_jump_or_a_gap():
    velocity = BodyVelocity()
    assert np.isnan(velocity.nu).all()
    for i in range(60):
        jump = 5.0 if i == 57 else 0.0
        velocity.use("pose", i * SECOND // 15, np.array([0.01 * i + jump, 0.0, 0.0]))
    assert velocity.nu == pytest.approx([0.15, 0.0, 0.0], abs=1e-9)
    assert not velocity.use("pose", 0, ROW)  # out of order
    for i in range(3):
        velocity.use("pose", (100 + 10 * i) * SECOND, ROW)
    assert np.isnan(velocity.nu).all()


def test_advice_is_all_fields_of_the_state():
    from seatrial.poolside.state import LiveState

    assert {field.name for field in msgspec.structs.fields(Advice)} <= set(
        LiveState.__struct_fields__
    )
