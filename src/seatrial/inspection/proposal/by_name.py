# SPDX-License-Identifier: MIT
"""Inputs by the names of the channels, where no gain is significant."""

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from seatrial.boat.vehicle import WRENCH
from seatrial.inspection.proposal.channels import Channels
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import AXES

LEAST_COMBINATION = (
    0.01  # of the largest singular value; below, a combination of inputs is unexcited
)
FORCE_NAMES = {
    "F_u": "F_u|surge|force_x|linear_x",
    "F_v": "F_v|sway|force_y|linear_y",
    "F_r": "F_r|yaw|torque_z|angular_z",
}
# inputs, what the data show about each, forces
Parts = tuple[dict[str, dict[str, Any]], dict[str, str], dict[str, dict[str, Any]]]


class ThrustersUnknownError(RecordingError):
    """Commands of thrusters that are always driven in the same combinations: only positions tell them apart."""

    def __init__(self, message: str, names: Sequence[str]) -> None:
        super().__init__(message)
        self.names = tuple(names)  # of the channels, in order


def named_sticks(recordings: Sequence[Recording], found: Channels) -> Parts:
    """Inputs by the names of the channels, where no gain is significant."""
    inputs: dict[str, dict[str, Any]] = {}
    for force, words in FORCE_NAMES.items():
        like = [n for n in found.names if re.search(rf"(^|_)({words})$", n, re.IGNORECASE)]
        if len(like) == 1:
            inputs[force] = found.columns[like[0]]
    if not inputs:
        names = ", ".join(recording.name for recording in recordings)
        length = sum(recording.duration for recording in recordings)
        count = _combinations(recordings)
        if 0 < count < len(found.names):
            raise ThrustersUnknownError(
                f"{names}: {', '.join(found.names)} are always driven in the same {count} combinations (an "
                "allocation), so their separate effects are not identifiable. Give the position [m] and direction "
                "[deg] of each, in this order: --thrusters 'X Y DEG; X Y DEG; ...' (docs/vehicle.md)",
                found.names,
            )
        raise RecordingError(
            f"{names}: {length:.0f} s do not show which of {', '.join(found.names)} move the boat; "
            f"{_one_sided(recordings)}record some minutes in which it is driven, or write the vehicle file by "
            "hand (docs/vehicle.md)"
        )
    remarks = dict.fromkeys(inputs, "check: chosen by name; no axis moves significantly with it")
    axes = dict(zip(WRENCH, AXES, strict=True))
    return inputs, remarks, {n: {"axis": axes[n], "of": {n: 1.0}} for n in inputs}


def _one_sided(recordings: Sequence[Recording]) -> str:
    """What an error says of commands that are never negative."""
    values = np.concatenate([r.commands.values for r in recordings])
    if values.min() < 0.0 or values.max() <= 0.0:
        return ""
    return (
        "none of them is ever negative: if gear or direction is another column, write one signed column for each; "
        "else "
    )


def _combinations(recordings: Sequence[Recording]) -> int:
    """Number of independent combinations of the inputs that are excited."""
    values = np.concatenate([r.commands.values for r in recordings])
    size = np.linalg.svd(values - values.mean(axis=0), compute_uv=False)
    return int((size > LEAST_COMBINATION * size[0]).sum()) if size[0] > 0 else 0
