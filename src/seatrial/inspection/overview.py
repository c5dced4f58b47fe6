# SPDX-License-Identifier: MIT
"""What is in recordings, and what is wrong with them."""

from collections import Counter
from collections.abc import Sequence, Set
from dataclasses import dataclass
from typing import Any

import msgspec

from seatrial.boat.schema import NoiseEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.advice import implausible, jitter, verdicts
from seatrial.inspection.consistency import SignReport, check_apart
from seatrial.inspection.coverage import AxisCoverage, InputUse, coverage, input_use
from seatrial.recording.clocks import clock_verdicts
from seatrial.recording.pose_noise import pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.timing import Stream
from seatrial.util.errors import RecordingError

__all__ = ["Inspection", "RecordingView", "implausible", "inspect", "inspection_json"]

GOOD = "good for identification"


@dataclass(frozen=True)
class FaultSummary:
    """All faults of one kind."""

    kind: str
    count: int
    longest: float  # [s]
    longest_at: float  # [s] from the recording's start


@dataclass(frozen=True)
class RecordingView:
    """One recording, looked at."""

    name: str
    start: float  # [s] cut off before it
    duration: float  # [s]
    poses: int
    rate: float  # [Hz]
    jitter: float  # [s]
    usable: float  # share of the poses
    noise: NoiseEntry | None
    streams: tuple[Stream, ...]
    faults: tuple[FaultSummary, ...]
    axes: tuple[AxisCoverage, ...]
    inputs: tuple[InputUse, ...]
    verdicts: tuple[str, ...]


@dataclass(frozen=True)
class Inspection:
    """Some recordings of one vehicle, and what they say together about its file."""

    vehicle: Vehicle
    recordings: tuple[RecordingView, ...]
    signs: SignReport


def inspect(recordings: Sequence[Recording], vehicle: Vehicle) -> Inspection:
    """Rates, gaps, faults, clocks, excitation; and whether units, signs and order are right."""
    uses = [input_use(vehicle, recording) for recording in recordings]
    moves = {use.name for own in uses for use in own if not use.never_moves}
    views = tuple(
        _view(recording, vehicle, own, moves)
        for recording, own in zip(recordings, uses, strict=True)
    )
    return Inspection(vehicle, views, check_apart(recordings, vehicle))


def inspection_json(found: Inspection) -> dict[str, Any]:
    """The same for programs."""
    signs = found.signs
    return {
        "vehicle": found.vehicle.name,
        "axes": found.vehicle.axes.value,
        "recordings": msgspec.to_builtins(found.recordings),
        "signs": {
            "findings": [{"kind": f.kind.value, "text": f.text} for f in signs.findings],
            "seen": list(signs.text),
            "gains": msgspec.to_builtins(signs.table),
        },
    }


def _view(
    recording: Recording, vehicle: Vehicle, inputs: Sequence[InputUse], moves: Set[str]
) -> RecordingView:
    """`moves`: inputs that move in any of the recordings."""
    found, axes = coverage(vehicle, recording)
    said = verdicts(recording, found, inputs, moves, vehicle) or [GOOD]
    said += clock_verdicts(recording.streams, recording.origin - round(recording.offset * 1e9))
    try:
        noise = pose_noise(recording)
    except RecordingError:
        noise = None
    return RecordingView(
        recording.name, recording.offset, recording.duration, len(recording.t), 1 / recording.period,
        jitter(recording), recording.usable, noise, recording.streams, tuple(_faults(recording)),
        tuple(axes), tuple(inputs), tuple(said),
    )  # fmt: skip


def _faults(recording: Recording) -> list[FaultSummary]:
    counts = Counter(fault.kind for fault in recording.faults)
    found = []
    for kind, count in counts.items():
        worst = max((f for f in recording.faults if f.kind is kind), key=lambda f: f.end - f.start)
        found.append(
            FaultSummary(kind.value, count, worst.end - worst.start, recording.offset + worst.start)
        )
    return found
