# SPDX-License-Identifier: MIT
"""`init`: a vehicle file to start from, proposed from recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import cos, pi, radians, sin
from pathlib import Path
from typing import Any

from seatrial.boat.names import LONGEST_TITLE
from seatrial.boat.vehicle import WRENCH
from seatrial.inspection.proposal.by_name import ThrustersUnknownError
from seatrial.inspection.proposal.from_bags import of_bag
from seatrial.inspection.proposal.from_logs import of_log
from seatrial.inspection.proposal.from_tables import of_tables
from seatrial.inspection.proposal.inputs import Drive, find_drive
from seatrial.inspection.proposal.sources import Ask, Choices, Place, Sources, one_each
from seatrial.inspection.proposal.time_zone import in_one_zone
from seatrial.inspection.proposal.vehicle_file import vehicle_text
from seatrial.io.bags.opening import is_bag
from seatrial.io.formats import is_log
from seatrial.io.reader import recording_name
from seatrial.recording.other_clock import OtherEpochError, OtherZoneError
from seatrial.recording.yaw_rate import YawRateError
from seatrial.util.blas import one_blas_thread
from seatrial.util.errors import VehicleError
from seatrial.util.format import joined
from seatrial.util.frames import AXES

NO_ARM = 1e-6  # [m], [-] of a thruster that does not act on an axis


@dataclass(frozen=True)
class Proposal:
    """A vehicle file's text, and what it is from.

    sources: where poses and channels come from
    drive: what moves which axis
    text: the file's content
    """

    sources: Sources
    drive: Drive
    text: str

    def __str__(self) -> str:
        return self.text


@one_blas_thread
def init(
    path: str | Path,
    *more: str | Path,
    choices: Choices | None = None,
    ask: Ask | None = None,
    salvage: bool = False,
) -> Proposal:
    """Propose a `vehicle.yaml`: `text` of the result is the file's content.

    `ask` decides what the data do not determine; without it, an error.

    Topics or columns are those of the first recording; all recordings decide which columns change
    and what they drive.

    Raises RecordingError where there are no poses or commands, or several candidates.
    """
    path, others, choices = Path(path), tuple(map(Path, more)), choices or Choices()
    name = choices.name or recording_name(path)
    name = "".join(c if c.isprintable() else "_" for c in name)[:LONGEST_TITLE]
    # 1. Topics or columns of the poses and of the commands.
    if is_bag(path):
        sources = of_bag(path, name, choices, ask, salvage=salvage)
    elif is_log(path):
        sources = of_log(path, name, choices, ask)
    else:
        sources = of_tables(path, name, choices, ask, others)
    sources = replace(sources, more=others, salvage=salvage)
    if choices.stern:
        sources = replace(sources, pose=turned_about(sources.pose))
    # 2. Units, signs, scales, and which channel drives which axis, from the data.
    try:
        sources, drive = _drive(sources, choices)
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
    half_turn = 180.0 if psi.get("unit") == "deg" else pi
    return {**pose, "psi": psi | {"offset": psi.get("offset", 0.0) + half_turn}}


def driven_by_places(path: Path, drive: Drive, places: Sequence[Place]) -> Drive:
    """The drive without forces, where `thrusters` of the file has them; with forces where an axis has none.

    Raises VehicleError where places and commands do not go together.
    """
    names = [*drive.inputs]
    sticks = set(names) & set(WRENCH)
    if not sticks:
        one_each(tuple(places), names)
    elif len(sticks) < len(WRENCH):
        raise VehicleError(
            f"{path}: --thrusters: the commands are {joined(names)}. Places are used with sticks of surge, sway "
            "and yaw (an allocation), or with one command for each thruster (--commands)"
        )
    else:
        return drive
    forces = forces_of(names, places)
    whole = len(forces) == len(WRENCH)
    return replace(drive, forces={} if whole else forces, undriven=())


def forces_of(names: Sequence[str], places: Sequence[Place]) -> dict[str, dict[str, object]]:
    """Forces on the axes that thrusters act on, as weighted sums: T of the allocation, row by row."""
    arms = {
        name: (cos(radians(a)), sin(radians(a)), x * sin(radians(a)) - y * cos(radians(a)))
        for name, (x, y, a) in zip(names, places, strict=True)
    }
    found: dict[str, dict[str, object]] = {}
    for i, (force, axis) in enumerate(zip(WRENCH, AXES, strict=True)):
        of = {name: round(arm[i], 4) for name, arm in arms.items() if abs(arm[i]) > NO_ARM}
        if of:
            found[force] = {"axis": axis, "of": of}
    return found


def _drive(sources: Sources, choices: Choices) -> tuple[Sources, Drive]:
    """The actuation, and the sources without what spoils them.

    A yaw rate that is not the heading's is left out unless the user named it: an IMU without one writes zeros.
    Beside stamps of simulated time, arrivals in the bag are used. Stamps in two time zones are brought together.
    """
    try:
        return sources, find_drive(sources, len(choices.thrusters))
    except OtherZoneError as error:
        for corrected in in_one_zone(sources, error.apart):
            with suppress(OtherZoneError):
                return _drive(corrected, choices)
        raise
    except OtherEpochError:
        if not is_bag(sources.path) or "clock" in sources.pose:
            raise
        arrival = {"clock": "bag"}
        sources = replace(sources, pose=sources.pose | arrival, commands=sources.commands | arrival)
        sources, drive = _drive(sources, choices)
        text = "check: one of the stamps counts from a start (simulated time), so arrivals in the bag are used"
        return sources, replace(drive, findings=(*drive.findings, text))
    except YawRateError as error:
        if "yaw_rate" in (choices.pose or ""):
            raise
        pose = {key: entry for key, entry in sources.pose.items() if key != "yaw_rate"}
        kept = tuple(r for r in sources.recognised if r.signal != "yaw rate")
        sources = replace(sources, pose=pose, recognised=kept)
        sources, drive = _drive(sources, choices)
        return sources, replace(drive, findings=(*drive.findings, f"no yaw rate is used: {error}"))
