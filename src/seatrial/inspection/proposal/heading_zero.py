# SPDX-License-Identifier: MIT
"""Zero and sense of a heading that the motion and the thrusters contradict: an IMU's, whose conventions differ."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from seatrial.boat.schema import Column
from seatrial.inspection.consistency.check import ConsistencyReport
from seatrial.inspection.consistency.repair import Repair, repaired_heading
from seatrial.inspection.proposal.channels import Channels
from seatrial.util.errors import RecordingError

PAIR = 2  # thrusters of a boat that can not be driven sideways
SURGE, SWAY, YAW = 0, 1, 2


@dataclass(frozen=True)
class TurnedHeading:
    """The pose's entries with another zero or sense of the heading, and what was found."""

    pose: dict[str, Any]
    text: str


def turned_heading(
    pose: Mapping[str, Any], found: Channels, report: ConsistencyReport
) -> TurnedHeading | None:
    """The heading by what the boat does; None where nothing contradicts it.

    East and north are no mirror image: a track that turns against the heading shows its sense. Two thrusters that
    turn the boat drive it ahead: if they drive it sideways, the zero is a quarter turn off. Raises RecordingError.
    """
    if "latitude" in pose and report.search is not None and report.search.mirrored:
        _refuse_table(pose)
        return _repaired(pose, Repair(pose_signs=(1, 1, -1)), "turns against the track: sign: -1")
    clear = found.clear
    if len(found.names) != PAIR or clear[SURGE].any() or not (clear[SWAY] & clear[YAW]).all():
        return None
    port = float(np.sum(found.gains[SWAY])) > 0
    text = "lies across the way that both thrusters drive the boat: turned by 90 deg"
    return _repaired(pose, Repair(turn=1 if port else 3), text)


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
    stated = {key: entry[key] for key in ("unit", "sign", "offset", "scale") if key in entry}
    column = repaired_heading(Column(**stated), repair)
    entry |= {"sign": column.sign, "offset": round(column.offset, 9)}
    kept = {
        key: value
        for key, value in entry.items()
        if (key, value) not in (("sign", 1), ("offset", 0.0))
    }
    changed = dict(pose) | {"psi": kept}
    if "yaw_rate" in pose and repair.pose_signs[YAW] < 0:
        changed["yaw_rate"] = dict(pose["yaw_rate"]) | {
            "sign": -dict(pose["yaw_rate"]).get("sign", 1)
        }
    return TurnedHeading(changed, f"check: the heading {text}")
