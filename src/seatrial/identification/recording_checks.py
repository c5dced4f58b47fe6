# SPDX-License-Identifier: MIT
"""Recordings that can not identify a model, refused before any method begins."""

import itertools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.between_recordings import contradictions
from seatrial.inspection.overview import implausible_values
from seatrial.recording.excitation import beyond_full, refuse_no_commands
from seatrial.recording.recording import Recording
from seatrial.util.arguments import expect_each
from seatrial.util.errors import IdentificationError, RecordingError

SHORTEST_TOTAL = 10.0  # [s] of all recordings: less can not identify any axis
SHARED_POSES = 0.5  # of the shorter recording: two that share more poses are one recording


def check_recordings(recordings: Sequence[Recording], vehicle: Vehicle) -> None:
    """Refuses recordings that can not identify a model: none, one twice, too short, implausible."""
    expect_each(recordings, Recording, "recordings")
    if not recordings:
        raise IdentificationError("no recording given; pass at least one")
    names = [r.name for r in recordings]
    files = [(s.path.resolve(), r.offset) for r in recordings for s in r.sources[:1]]
    if len(set(files)) != len(files):
        raise IdentificationError(
            f"{', '.join(names)}: one of them is given twice, which would count it twice; give each once"
        )
    if len(set(names)) != len(names):
        raise IdentificationError(
            f"two recordings have the same name: {', '.join(names)}; rename one"
        )
    for a, b in itertools.combinations(recordings, 2):
        if shared := _shared(a, b):
            raise IdentificationError(
                f"{a.name} and {b.name} are one recording, {shared} poses of both are the same at the same "
                "times: they would count twice; give one of them"
            )
    length = sum(r.duration for r in recordings)
    if length < SHORTEST_TOTAL:
        raise IdentificationError(
            f"{', '.join(names)}: {length:.1f} s in all is too short; drive a minute or more in "
            "every axis"
        )
    for recording in recordings:
        for sentence in implausible_values(recording, vehicle):
            raise RecordingError(f"{recording.name}: {sentence}")
        refuse_no_commands(recording)


def commands_beyond(recordings: Sequence[Recording], vehicle: Vehicle) -> list[str]:
    """Remarks on the vehicle file, and inputs whose values can not be commands in its units."""
    ranges = [f(r.commands.values, axis=0) for r in recordings for f in (np.min, np.max)]
    own = np.array(ranges) * vehicle.input_signs
    ends = zip(vehicle.inputs, own.min(axis=0), own.max(axis=0), strict=True)
    return [
        *vehicle.remarks,
        *(text for name, least, most in ends for text in beyond_full(name, least, most)),
    ]


@contextmanager
def explained(recordings: Sequence[Recording], vehicle: Vehicle) -> Iterator[None]:
    """Where no solution is found inside, the error begins with what is wrong with recordings and file."""
    try:
        yield
    except IdentificationError as error:
        wrong = commands_beyond(recordings, vehicle) + contradictions(recordings, vehicle)
        raise IdentificationError("; ".join([*wrong, str(error)])) from None


def _shared(a: Recording, b: Recording) -> int:
    """Number of equal poses at equal times in two recordings; 0 where it may be chance."""
    _, i, j = np.intersect1d(a.stamps, b.stamps, assume_unique=True, return_indices=True)
    same = int(np.all(a.raw[i] == b.raw[j], axis=1).sum())
    return same if same > SHARED_POSES * min(len(a.stamps), len(b.stamps)) else 0
