# SPDX-License-Identifier: MIT
"""The loop of `seatrial predict --live`: lines in, odometry at a fixed rate out."""

import signal
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Event as Flag
from typing import Literal, get_args

import numpy as np

from seatrial.boat.model import Model
from seatrial.onboard.boat_change import BoatChange, ChangeState, Detector
from seatrial.onboard.live.endpoints import Source
from seatrial.onboard.live.line_loop import Settings, Stream
from seatrial.onboard.live.protocol import NANO, Event, Writer
from seatrial.onboard.odometer import Odometer
from seatrial.onboard.predictor import Taken
from seatrial.util.errors import LiveError, SeatrialError
from seatrial.util.progress import show_progress
from seatrial.util.status import Status

NOISIER = 3.0  # times the model's pose noise, in standard deviations
Adapt = Literal["off", "ask", "auto"]
ADAPT: tuple[Adapt, ...] = get_args(Adapt)


@dataclass(frozen=True)
class Adaptation:
    """What happens on a change of the boat."""

    detector: Detector
    automatic: bool = False  # else on the line `adapt`
    keep: Callable[[Model], None] = lambda _: None  # the changed boat's model


class Live(Stream):
    """Lines to and from an odometer, which may follow a change of the boat."""

    def __init__(
        self,
        path: Path,
        settings: Settings,
        complain: Callable[[str], None],
        adaptation: Adaptation | None = None,
    ) -> None:
        self.path = path
        self.odometer = Odometer(path)
        vehicle = self.odometer.model.vehicle
        super().__init__(vehicle, settings, complain)
        self.writer = Writer(vehicle, settings.form)
        self.adaptation = adaptation
        self._confirmed: BoatChange | None = None  # the last, if the odometer does not follow it
        self._test: Future[BoatChange | None] | None = None  # one that runs
        self._outdated = False  # the test that runs is of a model before the last reload
        self._closed = Flag()
        self._worker = ThreadPoolExecutor(1) if adaptation is not None and self.system else None

    def line(self, stamp: int) -> str | None:
        """Odometry, once a pose was used."""
        out = self.odometer.at(stamp)
        return self.writer.odometry(out) if out.known else None

    def reload(self) -> None:
        """Reload the model file; an invalid one changes nothing."""
        self.odometer.reload(self.path)
        self.writer.change = self._confirmed = None
        self._outdated = self._test is not None
        if self.adaptation is not None and not self._outdated:
            self.adaptation.detector.restart(self.odometer.model)

    def use(self, event: Event, now: int) -> Iterator[str]:
        """As of `Stream`."""
        if event.kind == "reload":
            self.reload()
        elif event.kind == "adapt":
            self._adapt(self._confirmed)
        elif event.kind == "at":
            assert event.stamp is not None
            yield self.writer.estimate(event.stamp, self.odometer.look(event.stamp))
        else:
            stamp = self.stamp_of(event, now)
            yield from self.around(stamp, lambda: self._put(event, stamp))

    @property
    def newest(self) -> int:
        """See `Stream`."""
        return self.odometer.newest

    def close(self) -> None:
        """No further test for a change; one that runs ends at its next step."""
        self._closed.set()
        if self._worker is not None:
            self._worker.shutdown(wait=False, cancel_futures=True)

    def _put(self, event: Event, stamp: int) -> None:
        newest = self.odometer.newest
        if event.kind == "pose":
            taken = self.odometer.pose(stamp, event.values, event.covariance)
        elif event.kind == "position":
            taken = self.odometer.position(stamp, event.values)
        elif event.kind == "heading":
            taken = self.odometer.heading(stamp, float(event.values[0]))
        elif event.kind == "command":
            taken = self.odometer.command(stamp, event.values)
        else:
            taken = self.odometer.scale(stamp, event.values)
        if taken not in (Taken.USED, Taken.TWICE):
            raise LiveError(
                f"{event.kind} at {stamp / NANO:.6f} s was not used: {refusal(taken, (stamp - newest) / NANO)}"
            )
        if self.adaptation is not None:
            if not self._noisier(event):
                self.adaptation.detector.use(event.kind, stamp, event.values)
            self._watched(self.adaptation)

    def _noisier(self, event: Event) -> bool:
        """Whether a pose states much more noise than the model has: no test is made by such poses."""
        if event.covariance is None:
            return False
        own = self.odometer.model.noise
        stated = np.sqrt(np.diag(event.covariance))
        return bool(np.any(stated > NOISIER * np.array([own.position, own.position, own.heading])))

    def _watched(self, adaptation: Adaptation) -> None:
        """`_watch`; where the test itself fails, odometry goes on without it."""
        try:
            self._watch(adaptation)
        except LiveError:
            raise
        except (SeatrialError, ArithmeticError, ValueError) as error:  # LinAlgError is a ValueError
            self.adaptation = None
            self.complain(
                f"the test for a change of the boat failed ({error}); it is off from now on"
            )

    def _watch(self, adaptation: Adaptation) -> None:
        """The next test for a change: at once by the data's clock, beside the odometry by the system's."""
        found = None
        if self._worker is None:
            found = adaptation.detector.look()
        elif self._test is None:
            self._test = (
                self._worker.submit(self._look, adaptation.detector)
                if adaptation.detector.due
                else None
            )
        elif self._test.done():
            found, self._test = self._test.result(), None
            if self._outdated:
                adaptation.detector.restart(self.odometer.model)
                found, self._outdated = None, False
        if found is None:
            return
        self.complain(found.text)
        self._confirmed = self._confirmed if found.model is None else found
        self.writer.change = self._confirmed if found.state is ChangeState.WITHDRAWN else found
        if adaptation.automatic and found.model is not None:
            self._adapt(found)

    def _look(self, detector: Detector) -> BoatChange | None:
        with show_progress(self._going_on):
            return detector.look()

    def _going_on(self, _: Status) -> None:
        """Called at every step of a test."""
        if self._closed.is_set():
            raise CancelledError

    def _adapt(self, change: BoatChange | None) -> None:
        """The changed boat's model in place of the model. Odometry continues. Raises LiveError."""
        if self.adaptation is None or change is None or change.model is None:
            raise LiveError("adapt: no confirmed change of the boat; the model stays")
        self.odometer.reload(change.model)
        self.writer.change = self._confirmed = None
        self.complain("adapted to the changed boat")
        self.adaptation.keep(change.model)


