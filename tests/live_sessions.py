# SPDX-License-Identifier: MIT
"""A session whose source the test fills, and whose other parts note what they get."""

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from waiting import until

import seatrial
from seatrial.poolside.coverage import Coverage
from seatrial.poolside.session.live_session import Session
from seatrial.poolside.session.parts import Advice, Parts
from seatrial.poolside.sources import SourceEvent
from seatrial.util.errors import FileError, RecordingError

SECOND = 1_000_000_000  # [ns]
ROW = np.array([1.0, 2.0, 0.5])


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
            states=lambda *_: (),
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
        self.parts_guide = SimpleNamespace(advise=lambda *_: self.advice)
        parts = Parts(
            self.source, estimator, health, recorder, prediction, Coverage(vehicle), self.parts_guide, detector,
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
            *(SourceEvent("pose", (start + i) * SECOND // 10, ROW + 0.01 * i, i) for i in range(count))
        )  # fmt: skip

    def until(self, wanted):
        until(lambda: wanted(self.session.state()), self.session.state)


@pytest.fixture
def parted_session(tmp_path):
    """Makes sessions, and closes them: a fixture of modules that name it `parted`."""
    vehicle, made = seatrial.load_vehicle("mallard-mp"), []

    def make(**settings):
        made.append(Parted(vehicle, tmp_path, **settings))
        return made[-1]

    yield make
    for one in made:
        one.session.close()
