# SPDX-License-Identifier: MIT
"""What tests of damaged bags share."""

from pathlib import Path

import pytest
from bag_tools import Sent, ros1, vehicle
from mcap_writer import mcap

import seatrial
from seatrial.io.bags.opening import open_bag
from seatrial.util.errors import SeatrialError

LENGTH = 3.0  # [s]


JOY = "sensor_msgs/msg/Joy"


MAKE = {"bag": ros1, "mcap": mcap}


def refused(path: Path, words: str, boat: seatrial.Vehicle | None = None, **how: bool) -> str:
    """The one line."""
    with pytest.raises(SeatrialError, match=words) as caught:
        seatrial.read(path, vehicle() if boat is None else boat, **how)
    line = str(caught.value)
    assert line.isprintable()
    assert len(line) < 1500
    return line


def messages(path: Path, *, salvage: bool = False) -> list[tuple[str, int, bytes]]:
    with open_bag(path, salvage=salvage) as bag:
        found = list(bag.messages(bag.topics.keys()))
        counts = {name: topic.messages for name, topic in bag.topics.items()}
    for name, count in counts.items():
        assert sum(m[0] == name for m in found) == count
    return found


def made(folder: Path, kind: str, sent: list[Sent]) -> Path:
    folder.mkdir(exist_ok=True)
    return MAKE[kind](folder / f"run.{kind}", sent)


both = pytest.mark.parametrize("kind", MAKE)
