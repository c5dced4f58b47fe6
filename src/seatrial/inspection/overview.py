# SPDX-License-Identifier: MIT
"""`inspect`: contents of recordings, their faults, and consistency with the vehicle file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence, Set
from dataclasses import dataclass
from typing import Any

import msgspec

from seatrial.boat.schema import NoiseEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.advice import (
    implausible_values,
    jitter,
    of_velocity_commands,
    recording_advice,
)
from seatrial.inspection.consistency.between_recordings import check_each_recording
from seatrial.inspection.consistency.check import ConsistencyReport
from seatrial.inspection.coverage import AxisCoverage, InputUse, coverage, input_use
from seatrial.recording.clocks import clock_verdicts
from seatrial.recording.pose_noise import known_pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.timing import Stream
from seatrial.recording.undriven import undriven_motion
from seatrial.util.above import text_by
from seatrial.util.arguments import expect, expect_each
from seatrial.util.blas import one_blas_thread
from seatrial.util.errors import RecordingError
from seatrial.util.progress import over, stage

__all__ = ["Inspection", "RecordingView", "implausible_values", "inspect", "inspection_json"]

GOOD = "good for identification"


@dataclass(frozen=True)
class FaultSummary:
    """All faults of one kind.

    kind: name of the fault
    count: of intervals
    longest: [s]
    longest_at: [s] from the recording's start
    """

    kind: str
    count: int
    longest: float
    longest_at: float


@dataclass(frozen=True)
class RecordingView:
    """What one recording contains, its faults, and advice.

    name: of the recording
    start: [s] cut off at the beginning
    duration: [s]
    poses: how many
    rate: [Hz] of the poses
    jitter: [s] of their stamps
    usable: share of the poses
    noise: of the poses; None: too few in a row
    streams: topics or tables with rates and clocks
    faults: by kind
    axes: excitation of surge, sway, yaw
    inputs: range and rest of every input
    verdicts: advice, in words
    """

    name: str
    start: float
    duration: float
    poses: int
    rate: float
    jitter: float
    usable: float
    noise: NoiseEntry | None
    streams: tuple[Stream, ...]
    faults: tuple[FaultSummary, ...]
    axes: tuple[AxisCoverage, ...]
    inputs: tuple[InputUse, ...]
    verdicts: tuple[str, ...]


@dataclass(frozen=True)
class Inspection:
    """Recordings of one vehicle, and their consistency with its file.

    vehicle: that they are read with
    recordings: each by itself
    signs: units, signs and order of the vehicle file, tested
    undriven: NAME=FROM-TO of motion without commands, as --without has it
    """

    vehicle: Vehicle
    recordings: tuple[RecordingView, ...]
    signs: ConsistencyReport
    undriven: tuple[str, ...] = ()

    __str__ = text_by("inspection.console", "inspection_text")


@one_blas_thread
def inspect(recordings: Sequence[Recording], vehicle: Vehicle) -> Inspection:
    """Rates, gaps, faults, clocks, excitation; consistency of units, signs and order."""
    expect(vehicle, Vehicle, "vehicle")
    expect_each(recordings, Recording, "recordings")
    if not recordings:
        raise RecordingError("no recording given; pass at least one")
    # 1. Values of every input; an input that moves in one recording may rest in another.
    uses = [input_use(vehicle, recording) for recording in recordings]
    moves = {use.name for own in uses for use in own if not use.never_moves}
    # 2. Each recording by itself.
    with stage("recordings", 0.3):
        pairs = list(zip(recordings, uses, strict=True))
        views = tuple(_view(recording, vehicle, own, moves) for recording, own in over(pairs))
    # 3. Units, signs and order of the vehicle file, from all recordings.
    with stage("units, signs and order"):
        consistency = check_each_recording(recordings, vehicle)
    # 4. What moves without commands.
    undriven = tuple(one.span(r) for r in recordings for one in undriven_motion(r))
    return Inspection(vehicle, views, consistency, undriven)


def inspection_json(found: Inspection) -> dict[str, Any]:
    """The inspection as the content of a JSON file."""
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
    # 1. Excitation by axis.
    found, axes = coverage(vehicle, recording)
    # 2. Advice on the recording and on its clocks.
    advice = recording_advice(recording, found, inputs, moves, vehicle) or [GOOD]
    advice += of_velocity_commands(recording.streams)
    advice += clock_verdicts(recording.streams, recording.origin - round(recording.offset * 1e9))
    return RecordingView(
        recording.name, recording.offset, recording.duration, len(recording.t), 1 / recording.period,
        jitter(recording), recording.usable, known_pose_noise(recording), recording.streams,
        tuple(_faults(recording)), tuple(axes), tuple(inputs), tuple(advice),
    )  # fmt: skip


def _faults(recording: Recording) -> list[FaultSummary]:
    """Faults by kind: how many, and the longest."""
    counts = Counter(fault.kind for fault in recording.faults)
    found = []
    for kind, count in counts.items():
        worst = max((f for f in recording.faults if f.kind is kind), key=lambda f: f.end - f.start)
        at = recording.offset + worst.start
        found.append(FaultSummary(kind.value, count, worst.end - worst.start, at))
    return found
