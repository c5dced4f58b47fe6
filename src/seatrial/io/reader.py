# SPDX-License-Identifier: MIT
"""A recording from any log: a bag, a log of an autopilot, or tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from seatrial.boat.vehicle import Vehicle
from seatrial.io.assemble import assemble
from seatrial.io.bags.opening import is_bag, open_bag
from seatrial.io.bags.signals import BagSignals
from seatrial.io.formats import is_log, open_log
from seatrial.io.kinds import refused
from seatrial.io.log_signals import LogSignals
from seatrial.io.signals import Signals
from seatrial.io.tables.signals import TableSignals
from seatrial.recording.recording import Recording
from seatrial.util.arguments import expect
from seatrial.util.progress import over, stage

OPENED = 0.4  # of the time of reading an autopilot's log: its messages are counted


def read(path: str | Path, vehicle: Vehicle, *, salvage: bool = False) -> Recording:
    """A recording in forward-left-up axes; with `salvage` the readable part of a damaged bag.

    Raises RecordingError, FileError.
    """
    expect(vehicle, Vehicle, "vehicle")
    path = Path(path)
    with open_signals(path, vehicle, salvage=salvage) as signals:
        return assemble(signals, vehicle, recording_name(path))


def read_each(paths: Sequence[Path], vehicle: Vehicle, *, salvage: bool = False) -> list[Recording]:
    """A recording of each path, as of `read`, with its name among them."""
    named = list(zip(paths, recording_names(paths), strict=True))
    return [
        replace(read(path, vehicle, salvage=salvage), name=name)
        for path, name in over(named, "recording" if len(named) > 1 else "")
    ]


@contextmanager
def open_signals(path: Path, vehicle: Vehicle, *, salvage: bool = False) -> Iterator[Signals]:
    """The signals of any log. Raises RecordingError, FileError."""
    if error := refused(path):
        raise error
    if is_bag(path):
        with open_bag(path, salvage=salvage) as bag:
            yield BagSignals(bag, vehicle)
        return
    if is_log(path):
        with stage("", OPENED):
            log = open_log(path)
        yield LogSignals(log)
        return
    yield TableSignals(path, vehicle)


def recording_name(path: Path) -> str:
    """A recording's name: the file's or folder's, without the suffix."""
    full = path.resolve()
    name = full.name.removesuffix(".active").removesuffix(".zstd")
    return full.name if full.is_dir() else Path(name).stem


def recording_names(paths: Sequence[Path]) -> list[str]:
    """Names of the recordings at paths; of two logs with one name, as much of their paths as tells them apart."""
    places = [path.resolve() for path in paths]
    names = [recording_name(path) for path in paths]
    for depth in range(1, max((len(place.parts) for place in places), default=0)):
        of_name: dict[str, set[Path]] = {}
        for name, place in zip(names, places, strict=True):
            of_name.setdefault(name, set()).add(place)
        names = [
            "/".join(place.parts[-depth:])
            if len(of_name[name]) > 1 and depth < len(place.parts)
            else name
            for name, place in zip(names, places, strict=True)
        ]
    return names
