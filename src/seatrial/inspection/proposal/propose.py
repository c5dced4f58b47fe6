# SPDX-License-Identifier: MIT
"""`init`: a vehicle file to start from, proposed from recordings."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from seatrial.boat.names import LONGEST_TITLE
from seatrial.inspection.proposal.by_name import ThrustersUnknownError
from seatrial.inspection.proposal.from_bags import of_bag
from seatrial.inspection.proposal.from_logs import of_log
from seatrial.inspection.proposal.from_tables import of_tables
from seatrial.inspection.proposal.inputs import Drive, find_drive
from seatrial.inspection.proposal.places import driven_by_places
from seatrial.inspection.proposal.sources import Ask, Choices, Sources, one_each
from seatrial.inspection.proposal.vehicle_file import vehicle_text
from seatrial.io.bags.opening import is_bag
from seatrial.io.formats import is_log
from seatrial.io.reader import recording_name


@dataclass(frozen=True)
class Proposal:
    """Sources and actuation found in the recordings, and the file's text."""

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
    """Propose a `vehicle.yaml`. `ask` decides what the data do not determine; without it, an error.

    Topics or columns are those of the first recording; all recordings decide which columns change
    and what they drive.

    Raises RecordingError where there are no poses or commands, or several candidates.
    """
    path, choices = Path(path), choices or Choices()
    name = choices.name or recording_name(path)
    name = "".join(c if c.isprintable() else "_" for c in name)[:LONGEST_TITLE]
    # 1. Topics or columns of the poses and of the commands.
    if is_bag(path):
        sources = of_bag(path, name, choices, ask, salvage=salvage)
    elif is_log(path):
        sources = of_log(path, name, choices, ask)
    else:
        sources = of_tables(path, name, choices, ask, tuple(map(Path, more)))
    sources = replace(sources, more=tuple(map(Path, more)))
    if choices.stern:
        sources = replace(sources, pose=turned_about(sources.pose))
    # 2. Units, signs, scales, and which channel drives which axis, from the data.
    try:
        drive = find_drive(sources, thrusters=len(choices.thrusters), salvage=salvage)
    except ThrustersUnknownError as error:
        if choices.thrusters:
            one_each(choices.thrusters, error.names)
        raise
    if choices.thrusters:
        drive = driven_by_places(path, drive, choices.thrusters)
    # 3. The file, with a comment on each value that needs a check.
    return Proposal(sources, drive, vehicle_text(sources, drive, choices))


def turned_about(pose: Mapping[str, Any]) -> dict[str, Any]:
    """The poses with the heading turned by half a turn: it was that of the stern."""
    psi = dict(pose.get("psi", {}))
    half_turn = 180.0 if psi.get("unit") == "deg" else math.pi
    return {**pose, "psi": psi | {"offset": psi.get("offset", 0.0) + half_turn}}
