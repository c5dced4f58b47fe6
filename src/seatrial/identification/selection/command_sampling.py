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

LEAST_SAMPLING_GAIN = 20.0  # fall of -2 log L; both alternatives have the same parameters


@dataclass(frozen=True)
class SampledCommands:
    """The solution with commands that are samples, and by how much -2 log L falls with it."""

    at: Point
    gain: float

    @property
    def sampled(self) -> bool:
        """Whether the recordings show samples. Else they may still be: pose noise may take up the error."""
        return self.gain >= LEAST_SAMPLING_GAIN

    def finding(self, kind: FindingKind) -> Finding:
        """That they show samples."""
        return finding_of(kind, gain=self.gain)


def sampling_is_open(vehicle: Vehicle, recordings: Sequence[Recording]) -> bool:
    """Whether neither the vehicle file nor the log tells."""
    return vehicle.file.commands.sampled is None and any(map(sampling_doubt, recordings))


def sampled_commands_of(
    at: Point, vehicle: Vehicle, effects: Sequence[str] = ()
) -> SampledCommands | None:
    """The alternative to `at`, whose commands are exact at their rows.

    None where the vehicle file states it, where no recording leaves it open, and where there is no solution.
    """
    recordings = at.runs.problem.recordings
    if not sampling_is_open(vehicle, recordings):
        return None
    try:
        there = first_maximum(recordings, vehicle.with_sampled_commands(), effects)
    except IdentificationError:
        return None
    return SampledCommands(there, at.runs.cost - there.runs.cost)


def stated_sampling(
    recordings: Sequence[Recording], vehicle: Vehicle, effects: Sequence[str] = ()
) -> tuple[Vehicle, tuple[Finding, ...]]:
    """A vehicle with terms of the user's that states it as far as the recordings show it, and the finding.

    Only where all latencies are free: half a row of time would stand for an error of a stated one.
    """
    if not sampling_is_open(vehicle, recordings):
        return vehicle, ()
    try:
        at = first_maximum(recordings, vehicle, effects)
    except IdentificationError:
        return vehicle, ()
    problem = at.runs.problem
    latencies = [i for i, n in enumerate(problem.names) if n.partition(".")[0] == "latency"]
    if not latencies or not set(latencies) <= set(problem.free):
        return vehicle, ()
    found = sampled_commands_of(at, vehicle, effects)
    if found is None or not found.sampled:
        return vehicle, ()
    return vehicle.with_sampled_commands(), (found.finding(FindingKind.COMMANDS_LOOK_SAMPLED),)
