# SPDX-License-Identifier: MIT
"""Which source a text names."""

from pathlib import Path

from seatrial.boat.vehicle import Vehicle
from seatrial.poolside.sources.lines import datagrams, standard_input
from seatrial.poolside.sources.replay import ReplaySource
from seatrial.poolside.sources.source import EventSource


def open_source(text: str, vehicle: Vehicle, speed: float = 1.0) -> EventSource:
    """The source that a text names. Raises LiveError, RecordingError, FileError.

    `-` standard input; `udp:PORT`, `udp:ADDRESS:PORT` lines; else the path of a recording, replayed at
    `speed` times its pace (0: as fast as it is taken).
    """
    if text == "-":
        return standard_input(vehicle)
    if text.startswith("udp:"):
        return datagrams(text, vehicle)
    return ReplaySource(Path(text), vehicle, speed)
