# SPDX-License-Identifier: MIT
"""The loop of `seatrial predict --live`: lines in, odometry at a fixed rate out."""

import signal
from collections.abc import Callable, Iterator
from pathlib import Path

from seatrial.onboard.live.endpoints import Source
from seatrial.onboard.live.line_loop import STAMP_LEAP, Settings, Stream
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
        """Odometry, once a pose was used."""
        out = self.odometer.at(stamp)
        return self.writer.odometry(out) if out.known else None

    def reload(self) -> None:
        """Reload the model file; an invalid one changes nothing."""
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
        if not self.system and stamp <= self.odometer.newest + STAMP_LEAP:
            yield from self.due(stamp - 1)  # from the inputs before this one
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
                f"{event.kind} at {stamp / NANO:.6f} s was not used: {taken_text(taken)}"
            )
        if not self.system:
            yield from self.due(self.odometer.newest - 1)


def taken_text(taken: Taken) -> str:
    """The outcome of an input as text."""
    return taken.name.lower().replace("_", " ")


def serve(path: Path, source: Source, settings: Settings, complain: Callable[[str], None]) -> Live:
    """Serve odometry by the model at `path` until the source ends. SIGHUP reloads the model.

    Invalid lines are reported to `complain` and skipped.
    """
    live = Live(path, settings, complain)
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
    live.serve(source, reload_if_requested)
    return live
