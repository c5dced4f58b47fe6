# SPDX-License-Identifier: MIT
"""Folds for cross-validation: recordings, or halves of them, with the same excitation."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from seatrial.boat.vehicle import Vehicle
from seatrial.recording.excitation import excitation
from seatrial.recording.recording import Recording

FEWEST_FOLDS = 2  # fewer repeats: recordings are cut in halves
HALF_NAMES = (" first half", " second half")


@dataclass(frozen=True)
class Fold:
    """One repeat of the experiment."""

    name: str
    recordings: tuple[Recording, ...]


def folds(vehicle: Vehicle, recordings: Sequence[Recording]) -> tuple[Fold, ...]:
    """S1-S3 against S4-S6: the k-th recording of every kind is in the k-th fold.

    Recordings are of a kind if their commands are mostly in the same axis, or in none. Where a kind
    has no repeat, every recording is cut in halves: first halves against second halves.
    """
    kinds: dict[int | None, list[Recording]] = {}
    for recording in recordings:
        kinds.setdefault(excitation(vehicle, recording).dominant, []).append(recording)
    count = min(len(same) for same in kinds.values())
    if count < FEWEST_FOLDS:
        return _halves(recordings)
    groups: list[list[Recording]] = [[] for _ in range(count)]
    for same in kinds.values():
        for i, recording in enumerate(same):
            groups[i % count].append(recording)
    return tuple(Fold(_name(group), tuple(group)) for group in groups)


def _halves(recordings: Sequence[Recording]) -> tuple[Fold, ...]:
    first, second = [], []
    for recording in recordings:
        middle = recording.duration / 2
        first.append(replace(recording.cut(None, middle), name=recording.name + HALF_NAMES[0]))
        second.append(replace(recording.cut(middle, None), name=recording.name + HALF_NAMES[1]))
    return Fold("first halves", tuple(first)), Fold("second halves", tuple(second))


def _name(group: Sequence[Recording]) -> str:
    names = sorted(recording.name for recording in group)
    return names[0] if len(names) == 1 else ", ".join(names)
