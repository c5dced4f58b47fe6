# SPDX-License-Identifier: MIT
"""What is common to all loops of lines: when something is due, mistakes that are counted, and the loop.

By the data's clock a line is due when an input is later than it, and is made of the inputs before: the
same input gives the same output, from a file as on the boat. By the system's clock it is due when it is
time.
"""

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

from seatrial.boat.vehicle import Vehicle
from seatrial.onboard.live.endpoints import Source
from seatrial.onboard.live.protocol import NANO, Event, Reader
from seatrial.util.errors import LiveError, SeatrialError

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


class Stream(ABC):
    """Lines in, lines out at a fixed rate; what it says of mistakes goes to `complain`."""

    def __init__(
        self, vehicle: Vehicle, settings: Settings, complain: Callable[[str], None]
    ) -> None:
        self.period = round(NANO / settings.rate)
        self.system = settings.clock == "system"
        self.lines = self.mistakes = 0
        self.complain = complain
        self._reader = Reader(vehicle, settings.form)
        self._due: int | None = None  # [ns] the next line

    @abstractmethod
    def line(self, stamp: int) -> str | None:
        """What is due at a stamp [ns]; None: nothing."""

    @abstractmethod
    def use(self, event: Event, now: int) -> Iterator[str]:
        """What an event brings about; `now` [ns] by the system's clock. Raises SeatrialError."""

    def take(self, text: str, now: int) -> Iterator[str]:
        """What a line brings about; `now` [ns] by the system's clock."""
        self.lines += 1
        if not text.strip() or text.lstrip().startswith("#"):
            return
        try:
            yield from self.use(self._reader(text), now)
        except SeatrialError as error:
            self._mistake(str(error))

    def due(self, now: int) -> Iterator[str]:
        """Lines that are due by `now` [ns]."""
        if self._due is None or not -LONGEST_GAP < now - self._due < LONGEST_GAP:
            self._due = math.ceil(now / self.period) * self.period
        while self._due <= now:
            text = self.line(self._due)
            if text is not None:
                yield text
            self._due += self.period

    def stamp_of(self, event: Event, now: int) -> int:
        """When it happened [ns]. Raises LiveError."""
        if event.stamp is None and not self.system:
            raise LiveError("no t: give it, or run with --clock system")
        return now if event.stamp is None else event.stamp

    def serve(self, source: Source, between: Callable[[], None] = lambda: None) -> None:
        """Until the source ends; `between` is called after every reading."""
        while not source.ended:
            for text in source.read(self._wait(time.time_ns()) if self.system else None):
                for line in self.take(text, time.time_ns()):
                    source.write(line)
            between()
            if self.system:
                for line in self.due(time.time_ns()):
                    source.write(line)
        if self.mistakes:
            self.complain(f"{self.mistakes} of {self.lines} lines could not be used")

    def _wait(self, now: int) -> float:
        """Seconds until the next line is due by the system's clock."""
        return self.period / NANO if self._due is None else max(0.0, (self._due - now) / NANO)

    def _mistake(self, words: str) -> None:
        self.mistakes += 1
        if self.mistakes <= SHOWN:
            self.complain(f"line {self.lines}: {words}")
        if self.mistakes == SHOWN:
            self.complain("further mistakes are counted, not said")
