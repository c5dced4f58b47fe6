# SPDX-License-Identifier: MIT
"""The loop: lines as they come, odometry at a fixed rate.

By the data's clock a line of odometry is due when an input is later than it, and is made of the inputs
before: the same input gives the same output, from a file as on the boat. By the system's clock it is
due when it is time.
"""

import math
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from seatrial.errors import LiveError, SeatrialError
from seatrial.live.lines import NANO, Event, Reader, Writer
from seatrial.live.sources import Source
from seatrial.odometer import Odometer
from seatrial.predictor import Taken

SHOWN = 10  # mistakes that are said; all are counted
LEAP = 5 * NANO  # [ns] a stamp so far ahead may be wrong
LONGEST_GAP = 60 * NANO  # [ns] in the data, after which lines begin anew
RATE = 50.0  # [Hz]
Clock = Literal["data", "system"]
CLOCKS: tuple[Clock, ...] = ("data", "system")


@dataclass(frozen=True)
class Settings:
    """How lines are read and written."""

    form: str = "json"
    rate: float = RATE  # [Hz]
    clock: Clock = "data"

    def __post_init__(self) -> None:
        if not 0.1 <= self.rate <= 1000.0:
            raise LiveError(f"rate {self.rate:g}: expected 0.1 to 1000 Hz")


class Live:
    """Lines to and from an odometer; what it says of mistakes goes to `complain`."""

    def __init__(self, path: Path, settings: Settings, complain: Callable[[str], None]) -> None:
        self.path = path
        self.odometer = Odometer(path)
        self.period = round(NANO / settings.rate)
        self.system = settings.clock == "system"
        vehicle = self.odometer.model.vehicle
        self.reader, self.writer = Reader(vehicle, settings.form), Writer(vehicle, settings.form)
        self.lines = self.mistakes = 0
        self._complain = complain
        self._due: int | None = None  # [ns] the next line of odometry

    def take(self, text: str, now: int) -> Iterator[str]:
        """What a line brings about; `now` [ns] by the system's clock."""
        self.lines += 1
        if not text.strip() or text.lstrip().startswith("#"):
            return
        try:
            event = self.reader(text)
            if event.kind == "reload":
                self.reload()
            elif event.kind == "at":
                assert event.stamp is not None
                yield self.writer.estimate(event.stamp, self.odometer.look(event.stamp))
            else:
                yield from self._use(event, now)
        except SeatrialError as error:
            self._mistake(str(error))

    def due(self, now: int) -> Iterator[str]:
        """Lines of odometry that are due by `now` [ns]."""
        if self._due is None or not -LONGEST_GAP < now - self._due < LONGEST_GAP:
            self._due = math.ceil(now / self.period) * self.period
        while self._due <= now:
            out = self.odometer.at(self._due)
            if out.known:
                yield self.writer.odometry(out)
            self._due += self.period

    def wait(self, now: int) -> float:
        """Seconds until the next line is due by the system's clock."""
        return self.period / NANO if self._due is None else max(0.0, (self._due - now) / NANO)

    def reload(self) -> None:
        """The model file once more; where it can't be used all stays as it is."""
        self.odometer.reload(self.path)

    def _use(self, event: Event, now: int) -> Iterator[str]:
        if event.stamp is None and not self.system:
            raise LiveError("no t: give it, or run with --clock system")
        stamp = now if event.stamp is None else event.stamp
        if not self.system and stamp <= self.odometer.newest + LEAP:
            yield from self.due(stamp - 1)  # of what was known before
        if event.kind == "pose":
            taken = self.odometer.pose(stamp, event.values, event.covariance)
        elif event.kind == "command":
            taken = self.odometer.command(stamp, event.values)
        else:
            taken = self.odometer.scale(stamp, event.values)
        if taken not in (Taken.USED, Taken.TWICE):
            raise LiveError(f"{event.kind} at {stamp / NANO:.6f} s was not used: {said(taken)}")
        if not self.system:
            yield from self.due(self.odometer.newest - 1)

    def _mistake(self, words: str) -> None:
        self.mistakes += 1
        if self.mistakes <= SHOWN:
            self._complain(f"line {self.lines}: {words}")
        if self.mistakes == SHOWN:
            self._complain("further mistakes are counted, not said")


def said(taken: Taken) -> str:
    """What became of an input, in words."""
    return taken.name.lower().replace("_", " ")


def serve(path: Path, source: Source, settings: Settings, complain: Callable[[str], None]) -> Live:
    """Until the source ends: odometry by the model at `path`. SIGHUP reads the model once more.

    What can't be used is said to `complain`, and left out.
    """
    live = Live(path, settings, complain)
    asked = [False]
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, lambda *_: asked.__setitem__(0, True))
    if live.writer.header is not None:
        source.write(live.writer.header)
    while not source.ended:
        now = time.time_ns()
        for text in source.read(live.wait(now) if live.system else None):
            for line in live.take(text, time.time_ns()):
                source.write(line)
        if asked[0]:
            asked[0] = False
            try:
                live.reload()
                complain(f"{path}: read once more")
            except SeatrialError as error:
                complain(f"{error}; the model of before goes on")
        if live.system:
            for line in live.due(time.time_ns()):
                source.write(line)
    if live.mistakes:
        complain(f"{live.mistakes} of {live.lines} lines could not be used")
    return live
