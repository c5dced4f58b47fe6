# SPDX-License-Identifier: MIT
"""Whether rows of the commands in a table are a logger's samples, or each is a change at its row.

The log does not show it; the likelihood does. A change that counts as exact at its row, but was up to a row
earlier, looks like process noise, and its mean like a negative latency. So does thrust that follows its command in
another way than the model has; but the size of its errors is not that of samples.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.first_search import first_maximum
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import search
from seatrial.identification.selection.actuator_selection import with_slew_rate
from seatrial.identification.solution import OutputErrorSettings, StartValues
from seatrial.recording.recording import Recording
from seatrial.recording.sampled_commands import sampling_unknown
from seatrial.util.errors import IdentificationError

LEAST_SAMPLING_GAIN = 20.0  # fall of -2 log L; both alternatives have the same parameters


@dataclass(frozen=True)
class SampledCommands:
    """The solution with commands that are samples, and by how much -2 log L falls with it."""

    at: Point
    gain: float

    def finding(self, kind: FindingKind) -> Finding:
        """That they show samples."""
        return finding_of(kind, gain=self.gain)


def sampling_is_open(vehicle: Vehicle, recordings: Sequence[Recording]) -> bool:
    """Whether neither the vehicle file nor the log tells."""
    stated = isinstance(vehicle.file.commands.sampled, bool)
    return not stated and any(map(sampling_unknown, recordings))


def sampled_commands_of(
    at: Point, vehicle: Vehicle, effects: Sequence[str] = ()
) -> SampledCommands | None:
    """What the recordings show in place of `at`, whose commands are exact at their rows.

    None where the vehicle file states it, where no recording leaves it open, and where the recordings show no
    samples: they may still be some, as pose noise may take up the error.
    """
    recordings = at.runs.problem.recordings
    if not sampling_is_open(vehicle, recordings):
        return None
    try:
        begin = StartValues.of_solution(at)
        there = first_maximum(recordings, vehicle.with_sampled_commands(), effects, start=begin)
    except IdentificationError:
        return None
    # both with a slew rate where one is likelier: thrust that follows it is off after each change, too
    settings = OutputErrorSettings(effects=tuple(effects))
    exact, samples = (with_slew_rate(one, vehicle, settings) or one for one in (at, there))
    gain = exact.runs.cost - samples.runs.cost
    if gain < LEAST_SAMPLING_GAIN or _fall_with_larger_errors(samples) >= 0.0:
        return None
    return SampledCommands(there, gain)


def _fall_with_larger_errors(at: Point) -> float:
    """By how much -2 log L falls where the errors of the samples' times are twice as large."""
    problem = at.runs.problem
    larger = [None if e is None else (e[0], 4.0 * e[1]) for e in problem.input_errors]
    found, _ = search(replace(problem, input_errors=tuple(larger)), at.theta, at.noise)
    return at.runs.cost - found.runs.cost


def stated_sampling(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    effects: Sequence[str] = (),
    start: StartValues | None = None,
) -> tuple[Vehicle, tuple[Finding, ...]]:
    """A vehicle with terms of the user's that states it as far as the recordings show it, and the finding.

    start: of the search, such as the solution with exact commands. Only where all latencies are free: half a row
    of time would stand for an error of a stated one.
    """
    if not sampling_is_open(vehicle, recordings):
        return vehicle, ()
    try:
        at = first_maximum(recordings, vehicle, effects, start=start)
    except IdentificationError:
        return vehicle, ()
    problem = at.runs.problem
    latencies = [i for i, n in enumerate(problem.names) if n.partition(".")[0] == "latency"]
    if not latencies or not set(latencies) <= set(problem.free):
        return vehicle, ()
    found = sampled_commands_of(at, vehicle, effects)
    if found is None:
        return vehicle, ()
    return vehicle.with_sampled_commands(), (found.finding(FindingKind.COMMANDS_LOOK_SAMPLED),)
