# SPDX-License-Identifier: MIT
"""The loop of `seatrial mimic`: commands and the carrier's poses as lines in, its velocity out.

Lines in are those of `seatrial predict --live` (docs/live.md); clocks as there.
"""

import math
import time
from collections.abc import Callable, Iterator

import msgspec
import numpy as np

from seatrial.errors import LiveError, SeatrialError
from seatrial.frames import POSE_SIGNS, Axes
from seatrial.live.lines import NANO, Event, Reader
from seatrial.live.loop import LEAP, LONGEST_GAP, SHOWN, Settings
from seatrial.live.sources import Source
from seatrial.mimic.follow import Mimic, Motion

_encode = msgspec.json.Encoder().encode


class Stream:
    """Lines to and from a mimic; what it says of mistakes goes to `complain`."""

    def __init__(self, mimic: Mimic, settings: Settings, complain: Callable[[str], None]) -> None:
        self.mimic = mimic
        self.period = round(NANO / settings.rate)
        self.system = settings.clock == "system"
        vehicle = mimic.model.vehicle
        self._reader = Reader(vehicle, settings.form)
        self._flip = POSE_SIGNS if vehicle.axes is Axes.FRD else np.ones(3)
        self.lines = self.mistakes = 0
        self._complain = complain
        self._due: int | None = None  # [ns] the next velocity
        self._newest = 0  # [ns]

    def take(self, text: str, now: int) -> Iterator[str]:
        """What a line brings about; `now` [ns] by the system's clock."""
        self.lines += 1
        if not text.strip() or text.lstrip().startswith("#"):
            return
        try:
            event = self._reader(text)
            yield from self._use(event, now if event.stamp is None and self.system else event.stamp)
        except SeatrialError as error:
            self._mistake(str(error))

    def due(self, now: int) -> Iterator[str]:
        """Velocities that are due by `now` [ns]."""
        if self._due is None or not -LONGEST_GAP < now - self._due < LONGEST_GAP:
            self._due = math.ceil(now / self.period) * self.period
        while self._due <= now:
            yield self._line(self.mimic.at(self._due / NANO))
            self._due += self.period

    def wait(self, now: int) -> float:
        """Seconds until the next velocity is due by the system's clock."""
        return self.period / NANO if self._due is None else max(0.0, (self._due - now) / NANO)

    def _use(self, event: Event, stamp: int | None) -> Iterator[str]:
        if event.kind not in ("pose", "command"):
            raise LiveError(f"expected pose or command; got {event.kind}")
        if stamp is None:
            raise LiveError("no t: give it, or run with --clock system")
        if self._newest and stamp > self._newest + LEAP and not self.system:
            self._newest = stamp  # believed where the next one is there, too
            raise LiveError(f"{event.kind} at {stamp / NANO:.3f} s leaps ahead; left out")
        if not self.system:
            self._newest = max(self._newest, stamp)
            yield from self.due(stamp - 1)  # of what was known before
        put = self.mimic.pose if event.kind == "pose" else self.mimic.command
        if not put(stamp / NANO, event.values):
            raise LiveError(
                f"{event.kind} at {stamp / NANO:.6f} s was not used: too old, or no number"
            )

    def _line(self, motion: Motion) -> str:
        flip = self._flip
        answer = {
            "t": motion.time,
            "velocity": (motion.velocity * flip).tolist(),
            "asked": (motion.asked * flip).tolist(),
            "boat": [*(motion.pose * flip).tolist(), *(motion.nu * flip).tolist()],
            "mismatch": (motion.mismatch * flip).tolist(),
            "health": motion.health.names,
        }
        return _encode(answer).decode()

    def _mistake(self, words: str) -> None:
        self.mistakes += 1
        if self.mistakes <= SHOWN:
            self._complain(f"line {self.lines}: {words}")
        if self.mistakes == SHOWN:
            self._complain("further mistakes are counted, not said")


def serve(
    mimic: Mimic, source: Source, settings: Settings, complain: Callable[[str], None]
) -> Stream:
    """Until the source ends."""
    stream = Stream(mimic, settings, complain)
    while not source.ended:
        now = time.time_ns()
        for text in source.read(stream.wait(now) if stream.system else None):
            for line in stream.take(text, time.time_ns()):
                source.write(line)
        if stream.system:
            for line in stream.due(time.time_ns()):
                source.write(line)
    if stream.mistakes:
        complain(f"{stream.mistakes} of {stream.lines} lines could not be used")
    return stream
