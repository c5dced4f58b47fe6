# SPDX-License-Identifier: MIT
"""A session at the poolside: one thread takes the events, two look at them, any may ask for the state."""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from msgspec import structs

from seatrial.boat.vehicle import Vehicle
from seatrial.poolside.session.body_velocity import BodyVelocity
from seatrial.poolside.session.clock_watch import Clocks
from seatrial.poolside.session.parts import Parts, Seen
from seatrial.poolside.session.saving import save_drive
from seatrial.poolside.session.track import Row, Track
from seatrial.poolside.session.turn import LATE, Turn, slow_text
from seatrial.poolside.sources import SourceEvent
from seatrial.poolside.state import LiveState, SignalState
from seatrial.util.errors import LiveError, SeatrialError
from seatrial.util.frames import NS_PER_S, Array
from seatrial.util.progress import show_progress
from seatrial.util.status import Status, duration_text

LOOK = 0.25  # [s] between two looks at signals and predictions
WORK = 0.2  # [s] between two calls of the estimator
# [s] between two pieces of advice, at least: under command, with released sticks
ADVISE, REFRESH = 8.0, 1.0
RELOAD = 5.0  # [s] between two models of the predictions, at least
CHECK = 10.0  # [s] between two checks of signs and units, at least
FEWEST_POSES = 100  # of a check
LONGEST_END = 5.0  # [s] without a row, in which a source that is closed ends
RECORDING = "recording"  # its folder in the session's, and the signal that states its faults
ENDED = "The source has ended. Press stop and save."
Save = Callable[[Path], dict[str, str]]  # from the recording's folder: what was saved to its path


class _Ended(BaseException):
    """Ends a search: the session is over. No error, so that nothing reports it as one."""


