# SPDX-License-Identifier: MIT
"""A vehicle file to start from, proposed from what is in a recording."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from seatrial.init.drive import Drive, find_drive
from seatrial.init.sources import Choices, Sources, find_sources
from seatrial.init.text import vehicle_text

__all__ = ["Choices", "Proposal", "init"]

Ask = Callable[[str, Sequence[str]], str]  # a question and its options to the option chosen


@dataclass(frozen=True)
class Proposal:
    """What was found, and the file's text."""

    sources: Sources
    drive: Drive
    text: str


def init(
    path: str | Path,
    choices: Choices | None = None,
    ask: Ask | None = None,
    *,
    salvage: bool = False,
) -> Proposal:
    """Propose a `vehicle.yaml`. What the recording can't tell is asked, or refused with the option.

    Raises RecordingError where there are no poses or commands, or several that could be meant.
    """
    sources = find_sources(Path(path), choices or Choices(), ask, salvage=salvage)
    drive = find_drive(sources, salvage=salvage)
    return Proposal(sources, drive, vehicle_text(sources, drive))
