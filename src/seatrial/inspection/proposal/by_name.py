# SPDX-License-Identifier: MIT
"""Inputs by the names of the channels, where no gain is significant."""

import re
from collections.abc import Sequence

import numpy as np

from seatrial.boat.vehicle import WRENCH
from seatrial.inspection.consistency.effects import combinations
from seatrial.inspection.proposal.channels import Channels
from seatrial.inspection.proposal.sources import Entries
from seatrial.recording.clocks import SLOW_TRANSPORT
from seatrial.recording.other_clock import SINCE_1970
from seatrial.recording.recording import Recording
from seatrial.recording.timing import Clock, time_text
from seatrial.util.errors import RecordingError
from seatrial.util.format import joined
from seatrial.util.frames import AXES

LONG_ENOUGH = 60.0  # [s] of driving, which shows what moves the boat where the clocks are one
FORCE_AXES = dict(zip(WRENCH, AXES, strict=True))
FORCE_NAMES = {
    "F_u": "F_u|surge|force_x|linear_x",
    "F_v": "F_v|sway|force_y|linear_y",
    "F_r": "F_r|yaw|torque_z|angular_z",
}
# inputs, what the data show about each, forces
Parts = tuple[Entries, dict[str, str], Entries]


class ThrustersUnknownError(RecordingError):
    """Commands of thrusters that are always driven in the same combinations: only positions tell them apart."""

    def __init__(self, message: str, names: Sequence[str], count: int) -> None:
        super().__init__(message)
        self.names = tuple(names)  # of the channels, in order
        self.count = count  # of the combinations


def named_sticks(recordings: Sequence[Recording], found: Channels) -> Parts:
    """Inputs by the names of the channels, where no gain is significant."""
    inputs: Entries = {}
    for force, words in FORCE_NAMES.items():
        like = [n for n in found.names if re.search(rf"(^|_)({words})$", n, re.IGNORECASE)]
        if len(like) == 1:
            inputs[force] = found.columns[like[0]]
    if not inputs:
        names = ", ".join(recording.name for recording in recordings)
        length = sum(recording.duration for recording in recordings)
        count = combinations(np.concatenate([r.commands.values for r in recordings]))
        if 0 < count < len(found.names):
            raise ThrustersUnknownError(
                f"{names}: {', '.join(found.names)} are always driven in the same {count} combinations (an "
                "allocation), so their separate effects are not identifiable. Give the position [m] and direction "
                "[deg] of each, in this order: --thrusters 'X Y DEG; X Y DEG; ...' (docs/vehicle.md)",
                found.names, count,
            )  # fmt: skip
        raise RecordingError(
            f"{names}: {length:.0f} s do not show which of {', '.join(found.names)} move the boat; "
            f"{_one_sided(recordings)}{_late(recordings)}{_own_starts(recordings)}record some minutes in which it "
            "is driven, or write the vehicle file by hand (docs/vehicle.md)"
        )
    remarks = dict.fromkeys(inputs, "check: chosen by name; no axis moves significantly with it")
    forces = {n: {"axis": FORCE_AXES[n], "of": {n: 1.0}} for n in inputs}
    return inputs, remarks, forces


def _one_sided(recordings: Sequence[Recording]) -> str:
    """What an error says of commands that are never negative."""
    values = np.concatenate([r.commands.values for r in recordings])
    if values.min() < 0.0 or values.max() <= 0.0:
        return ""
    return (
        "none of them is ever negative: if gear or direction is another column, write one signed column for each; "
        "else "
    )


def _late(recordings: Sequence[Recording]) -> str:
    """What an error says of messages that arrive long after their stamps: another clock hides what drives."""
    delays = {s.source: s.delay.least for r in recordings for s in r.streams if s.delay}
    found = [
        f"messages of {source} arrive {time_text(least)} or more after their stamps"
        for source, least in delays.items()
        if least > SLOW_TRANSPORT
    ]
    return f"{joined(found)}: if a clock is behind, correct its stamps; else " if found else ""


def _own_starts(recordings: Sequence[Recording]) -> str:
    """What an error says of two tables whose stamps count from a start, each perhaps from its own."""
    first = recordings[0]
    tables = {s.role: s.source for s in first.streams if s.clock is Clock.COLUMN}
    apart = {"poses", "commands"} <= tables.keys() and tables["poses"] != tables["commands"]
    begin = max(int(first.stamps[0]), int(first.commands.stamps[0])) * 1e-9
    if not apart or begin > SINCE_1970 or first.duration < LONG_ENOUGH:
        return ""
    return (
        "stamps of poses and commands count from a start: if each table has its own, set 'offset: SECONDS' at "
        "commands: stamp; else "
    )
