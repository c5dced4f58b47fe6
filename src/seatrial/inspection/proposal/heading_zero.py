# SPDX-License-Identifier: MIT
"""Zero and sense of a heading that the motion and the thrusters contradict: an IMU's, whose conventions differ."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from seatrial.boat.schema import Column
from seatrial.boat.vehicle import WRENCH
from seatrial.inspection.consistency.check import ConsistencyReport
from seatrial.inspection.consistency.oblique import LEAST_ANGLE
from seatrial.inspection.consistency.repair import Repair, repaired_heading
from seatrial.inspection.proposal.by_name import FORCE_NAMES
from seatrial.inspection.proposal.channels import Channels
from seatrial.util.errors import RecordingError

PAIR = 2  # thrusters of a boat that can not be driven sideways
SURGE, SWAY, YAW = 0, 1, 2
ACROSS = 0.2  # largest cosine between the forces of two sticks
LEAST_REST = 0.1  # [deg] of the angle that is left after a turn: as it is written
TOGETHER = 0.5  # least size of the sum of two thrusters' forces, of their sizes


@dataclass(frozen=True)
class TurnedHeading:
    """The pose's entries with another zero or sense of the heading, and what was found."""

    pose: dict[str, Any]
    text: str
    # [deg] by which the zero is off, in all turns so far; 0: it is not, or by quarters
    angle: float = 0.0


def turned_heading(
    pose: Mapping[str, Any], found: Channels, report: ConsistencyReport, before: float
) -> TurnedHeading | None:
    """The heading by what the boat does; None where nothing contradicts it.

    East and north are no mirror image: a track that turns against the heading shows its sense. Two thrusters that
    turn the boat drive it ahead, and two sticks along its axes: if they drive it aside, the zero is off by that
    angle. Drag in the turned axes biases it, so what is left after a turn is turned once more.

    before: [deg] of the turns before. Raises RecordingError.
    """
    if "latitude" in pose and report.search is not None and report.search.mirrored:
        _refuse_table(pose)
        return _repaired(pose, Repair(pose_signs=(1, 1, -1)), "turns against the track: sign: -1")
    if len(found.names) == PAIR and found.clear[YAW].all():
        return _by_thrusters(pose, found, before)
    return _by_sticks(pose, found, before)


def _by_thrusters(pose: Mapping[str, Any], found: Channels, before: float) -> TurnedHeading | None:
    """Two thrusters that turn the boat drive it ahead."""
    clear = found.clear
    forces = found.gains[SURGE] + 1j * found.gains[SWAY]
    both = complex(forces.sum())
    if before:
        return _oblique(pose, float(np.degrees(np.angle(both))), "both thrusters drive", before)
    if not clear[SWAY].all():
        return _astern(pose, found)
    if not clear[SURGE].any():
        text = "lies across the way that both thrusters drive the boat: turned by 90 deg"
        return _repaired(pose, Repair(turn=1 if both.imag > 0 else 3), text)
    angle = float(np.degrees(np.angle(both)))
    apart = abs(both) < TOGETHER * float(np.abs(forces).sum())  # one of them counts astern
    if apart or min(abs(angle), 180 - abs(angle)) < LEAST_ANGLE:
        return None
    return _oblique(pose, angle, "both thrusters drive", before)


def _by_sticks(pose: Mapping[str, Any], found: Channels, before: float) -> TurnedHeading | None:
    """Two sticks that do not turn the boat, and drive it across each other, but not along its axes."""
    plane = (found.effects[: SWAY + 1] > 0.0).any(axis=0) & ~found.clear[YAW]
    if len(found.names) != PAIR + 1 or np.count_nonzero(plane) != PAIR:
        return None
    one, other = (found.gains[SURGE] + 1j * found.gains[SWAY])[plane]
    one, other = one / abs(one), other / abs(other)
    if abs((one * other.conjugate()).real) > ACROSS:
        return None
    angle = float(np.degrees(np.angle(one**4 + other**4)) / 4.0)
    if abs(angle) < (LEAST_REST if before else LEAST_ANGLE):
        return None
    # one of four quarters, by the name of the stick that drives ahead
    drives = zip((one, other), np.flatnonzero(plane), strict=True)
    ahead = [force for force, i in drives if _is_surge(found.names[i])]
    if len(ahead) == 1:
        angle += 90.0 * round((float(np.degrees(np.angle(ahead[0]))) - angle) / 90.0)
    return _oblique(pose, angle, "two inputs drive", before)


def _is_surge(name: str) -> bool:
    return bool(re.search(rf"(^|_)({FORCE_NAMES[WRENCH[SURGE]]})$", name, re.IGNORECASE))


def _astern(pose: Mapping[str, Any], found: Channels) -> TurnedHeading | None:
    """Two thrusters that drive the boat astern: x may point to the stern, or the commands count astern."""
    if not (found.clear[SURGE] & (found.gains[SURGE] < 0.0)).all():
        return None
    turned = repaired_heading(_heading(pose), Repair(turn=2))
    text = f"check: both inputs drive astern; where x points to the stern set offset: {turned.offset:.9g} at psi"
    return TurnedHeading(dict(pose), text)


def _oblique(
    pose: Mapping[str, Any], angle: float, what: str, before: float
) -> TurnedHeading | None:
    angle = round(angle, 1)
    if abs(angle) < LEAST_REST:
        return None
    total = round(before + angle, 1)
    text = f"lies {total:g} deg from the way that {what} the boat: turned by {total:g} deg"
    return replace(_repaired(pose, Repair(angle=angle), text), angle=total)


def _refuse_table(pose: Mapping[str, Any]) -> None:
    """Raise RecordingError of a table: its heading is a compass', so that its coordinates are in doubt."""
    lat, lon, psi = (dict(pose[key]).get("column", "") for key in ("latitude", "longitude", "psi"))
    if lat and psi:
        raise RecordingError(
            f"{psi} turns against the track: latitude and longitude are swapped, or it counts counter-clockwise. "
            f"If they are swapped: --pose lat={lon},lon={lat},heading={psi}"
        )


def _repaired(pose: Mapping[str, Any], repair: Repair, text: str) -> TurnedHeading:
    entry = dict(pose.get("psi", {}))
    column = repaired_heading(_heading(pose), repair)
    entry |= {"sign": column.sign, "offset": round(column.offset, 9)}
    usual = (("sign", 1), ("offset", 0.0))
    changed = dict(pose) | {"psi": dict(pair for pair in entry.items() if pair not in usual)}
    if "yaw_rate" in pose and repair.pose_signs[YAW] < 0:
        rate = dict(pose["yaw_rate"])
        changed["yaw_rate"] = rate | {"sign": -rate.get("sign", 1)}
    return TurnedHeading(changed, f"check: the heading {text}")


def _heading(pose: Mapping[str, Any]) -> Column:
    """The column of psi without its name."""
    entry = dict(pose.get("psi", {}))
    stated = {key: entry[key] for key in ("unit", "sign", "offset", "scale") if key in entry}
    return Column(**stated)
