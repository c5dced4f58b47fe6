# SPDX-License-Identifier: MIT
"""The loop of `seatrial predict --live`: lines as they come, odometry at a fixed rate."""

import signal
from collections.abc import Callable, Iterator
from pathlib import Path

from seatrial.onboard.live.endpoints import Source
from seatrial.onboard.live.line_loop import LEAP, Settings, Stream
from seatrial.onboard.live.protocol import NANO, Event, Writer
from seatrial.onboard.odometer import Odometer
from seatrial.onboard.predictor import Taken
from seatrial.util.errors import LiveError, SeatrialError


class Live(Stream):
    """Lines to and from an odometer."""

    def __init__(self, path: Path, settings: Settings, complain: Callable[[str], None]) -> None:
        self.path = path
        self.odometer = Odometer(path)
        vehicle = self.odometer.model.vehicle
        super().__init__(vehicle, settings, complain)
        self.writer = Writer(vehicle, settings.form)

    def line(self, stamp: int) -> str | None:
        """Odometry, where it is known."""
        out = self.odometer.at(stamp)
        return self.writer.odometry(out) if out.known else None

    def reload(self) -> None:
        """The model file once more; where it can't be used all stays as it is."""
        self.odometer.reload(self.path)

    def use(self, event: Event, now: int) -> Iterator[str]:
        """As of `Stream`."""
        if event.kind == "reload":
            self.reload()
        elif event.kind == "at":
            assert event.stamp is not None
            yield self.writer.estimate(event.stamp, self.odometer.look(event.stamp))
        else:
            yield from self._put(event, self.stamp_of(event, now))

    def _put(self, event: Event, stamp: int) -> Iterator[str]:
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

    def reload_where_asked() -> None:
        if not asked[0]:
            return
        asked[0] = False
        try:
            live.reload()
            complain(f"{path}: read once more")
        except SeatrialError as error:
            complain(f"{error}; the model of before goes on")

    if live.writer.header is not None:
        source.write(live.writer.header)
    live.serve(source, reload_where_asked)
    return live