class Session:
    """A `Controller`. `start` it once; `stop` ends it and saves, `close` ends it without.

    vehicle: the boat's; walls: corners [m] in its axes; folder: of what is saved; save: makes model and report
    from the recording's folder; copy: makes a bag of it, before that.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        parts: Parts,
        folder: Path,
        *,
        walls: Sequence[tuple[float, float]] = (),
        save: Save | None = None,
        copy: Save | None = None,
    ) -> None:
        self._parts = parts
        self._saves = {"mcap": copy} if copy is not None else {}
        self._saves["model"] = save or (lambda path: save_drive(path, folder))
        self._track, self._velocity = Track(vehicle), BodyVelocity()
        self._command: Array | None = None  # the newest
        self._clocks = Clocks()
        self._advised = 0.0  # [s] driven at the last advice
        self._state = LiveState(
            vehicle=vehicle.name, axes=vehicle.axes.value, inputs=vehicle.inputs,
            source=parts.source.name, folder=str(folder), walls=tuple(walls),
        )  # fmt: skip
        self._lock = threading.Lock()  # of the state and the track
        self._inputs = threading.Lock()  # of what the parts take
        self._stopping = threading.Lock()
        self._ending = threading.Event()
        self._failed: dict[str, str] = {}  # what a thread could not do
        self._saved: dict[str, str] | None = None
        self._taken = 0  # rows
        self._slow = ""  # that this computer falls behind
        self._changed = False  # whether the estimate is newer than the predictions' model
        self._threads = [
            threading.Thread(target=run, name=name, daemon=True)
            for name, run in (("source", self._take), ("look", self._look), ("work", self._work))
        ]

    def start(self) -> None:
        """Begin to take events."""
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """End without a model; the recording stays, without what was discarded. Raises FileError."""
        self._end()
        self._parts.recorder.finish()

    @property
    def drained(self) -> bool:
        """Whether the source has ended, and all its events are used."""
        return not self._threads[0].is_alive()

    # What the page asks for

    def state(self) -> LiveState:
        """As of `Controller`."""
        with self._lock:
            track = self._track
            return structs.replace(
                self._state, time=track.time, driven=track.driven, poses=track.poses,
                pose=track.pose, discards=track.changes,
            )  # fmt: skip

    def track(self, since: int) -> tuple[int, list[Row]]:
        """As of `Controller`."""
        with self._lock:
            return len(self._track.rows), self._track.rows[since:]

    def mark(self, text: str) -> None:
        """As of `Controller`. Raises LiveError before the first pose."""
        with self._lock:
            now, time_of = self._newest(), self._track.time
        self._parts.recorder.mark(now, text)
        with self._lock:
            marks = (*self._state.marks, (time_of, text))
            self._state = structs.replace(self._state, marks=marks)

    def discard(self, seconds: float) -> None:
        """As of `Controller`. Raises LiveError before the first pose."""
        parts = self._parts
        with self._lock:
            now = self._newest()
            start = now - round(seconds * NS_PER_S)
            self._track.discard(start)
        parts.estimator.discard(start, now)
        with self._inputs:
            parts.coverage.discard(start / NS_PER_S)
            parts.prediction.discard(start, now)
            if parts.detector is not None:
                parts.detector.begin_after(now)
        parts.recorder.discard(start, now)  # last: neither page nor source waits for the disk

    def stop(self) -> dict[str, str]:
        """As of `Controller`. Once: further calls give the same."""
        with self._stopping:
            if self._saved is None:
                self._saved = self._finish()
            return self._saved

    def _newest(self) -> int:
        """Stamp of the newest pose. Raises LiveError."""
        if self._state.stopped or self._ending.is_set():
            raise LiveError("the session is over")
        if self._track.newest is None:
            raise LiveError("no pose has arrived yet")
        return self._track.newest

    # Threads

    def _take(self) -> None:
        with self._reported("source"):
            self._take_all()

    def _take_all(self) -> None:
        for event in self._parts.source:
            with self._reported(RECORDING):
                self._parts.recorder.use(event.kind, event.stamp, event.values)
            self._taken += 1
            if self._ending.is_set():  # rows that had arrived are recorded
                continue
            with self._reported("event"):
                with self._lock:
                    self._track.use(event.kind, event.stamp, event.values)
                with self._inputs:
                    self._use(event)
                self._watch_clock(event)

    def _use(self, event: SourceEvent) -> None:
        parts, kind, stamp, values = self._parts, event.kind, event.stamp, event.values
        parts.estimator.use(kind, stamp, values)
        parts.prediction.use(kind, stamp, values)
        parts.health.use(kind, stamp, values, event.arrival)
        if parts.detector is not None:
            parts.detector.use(kind, stamp, values)
        self._cover(event)

    def _watch_clock(self, event: SourceEvent) -> None:
        """Leave out the poses whose stamps are of two times."""
        found = self._clocks.use(event.kind, event.stamp)
        if found is not None:
            if found.overlap is not None:
                self._parts.leave_out(*found.overlap)
            with suppress(LiveError):  # before the first pose
                self.mark(f"{event.kind}: {found.text}")

    def _cover(self, event: SourceEvent) -> None:
        if event.kind == "command":
            self._command = event.values
        if self._velocity.use(event.kind, event.stamp, event.values) and self._command is not None:
            self._parts.coverage.add(event.stamp / NS_PER_S, self._velocity.nu, self._command)

    def _look(self) -> None:
        """Signals, coverage and predictions, several times a second."""
        parts, before = self._parts, time.monotonic()
        while not self._ending.wait(LOOK):
            late, before = time.monotonic() - before - LOOK, time.monotonic()
            behind = parts.source.behind
            self._slow = slow_text(max(behind, late))
            if late > LATE:  # what has arrived is used first
                continue
            with self._reported("signals"), self._inputs:
                now = parts.source.now() - round(behind * NS_PER_S)
                signals = parts.health.states(now, "; ".join(parts.source.problems))
                coverage, predictions = parts.coverage.state(), parts.prediction.states()
                self._publish(
                    signals=(*self._not_recorded(), *signals),
                    coverage=coverage, predictions=predictions,
                )  # fmt: skip

    def _work(self) -> None:
        """Estimate, advice, the test for a change, and the checks of signs: what takes longer."""
        turns = (Turn(REFRESH), Turn(ADVISE)), Turn(CHECK), Turn(RELOAD)
        while not self._ending.wait(WORK):
            with suppress(_Ended), show_progress(self._going_on):
                self._work_once(*turns)

    def _going_on(self, _: Status) -> None:
        """Called at every step of a search."""
        if self._ending.is_set():
            raise _Ended

    def _work_once(self, advice: tuple[Turn, Turn], check: Turn, reload: Turn) -> None:
        with self._reported("estimate"):
            self._estimate(reload)
        way = self._state.next is not None and not self._state.next.commands  # to the middle
        if advice[self._track.active and not way].due:
            with self._reported("advice"), advice[0], advice[1]:
                self._advise()
        if check.due and self._track.poses > FEWEST_POSES:
            with self._reported("check of signs"), check:
                self._check()
        with self._reported("test for a change"):
            self._watch()
        self._publish(message=self._message(), lag=self._parts.estimator.lag)

    def _estimate(self, reload: Turn) -> None:
        self._changed |= self._parts.estimator.work(ended=self.drained)
        model = self._parts.estimator.model()
        if self._changed and reload.due and model is not None:
            self._changed = False
            with reload, self._inputs:
                self._parts.prediction.reload(model)

    def _advise(self) -> None:
        now = self.state()
        pose = None if self.drained else now.pose
        period = now.time / max(now.poses - 1, 1)
        drive = self._parts.estimator
        if (model := drive.model()) is not None:
            self._parts.health.check_estimate(model)
        seen = Seen(
            now.time, pose, self._velocity.nu, period, now.predictions, drive.trust, drive.whole,
            now.driven == self._advised,
        )  # fmt: skip
        self._advised = now.driven
        found = self._parts.guide.advise(model, seen)
        self._publish(**structs.asdict(found))

    def _check(self) -> None:
        """Signs, units and order, and what the poses show as a whole. Raises RecordingError."""
        log, health = self._parts.estimator.log, self._parts.health
        try:
            recording = log.recording()
        finally:
            health.remark(log.doubt, usable=not log.coarse)
        health.check(recording)

    def _watch(self) -> None:
        detector = self._parts.detector
        found = detector.look() if detector is not None and detector.due else None
        if found is not None:
            self._publish(change=found.text)

    def _message(self) -> str:
        """The first thing that hinders the estimate."""
        failures = self._failed.copy()  # in one step: other threads state theirs
        others = [f"{what}: {text}" for what, text in failures.items() if what != RECORDING]
        failed = self._failed.get("source")
        end = ENDED if failed is None else f"The source failed: {failed}. Press stop and save."
        over = [end] if self.drained else []
        waiting, problems = [self._parts.estimator.problem], self._parts.source.problems
        if not self._track.poses:  # why none come
            waiting = [*problems, *waiting]
        found = [*over, self._slow, *waiting, *problems, *others]
        return next((text for text in found if text), "")

    def _not_recorded(self) -> Sequence[SignalState]:
        """A signal that is not one: the recording, where it can't be written."""
        if (found := self._failed.get(RECORDING)) is None:
            return ()
        text = f"{found}: rows are lost; make room, or begin a new session in another folder"
        return [SignalState(RECORDING, RECORDING, 0, level="error", finding=text)]

    def _publish(self, **changed: object) -> None:
        with self._lock:
            if not self._state.stopped:  # a search that ends later has nothing to state
                self._state = structs.replace(self._state, **changed)

    @contextmanager
    def _reported(self, what: str) -> Iterator[None]:
        """What can't be done is stated on the page, and all else goes on."""
        try:
            yield
            self._failed.pop(what, None)
        except (SeatrialError, ArithmeticError, ValueError) as error:  # LinAlgError is a ValueError
            self._failed[what] = str(error)
        except Exception as error:  # a thread that ends would leave the page as it was
            self._failed[what] = (
                f"seatrial failed: {type(error).__name__}: {error}; please report it"
            )

    # The end

    def _end(self) -> None:
        self._ending.set()
        self._parts.source.close()
        for thread in self._threads:  # a search ends at its next step
            before = -1
            while thread.is_alive() and before != self._taken:  # rows that had arrived are recorded
                before = self._taken
                thread.join(LONGEST_END)

    def _finish(self) -> dict[str, str]:
        """Recording first; what comes after it may fail."""
        self._publish(saving="writing the recording", next=None, others=())
        self._end()
        folder = self._parts.recorder.finish()
        found, problem = {"recording": str(folder)}, ""
        for what, save in self._saves.items():
            try:
                with show_progress(self._progress):
                    found |= save(folder)
            except Exception as error:  # whatever it is, the page must not wait for ever
                problem = f"The recording is saved, but there is no {what}: {error}"
        saved = tuple(found.items())
        self._publish(saving="", saved=saved, stopped=True, message=problem)
        return found

    def _progress(self, status: Status) -> None:
        left = "" if status.left is None else f", {duration_text(status.left)} left"
        self._publish(saving=f"{status.stage} ({100.0 * status.share:.0f} %{left})")
