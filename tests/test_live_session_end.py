# SPDX-License-Identifier: MIT
"""The end of a session: all rows are recorded, what comes after the recording may fail, no search outlives it."""

import threading
import time

import pytest
from live_sessions import parted_session
from waiting import PATIENCE, until

from seatrial.poolside.session import live_session
from seatrial.util.errors import LiveError, RecordingError
from seatrial.util.progress import stage, step

parted = parted_session


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


def test_a_search_that_ends_after_the_stop_changes_no_state(parted, monkeypatch):
    monkeypatch.setattr(live_session, "LONGEST_END", 0.2)

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


def test_without_a_model_what_is_discarded_is_left_out_too(parted):
    one = parted()
    one.session.close()
    assert one.notes == [("finish",)]
