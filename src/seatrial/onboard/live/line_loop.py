# SPDX-License-Identifier: MIT
"""Base of all line loops: count of lines and errors, schedule of output lines, and the loop.

By the data's clock a line is due when an input is later than it, and uses the inputs before: the same
input gives the same output, from a file as on the boat. By the system's clock it is due at its time.
"""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

from seatrial.boat.vehicle import Vehicle
from seatrial.onboard.live.endpoints import Arrived, Source
from seatrial.onboard.live.protocol import NANO, Event, Reader
from seatrial.util.errors import LiveError, SeatrialError

MOST_SHOWN = 10  # errors that are shown; all are counted
STAMP_LEAP = 5 * NANO  # [ns] ahead of the newest input, above which a stamp may be wrong
RESTART_GAP = 60 * NANO  # [ns] gap of the data, after which the schedule restarts
RATE = 50.0  # [Hz] default of output lines
SLOWEST, FASTEST = 0.1, 1000.0  # [Hz] range of it
Clock = Literal["data", "system"]
CLOCKS: tuple[Clock, ...] = ("data", "system")


@dataclass(frozen=True)
class Settings:
    """Format, rate and clock of the lines."""

    form: str = "json"
    rate: float = RATE  # [Hz]
    clock: Clock = "data"

    def __post_init__(self) -> None:
        check_rate(self.rate)


def check_rate(rate: float) -> None:
    """Raises LiveError where a rate of output lines [Hz] is out of range."""
    if not SLOWEST <= rate <= FASTEST:
        raise LiveError(f"rate {rate:g}: expected {SLOWEST:g} to {FASTEST:g} Hz")


class LineCount:
    """Input lines, and those that could not be used; error messages go to `complain`."""

    def __init__(self, complain: Callable[[str], None]) -> None:
        self.lines = self.mistakes = 0
        self.complain = complain

    def has_content(self, text: str) -> bool:
        """Count a line; False for an empty one and for a comment."""
        self.lines += 1
        return bool(text.strip()) and not text.lstrip().startswith("#")

    def mistake(self, words: str) -> None:
        """The line can't be used; the first errors are shown."""
        self.mistakes += 1
        if self.mistakes <= MOST_SHOWN:
            self.complain(f"line {self.lines}: {words}")
        if self.mistakes == MOST_SHOWN:
            self.complain("further errors are counted, not shown")

    def summarise(self) -> None:
        """Report how many lines could not be used, if any."""
        if self.mistakes:
            self.complain(f"{self.mistakes} of {self.lines} lines could not be used")


class Stream(LineCount, ABC):
    """Lines in, lines out at a fixed rate."""

    def __init__(
        self, vehicle: Vehicle, settings: Settings, complain: Callable[[str], None]
    ) -> None:
        super().__init__(complain)
        self.period = round(NANO / settings.rate)
        self.system = settings.clock == "system"
        self._reader = Reader(vehicle, settings.form)
        self._due: int | None = None  # [ns] the next line

    @abstractmethod
    def line(self, stamp: int) -> str | None:
        """The output line at a stamp [ns]; None: none."""

    @property
    @abstractmethod
    def newest(self) -> int:
        """Newest stamp of the inputs [ns], strays left out; 0 before the first. It falls with a clock set back."""

    @abstractmethod
    def use(self, event: Event, now: int) -> Iterator[str]:
        """Output lines of an event; `now` [ns] by the system's clock. Raises SeatrialError."""

    def take(
        self, text: str, now: int, follow: Callable[[str], None] = lambda _: None
    ) -> Iterator[str]:
        """Output lines of an input line; `now` [ns] by the system's clock. `follow`: called if it is valid."""
        if not self.has_content(text):
            return
        try:
            event = self._reader(str(text))
            follow(text)
            yield from self.use(event, now)
        except SeatrialError as error:
            self.mistake(str(error))

    def due(self, now: int) -> Iterator[str]:
        """Lines that are due by `now` [ns]."""
        # the system's clock only goes back where it was set back; stamps may be out of order
        back = self.period if self.system else RESTART_GAP
        if self._due is None or not -back <= now - self._due < RESTART_GAP:
            self._due = -(-now // self.period) * self.period
        while self._due <= now:
            text = self.line(self._due)
            if text is not None:
                yield text
            self._due += self.period

    def around(self, stamp: int, put: Callable[[], None]) -> Iterator[str]:
        """Output lines before and after `put` hands over an input of a stamp [ns]; it raises SeatrialError."""
        if self.system:
            put()
            return
        before = self.newest
        if before <= stamp <= before + STAMP_LEAP:
            yield from self.due(stamp - 1)  # from the inputs before this one
        try:
            put()
        finally:
            if self.newest < before:  # a clock that was set back: the schedule begins again
                self._due = None
        yield from self.due(self.newest - 1)

    def stamp_of(self, event: Event, now: int) -> int:
        """Stamp of an event [ns]. Raises LiveError."""
        if event.stamp is None and not self.system:
            raise LiveError("no t: give it, or run with --clock system")
        return now if event.stamp is None else event.stamp

    def serve(self, source: Source, between: Callable[[], None] = lambda: None) -> None:
        """Run until the source ends; `between` is called after every read."""
        while not source.ended:
            for text in source.read(self._wait(time.time_ns()) if self.system else None):
                now = text.at if isinstance(text, Arrived) else time.time_ns()
                for line in self._in_turn(text, now, source):
                    source.write(line)
            between()
            if self.system:
                for line in self.due(time.time_ns()):
                    source.write(line)
        self.summarise()

    def _in_turn(self, text: str, now: int, source: Source) -> Iterator[str]:
        """Lines that were due before this one arrived, then its own."""
        if self.system:
            yield from self.due(now - 1)
        yield from self.take(text, now, source.follow)

    def _wait(self, now: int) -> float:
        """Seconds until the next line is due by the system's clock, a period at most."""
        left = self.period if self._due is None else min(max(0, self._due - now), self.period)
        return left / NANO
