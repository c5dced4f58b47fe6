# SPDX-License-Identifier: MIT
"""A vehicle file to start from, proposed from what is in a recording."""

from dataclasses import dataclass, replace
from pathlib import Path

from seatrial.inspection.proposal.from_bags import of_bag
from seatrial.inspection.proposal.from_tables import of_tables
from seatrial.inspection.proposal.inputs import Drive, find_drive
from seatrial.inspection.proposal.sources import Ask, Choices, Sources
from seatrial.inspection.proposal.vehicle_file import vehicle_text
from seatrial.io.bags.opening import is_bag
from seatrial.io.bags.recording import recording_name

__all__ = ["Choices", "Proposal", "init"]


@dataclass(frozen=True)
class Proposal:
    """What was found, and the file's text."""

    sources: Sources
    drive: Drive
    text: str


def init(
    path: str | Path,
    *more: str | Path,
    choices: Choices | None = None,
    ask: Ask | None = None,
    salvage: bool = False,
) -> Proposal:
    """Propose a `vehicle.yaml`. What the recordings can't tell is asked, or refused with the option.

    Topics or columns are those of the first recording; which columns change, and what drives what,
    is seen from all.

    Raises RecordingError where there are no poses or commands, or several that could be meant.
    """
    path, choices = Path(path), choices or Choices()
    name = choices.name or recording_name(path)
    name = "".join(c if c.isprintable() else "_" for c in name)
    if is_bag(path):
        sources = of_bag(path, name, choices, ask, salvage=salvage)
    else:
        sources = of_tables(path, name, choices, ask, tuple(map(Path, more)))
    sources = replace(sources, more=tuple(map(Path, more)))
    drive = find_drive(sources, salvage=salvage)
    return Proposal(sources, drive, vehicle_text(sources, drive))
