# SPDX-License-Identifier: MIT
"""The loop of `seatrial sim`: commands in, readings and truth out.

Above speed 0 the simulated clock follows this machine's. At speed 0 the lines set it, and the output is
a function of the input lines alone.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from seatrial.onboard.live.endpoints import Source
from seatrial.onboard.live.line_loop import RATE, LineCount, check_rate
from seatrial.simulation.protocol import LINE_KINDS, Kind, SimWriter, read_line
from seatrial.simulation.readings import ImuReading, PoseReading, Reading
from seatrial.simulation.world import World
from seatrial.util.errors import LiveError, SimulatorError

LONGEST_WAIT = 0.005  # [s] between readings of the clock
LARGEST_DELAY = 1.0  # [s] behind the clock that are simulated at once; a larger delay is dropped
LONGEST_LEAP = 3600.0  # [s] that one line may advance the time: some 10 s of work


@dataclass(frozen=True)
class SimSettings:
    """Rate and kinds of output lines, and the clock."""

    rate: float = RATE  # [Hz] of the truth
    speed: float = 1.0  # simulated seconds per second; 0: the lines set the time
    duration: float | None = None  # [s] after which it ends
    kinds: Sequence[Kind] = ("pose", "truth", "imu", "scan")

    def __post_init__(self) -> None:
        check_rate(self.rate)
        if not 0.0 <= self.speed <= 1000.0:
            raise LiveError(f"speed {self.speed:g}: expected up to 1000; 0: the lines set the time")
        if self.duration is not None and not 0.0 < self.duration < math.inf:
            raise LiveError(f"duration {self.duration:g}: expected seconds, more than 0")
        if odd := [kind for kind in self.kinds if kind not in LINE_KINDS]:
            raise LiveError(f"lines {', '.join(odd)}: expected some of {', '.join(LINE_KINDS)}")


class SimStream(LineCount):
    """Lines in and out of a world."""

    def __init__(
        self, world: World, settings: SimSettings, complain: Callable[[str], None]
    ) -> None:
        super().__init__(complain)
        self.world, self.settings = world, settings
        self.writer = SimWriter(world.boats)
        self._truths = 0  # number of the next

    @property
    def over(self) -> bool:
        """Whether the duration has passed."""
        return self.settings.duration is not None and self.world.time >= self.settings.duration

    def take(self, text: str, follow: Callable[[str], None] = lambda _: None) -> Iterator[str]:
        """Output lines of an input line. `follow`: called if it is valid."""
        if not self.has_content(text):
            return
        try:
            request = read_line(str(text), self.world.boats)
            follow(text)
            if request.t is not None and self.settings.speed == 0.0:
                yield from self.advance_to(self._ahead(request.t))
            if request.boat is not None and request.command is not None and not self.over:
                request.boat.command(request.command)
                if "command" in self.settings.kinds:
                    yield self.writer.command(request.boat, request.command)
        except (LiveError, SimulatorError) as error:
            self.mistake(str(error))

    def _ahead(self, t: float) -> float:
        if not self.world.time <= t < math.inf:
            raise LiveError(
                f"t {t:g}: before the simulated time {self.world.time:g} s; times must increase"
            )
        # with a duration the time ends there
        if self.settings.duration is None and t > self.world.time + LONGEST_LEAP:
            raise LiveError(
                f"t {t:g}: more than {LONGEST_LEAP:g} s after the simulated time {self.world.time:g} s; advance "
                "in smaller steps, or give --duration"
            )
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


def _kind(reading: Reading) -> Kind:
    if isinstance(reading, PoseReading):
        return "pose"
    return "imu" if isinstance(reading, ImuReading) else "scan"


def serve(
    world: World, source: Source, settings: SimSettings, complain: Callable[[str], None]
) -> SimStream:
    """Serve until the source ends, or the duration is over. Raises ModelError where a boat diverges."""
    stream = SimStream(world, settings, complain)
    try:
        if settings.speed == 0.0:
            _by_lines(stream, source)
        else:
            _by_clock(stream, source)
    finally:
        stream.summarise()
    return stream


def _by_lines(stream: SimStream, source: Source) -> None:
    while not (source.ended or stream.over):
        for text in source.read(None):
            for line in stream.take(text, source.follow):
                source.write(line)
    if stream.settings.duration is not None:
        for line in stream.advance_to(stream.settings.duration):
            source.write(line)


def _by_clock(stream: SimStream, source: Source) -> None:
    speed, start = stream.settings.speed, time.monotonic()
    while not stream.over and not (source.ended and stream.settings.duration is None):
        behind = time.monotonic() - start - stream.world.time / speed
        if behind > LARGEST_DELAY:
            stream.complain(
                f"{behind:.1f} s behind the clock: this machine is too slow; the delay is dropped"
            )
            start += behind
        for line in stream.advance_to((time.monotonic() - start) * speed):
            source.write(line)
        if source.ended:
            time.sleep(LONGEST_WAIT)
            continue
        for text in source.read(LONGEST_WAIT):
            for line in stream.take(text, source.follow):
                source.write(line)
