# SPDX-License-Identifier: MIT
"""A session's threads: what the page sees of events, marks, discards and faults, with fakes for the rest."""

import threading
import time

import msgspec
import numpy as np
import pytest
from live_sessions import ROW, SECOND, parted_session
from waiting import PATIENCE

from seatrial.poolside.session import live_session
from seatrial.poolside.session.live_session import ENDED
from seatrial.poolside.session.parts import Advice
from seatrial.poolside.sources import SourceEvent
from seatrial.poolside.state import ManoeuvreState
from seatrial.util.errors import FileError, LiveError

parted = parted_session


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


def test_before_the_first_pose_the_message_is_why_none_comes(parted):
    """As of an autopilot that does not send a message: to drive pulses mends nothing."""
    one = parted()
    one.parts_estimator.problem = "0 s of poses so far: drive pulses"
    one.source.problems = ("no message GPS_RAW_INT yet: let the autopilot send it",)
    one.until(lambda state: state.message == one.source.problems[0])
    one.drive(1)
    one.until(lambda state: state.message == one.parts_estimator.problem)


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


def test_with_released_sticks_the_advice_begins_where_the_boat_is_now(parted, monkeypatch):
    """Who reads it has released the sticks; while driving it is not changed under the driver's hands."""
    monkeypatch.setattr(live_session, "WORK", 0.02)
    monkeypatch.setattr(live_session, "REFRESH", 0.01)
    monkeypatch.setattr(live_session, "ADVISE", 1e9)  # [s] once at most
    one, seen = parted(), []
    one.parts_guide.advise = lambda _, now: seen.append(now) or Advice()

    def driven(command, first):
        for i in range(first, first + 50):
            one.source.put(
                SourceEvent("command", i * SECOND // 10, np.array([command, 0.0, 0.0]), i),
                SourceEvent("pose", i * SECOND // 10, ROW + 0.01 * i, i),
            )
        one.until(lambda state: state.poses == first + 50)

    driven(1.0, 0)
    count = len(seen)
    time.sleep(10 * live_session.WORK)
    assert len(seen) <= count + 1  # under command
    driven(0.0, 50)
    count = len(seen)
    one.until(lambda _: len(seen) > count + 3)
    assert seen[-1].resting
    assert seen[-1].pose == pytest.approx((1.99, 2.99, 1.49))


def test_the_way_to_the_middle_begins_where_the_boat_is_while_it_is_driven(parted, monkeypatch):
    """It has no stick positions to keep, and distances that fall."""
    monkeypatch.setattr(live_session, "WORK", 0.02)
    monkeypatch.setattr(live_session, "REFRESH", 0.01)
    monkeypatch.setattr(live_session, "ADVISE", 1e9)  # [s] once at most
    one, seen = parted(), []
    way = ManoeuvreState("Drive to the middle first", 20.0, "", 0.0, 0.0)
    one.parts_guide.advise = lambda _, now: seen.append(now) or Advice(next=way)
    one.source.put(SourceEvent("command", 0, np.array([1.0, 0.0, 0.0]), 0))
    one.drive(5)
    one.until(lambda _: len(seen) > 5)


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


def test_discarded_seconds_are_not_driven_and_not_covered(parted):
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
    one.health.states = lambda now, _: given.append(now) or ()
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
    assert signal.name == "recording"
    assert (
        signal.finding
        == f"{one.fault}: rows are lost; make room, or begin a new session in another folder"
    )
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


def test_advice_is_all_fields_of_the_state():
    from seatrial.poolside.state import LiveState

    assert {field.name for field in msgspec.structs.fields(Advice)} <= set(
        LiveState.__struct_fields__
    )