def refusal(taken: Taken, ahead: float) -> str:
    """Why an input was not used; ahead: [s] of its stamp after the newest one."""
    late = f"its stamp is {-ahead:.1f} s before the newest one"
    early = f"its stamp is {ahead:.1f} s after the newest one"
    return {
        Taken.NOT_A_NUMBER: "a number is NaN, infinite or out of range, or the covariance is invalid",
        Taken.STALE: f"{late}; if the clock was set back, the odometry follows it after several inputs",
        Taken.AHEAD: f"{early}; the next input is used if its stamp agrees with this one",
        Taken.NO_ROOM: "too many inputs in half a second",
    }.get(taken, taken.name.lower())


def serve(
    path: Path,
    source: Source,
    settings: Settings,
    complain: Callable[[str], None],
    adaptation: Adaptation | None = None,
) -> Live:
    """Serve odometry by the model at `path` until the source ends. SIGHUP reloads the model.

    Invalid lines are reported to `complain` and skipped, changes of the boat reported.
    """
    live = Live(path, settings, complain, adaptation)
    requested = [False]
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, lambda *_: requested.__setitem__(0, True))

    def reload_if_requested() -> None:
        if not requested[0]:
            return
        requested[0] = False
        try:
            live.reload()
            complain(f"{path}: reloaded")
        except SeatrialError as error:
            complain(f"{error}; the previous model stays in use")

    if live.writer.header is not None:
        source.write(live.writer.header)
    try:
        live.serve(source, reload_if_requested)
    finally:
        live.close()
    return live
