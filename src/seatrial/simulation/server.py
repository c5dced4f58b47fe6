# SPDX-License-Identifier: MIT
"""The loop of `seatrial sim`: commands as they come, readings and truth out.

At a speed the simulated clock follows this machine's. At speed 0 it goes where the lines say, as fast as
can be: the same lines in give the same lines out.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from seatrial.onboard.live.endpoints import Source
from seatrial.simulation.protocol import KINDS, Kind, Writer, read_line
from seatrial.simulation.readings import ImuReading, PoseReading, Reading
from seatrial.simulation.world import World
from seatrial.util.errors import LiveError, SimulatorError

LONGEST_WAIT = 0.005  # [s] between looks at the clock
BEHIND = 1.0  # [s] that are made up for at once; what is more was lost
SHOWN = 10  # mistakes that are said; all are counted


@dataclass(frozen=True)
class Settings:
    """What is written, and how time passes."""

    rate: float = 50.0  # [Hz] of the truth
    speed: float = 1.0  # simulated seconds in a second; 0: as the lines say
    duration: float | None = None  # [s] after which it ends
    kinds: Sequence[Kind] = ("pose", "truth", "imu", "scan")

    def __post_init__(self) -> None:
        if not 0.1 <= self.rate <= 1000.0:
            raise LiveError(f"rate {self.rate:g}: expected 0.1 to 1000 Hz")
        if not 0.0 <= self.speed <= 1000.0:
            raise LiveError(f"speed {self.speed:g}: expected up to 1000; 0: as the lines say")
        if self.duration is not None and not 0.0 < self.duration < math.inf:
            raise LiveError(f"duration {self.duration:g}: expected seconds, more than 0")
        if odd := [kind for kind in self.kinds if kind not in KINDS]:
            raise LiveError(f"lines {', '.join(odd)}: expected some of {', '.join(KINDS)}")


class Stream:
    """Lines in and out of a world; what it says of mistakes goes to `complain`."""

    def __init__(self, world: World, settings: Settings, complain: Callable[[str], None]) -> None:
        self.world, self.settings, self._complain = world, settings, complain
        self.writer = Writer(world.boats)
        self.lines = self.mistakes = 0
        self._truths = 0  # number of the next

    @property
    def over(self) -> bool:
        """Whether the duration has passed."""
        return self.settings.duration is not None and self.world.time >= self.settings.duration

    def take(self, text: str) -> Iterator[str]:
        """What a line brings about."""
        self.lines += 1
        if not text.strip() or text.lstrip().startswith("#"):
            return
        try:
            asked = read_line(text, self.world.boats)
            if asked.t is not None and self.settings.speed == 0.0:
                yield from self.advance_to(self._ahead(asked.t))
            if asked.boat is not None and asked.command is not None and not self.over:
                asked.boat.command(asked.command)
                if "command" in self.settings.kinds:
                    yield self.writer.command(asked.boat, asked.command)
        except (LiveError, SimulatorError) as error:
            self._mistake(str(error))

    def _ahead(self, t: float) -> float:
        if not self.world.time <= t < math.inf:
            raise LiveError(f"t {t:g}: it is {self.world.time:g} s already; time only goes on")
        return t

    def advance_to(self, t: float) -> Iterator[str]:
        """All lines up to t [s], or to the end. Raises ModelError where a boat diverges."""
        end = t if self.settings.duration is None else min(t, self.settings.duration)
        while True:
            due = self._truths / self.settings.rate
            for reading in self.world.advance_to(max(self.world.time, min(end, due))):
                if _kind(reading) in self.settings.kinds:
                    yield self.writer.reading(reading)
            if due > end:
                return
            self._truths += 1
            if "truth" in self.settings.kinds:
                yield from map(self.writer.truth, self.world.boats)

    def _mistake(self, words: str) -> None:
        self.mistakes += 1
        if self.mistakes <= SHOWN:
            self._complain(f"line {self.lines}: {words}")
        if self.mistakes == SHOWN:
            self._complain("further errors are counted, not shown")


def _kind(reading: Reading) -> Kind:
    if isinstance(reading, PoseReading):
        return "pose"
    return "imu" if isinstance(reading, ImuReading) else "scan"


def serve(
    world: World, source: Source, settings: Settings, complain: Callable[[str], None]
) -> Stream:
    """Until the source ends, or the duration is over. Raises ModelError where a boat diverges."""
    stream = Stream(world, settings, complain)
    try:
        if settings.speed == 0.0:
            _by_lines(stream, source)
        else:
            _by_clock(stream, source, complain)
    finally:
        if stream.mistakes:
            complain(f"{stream.mistakes} of {stream.lines} lines could not be used")
    return stream


def _by_lines(stream: Stream, source: Source) -> None:
    while not (source.ended or stream.over):
        for text in source.read(None):
            for line in stream.take(text):
                source.write(line)
    if stream.settings.duration is not None:
        for line in stream.advance_to(stream.settings.duration):
            source.write(line)


def _by_clock(stream: Stream, source: Source, complain: Callable[[str], None]) -> None:
    speed, began = stream.settings.speed, time.monotonic()
    while not stream.over and not (source.ended and stream.settings.duration is None):
        behind = time.monotonic() - began - stream.world.time / speed
        if behind > BEHIND:
            complain(
                f"{behind:.1f} s behind the clock: this machine can't keep up; goes on from here"
            )
            began += behind
        for line in stream.advance_to((time.monotonic() - began) * speed):
            source.write(line)
        if source.ended:
            time.sleep(LONGEST_WAIT)
            continue
        for text in source.read(LONGEST_WAIT):
            for line in stream.take(text):
                source.write(line)
