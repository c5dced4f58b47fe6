# SPDX-License-Identifier: MIT
"""What the commands excited: how much of each axis, and which recording plays which role."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import thrust_trace
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import AXES, Array

DOMINANT = 0.75  # share of the squared commands from which on a recording belongs to one axis
FINE = 0.05  # [s] between looks at the commands
MOST_TIMES = 1_000_000  # looks; stamps in the wrong unit make days of minutes
EXCITED = 0.02  # RMS in command units below which an axis counts as not excited
CHANGES = 0.002  # in command units: what moves by less all along does not change
FULL = 2.0  # no command goes beyond twice the full one,
BEYOND = 1.02  # nor beyond it one way,
LOPSIDED = 0.3  # by so much less the other


@dataclass(frozen=True)
class Excitation:
    """Commands of one recording, axis by axis, in command units."""

    rms: Array  # (3,)
    largest: Array  # (3,) largest magnitude
    share: Array  # (3,) of the squared commands
    both_signs: tuple[bool, bool, bool]  # at least a fifth of the effort to either side
    least: Array  # (forces,)
    most: Array  # (forces,)

    @property
    def dominant(self) -> int | None:
        """The axis that has nearly all of it, if one has."""
        axis = int(np.argmax(self.share))
        return axis if self.share[axis] >= DOMINANT else None


def beyond_full(name: str, least: float, most: float) -> list[str]:
    """What is to be said of an input with this range: nothing, or that its units are not the file's."""
    reach, other = max(abs(least), abs(most)), min(abs(least), abs(most))
    if reach > FULL:
        return [
            f"{name} reaches {reach:.4g}, but full command is 1: give offset and scale in the vehicle "
            "file (of a PWM 1500 and 400)"
        ]
    if reach > BEYOND and least < 0.0 < most and reach - other > LOPSIDED:
        return [
            f"{name} goes from {least:.3g} to {most:.3g}, but full command is 1 both ways: is offset the "
            "neutral one?"
        ]
    return []


def even_times(recording: Recording) -> Array:
    """Times [s] over a recording at which to look at its commands; never too many."""
    step = max(min(FINE, recording.period), recording.duration / MOST_TIMES)
    return np.arange(0.0, recording.duration, step)


def excitation(vehicle: Vehicle, recording: Recording) -> Excitation:
    """RMS of the generalised forces over the time that poses cover, by axis."""
    t = even_times(recording)
    forces = thrust_trace(vehicle, vehicle.constants.values, recording).forces(t)
    rms, largest, both = np.zeros(3), np.zeros(3), [False] * 3
    for axis in range(3):
        mine = forces[:, [i for i, f in enumerate(vehicle.forces) if f.axis == axis]]
        if mine.size == 0:
            continue
        rms[axis] = np.sqrt(np.mean(np.sum(mine**2, axis=1)))
        largest[axis] = np.abs(mine).max()
        sides = np.array([np.maximum(mine, 0).sum(), np.maximum(-mine, 0).sum()])
        both[axis] = bool(sides.min() >= 0.2 * sides.sum() > 0)
    total = float(np.sum(rms**2))
    share = rms**2 / total if total > 0 else np.zeros(3)
    least, most = forces.min(axis=0), forces.max(axis=0)
    return Excitation(rms, largest, share, (both[0], both[1], both[2]), least, most)


def find_roles(
    vehicle: Vehicle,
    recordings: Sequence[Recording],
    given: Mapping[str, Sequence[str]] | None = None,
) -> tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]:
    """For surge, sway and yaw the recordings that identify it (the paper's S1, S2, S3).

    Roles that are given count. Otherwise a recording that is nearly all one axis serves that axis,
    and an axis without such a recording takes all in which it is excited. An axis that the vehicle
    file has no force for takes all.
    """
    found = [excitation(vehicle, r) for r in recordings]
    names = [r.name for r in recordings]
    roles: list[tuple[int, ...]] = []
    for axis, label in enumerate(AXES):
        chosen = [
            _index(names, name, label) for name in dict.fromkeys((given or {}).get(label, ()))
        ]
        if not chosen:
            chosen = [i for i, e in enumerate(found) if e.dominant == axis]
        if not chosen:
            chosen = [i for i, e in enumerate(found) if e.rms[axis] >= EXCITED]
        if not chosen and not _driven(vehicle, axis):
            chosen = list(range(len(recordings)))
        if not chosen:
            most = round(max(float(e.rms[axis]) for e in found), 9)  # allocations round
            how = "hardly" if most > 0.0 else "never"
            raise RecordingError(
                f"{', '.join(names)}: {label} is {how} excited (RMS command {most:.2g}, {EXCITED} is "
                f"the least); drive a minute of {label} pulses to both sides, or take it out of the "
                "structure"
            )
        if _driven(vehicle, axis):
            _changes(vehicle, [found[i] for i in chosen], axis, ", ".join(names))
        roles.append(tuple(chosen))
    return roles[0], roles[1], roles[2]


def _changes(vehicle: Vehicle, chosen: Sequence[Excitation], axis: int, names: str) -> None:
    """Refuses an axis whose forces stay as they are: a lasting push, drag and trim are one then."""
    mine = [i for i, force in enumerate(vehicle.forces) if force.axis == axis]
    least = np.min([e.least for e in chosen], axis=0)[mine]
    most = np.max([e.most for e in chosen], axis=0)[mine]
    if (most - least < CHANGES).all():
        values = " and ".join(
            f"{vehicle.forces[i].name} is {m:.2g}" for i, m in zip(mine, most, strict=True)
        )
        raise RecordingError(
            f"{names}: {values} throughout; only changes tell thrust from drag: drive a minute of "
            f"{AXES[axis]} pulses to both sides, or take it out of the structure"
        )


def _driven(vehicle: Vehicle, axis: int) -> bool:
    """Whether any force of the vehicle's stands in the equation of its own axis."""
    own = {force.name for force in vehicle.forces if force.axis == axis}
    return any(term.axis == axis and own & set(term.factors) for term in vehicle.structure.terms)


def _index(names: Sequence[str], name: str, label: str) -> int:
    if name not in names:
        raise RecordingError(
            f"role {label}={name}: no such recording; there are {', '.join(names)}"
        )
    return names.index(name)
