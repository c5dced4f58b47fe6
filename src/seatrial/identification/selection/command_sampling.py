# SPDX-License-Identifier: MIT
"""Whether rows of the commands beside the poses are a logger's samples, or each is a change at its row.

The log does not show it; the likelihood does. A change that counts as exact at its row, but was up to a row
earlier, looks like process noise, and its mean like a negative latency.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.first_search import first_maximum
from seatrial.identification.likelihood.linearised import Point
from seatrial.recording.recording import Recording
from seatrial.recording.sampled_commands import sampling_doubt
from seatrial.util.errors import IdentificationError

LEAST_SAMPLING_GAIN = 20.0  # difference in -2 log L; both alternatives have the same parameters


@dataclass(frozen=True)
class CommandSampling:
    """Whether the commands are samples, the solution with that, and the finding where they are."""

    sampled: bool
    at: Point
    findings: tuple[Finding, ...] = ()


def sampling_is_open(vehicle: Vehicle, recordings: Sequence[Recording]) -> bool:
    """Whether neither the vehicle file nor the log tells."""
    return vehicle.file.commands.sampled is None and any(map(sampling_doubt, recordings))


def command_sampling_of(
    at: Point, vehicle: Vehicle, effects: Sequence[str] = ()
) -> CommandSampling | None:
    """What explains the recordings better: commands as samples, or a change at each row, as in the solution `at`.

    None where both do as well, where the vehicle file states it, and where no recording leaves it open.
    """
    recordings = at.runs.problem.recordings
    if not sampling_is_open(vehicle, recordings):
        return None
    try:
        there = first_maximum(recordings, vehicle.with_sampled_commands(), effects)
    except IdentificationError:
        return None
    gain = at.runs.cost - there.runs.cost
    if abs(gain) < LEAST_SAMPLING_GAIN:
        return None
    if gain < 0.0:
        return CommandSampling(sampled=False, at=at)
    return CommandSampling(True, there, (finding_of(FindingKind.COMMANDS_SAMPLED, gain=gain),))
