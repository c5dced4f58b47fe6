# SPDX-License-Identifier: MIT
"""Which source a text names."""

from pathlib import Path

from seatrial.boat.vehicle import Vehicle
from seatrial.onboard.live.endpoints import Pipes
from seatrial.poolside.sources.follow import FollowSource
from seatrial.poolside.sources.follow_bag import FollowBag, growing_bag
from seatrial.poolside.sources.lines import LineSource, datagrams
from seatrial.poolside.sources.replay import ReplaySource
from seatrial.poolside.sources.source import EventSource
from seatrial.poolside.sources.telemetry import telemetry
from seatrial.util.errors import LiveError


def open_source(
    text: str, vehicle: Vehicle, speed: float = 1.0, *, salvage: bool = False
) -> EventSource:
    """The source that a text names. Raises LiveError, RecordingError, FileError.

    `-` standard input; `udp:PORT`, `udp:ADDRESS:PORT` lines; `mavlink:udp:PORT`, `mavlink:DEVICE:BAUD`;
    `follow:PATH` a table, a folder of tables or a bag that grows; else the path of a recording, replayed at
    `speed` times its pace (0: as fast as it is taken); `salvage`: what is left of a damaged bag.
    """
    live = text == "-" or text.startswith(("udp:", "mavlink:", "follow:"))
    if live and speed != 1.0:
        raise LiveError(
            f"--speed {speed:g}: {text} comes at its own pace; the option is for a replay"
        )
    if live and salvage:
        raise LiveError(f"--salvage: {text} is no damaged bag; the option is for a replay")
    if text == "-":
        return LineSource("-", vehicle, Pipes())
    if text.startswith("udp:"):
        return datagrams(text, vehicle)
    if text.startswith("mavlink:"):
        return telemetry(text, vehicle)
    if text.startswith("follow:"):
        path = Path(text.removeprefix("follow:"))
        bag = growing_bag(path)
        return FollowSource(text, path, vehicle) if bag is None else FollowBag(text, bag, vehicle)
    return ReplaySource(Path(text), vehicle, speed, salvage=salvage)
