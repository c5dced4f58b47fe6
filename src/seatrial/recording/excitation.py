# SPDX-License-Identifier: MIT
"""Excitation by the commands: effort by axis, and the role of each recording."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import thrust_trace
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.recording import Recording
from seatrial.util.arguments import expect_each
from seatrial.util.errors import RecordingError
from seatrial.util.frames import AXES, Array

DOMINANT = 0.75  # of the squared commands, for a recording of a single axis
BOTH_SIDES = 0.2  # of the effort, least share of the weaker direction
COMMAND_LOOK = 0.05  # [s] between samples of the commands
MOST_LOOKS = 1_000_000  # samples; stamps in a wrong unit turn minutes into days
EXCITED = 0.02  # of full command, least RMS of an excited axis
LEAST_CHANGE = 0.002  # of full command, least range of a force that changes
FAR_BEYOND_FULL = 1.5  # of full command; a larger value has another unit, or means off
BEYOND_FULL = 1.02  # of full command in one direction, with ...
AT_ONCE = 0.05  # of the effort of two axes that are always driven together
OFFSET_NEUTRAL = 0.3  # ... so much less in the other: the neutral value is wrong


@dataclass(frozen=True)
class Excitation:
    """Commands of one recording, axis by axis, in command units."""

    rms: Array  # (3,)
    largest: Array  # (3,) largest magnitude
    share: Array  # (3,) of the squared commands
    both_signs: tuple[bool, bool, bool]  # at least `BOTH_SIDES` of the effort in each direction
    least: Array  # (forces,)
    most: Array  # (forces,)

    @property
    def dominant(self) -> int | None:
        """The axis with at least `DOMINANT` of the effort, or None."""
        axis = int(np.argmax(self.share))
        return axis if self.share[axis] >= DOMINANT else None


def beyond_full(name: str, least: float, most: float) -> list[str]:
    """A message where the range of an input does not fit a full command of 1; else none."""
    reach, other = max(abs(least), abs(most)), min(abs(least), abs(most))
    if reach > FAR_BEYOND_FULL:
        return [
            f"{name} reaches {reach:.4g}, but full command is 1: give offset and scale in the vehicle "
            "file (1500 and 400 for a PWM in us)"
        ]
    if reach > BEYOND_FULL and least < 0.0 < most and reach - other > OFFSET_NEUTRAL:
        return [
            f"{name} ranges from {least:.3g} to {most:.3g}, but full command is 1 in both directions: "
            "check that offset is the neutral value"
        ]
    return []


def refuse_no_commands(recording: Recording) -> None:
    """Raise RecordingError where an input has values that can not be commands: full command is 1."""
    signal = recording.commands
    found: list[str] = []
    for name, values in zip(signal.names, signal.values.T, strict=True):
        beyond = np.abs(values) > FAR_BEYOND_FULL
        if not beyond.any():
            continue
        odd, rest = values[beyond], values[~beyond]
        if len(rest) and np.ptp(odd) == 0:
            found.append(
                f"{name} is {odd[0]:.4g} on {100 * beyond.mean():.2g} % of its rows and "
                f"within {rest.min():.3g} to {rest.max():.3g} on the others; full command is 1. A disarmed "
                "autopilot writes such a value: state the raw one as off in the vehicle file (off: 0)"
            )
            continue
        found += beyond_full(name, float(values.min()), float(values.max()))
    if found:
        raise RecordingError(f"{recording.name}: {'; '.join(found)}")


def even_times(recording: Recording) -> Array:
    """Regular times [s] over a recording to sample its commands, `MOST_LOOKS` at most."""
    step = max(min(COMMAND_LOOK, recording.period), recording.duration / MOST_LOOKS)
    return np.arange(0.0, recording.duration, step)


def _forces(vehicle: Vehicle, recording: Recording) -> Array:
    """Generalised forces (n, forces) at even times while the commands are known."""
    t = even_times(recording)
    unknown = np.zeros(len(t), dtype=bool)  # as in the night between two drives
    for start, end in recording.unknown:
        unknown |= (t >= start) & (t <= end)
    t = t if unknown.all() else t[~unknown]
    return thrust_trace(vehicle, vehicle.constants.values, recording).forces(t)


def effort(vehicle: Vehicle, recording: Recording) -> Array:
    """Effort (3, 3) in each axis, and in two of them at once: integrals [s] of |F_i F_j| over time.

    The first identify thrust and drag of an axis, the others how axes are coupled.
    """
    forces = _forces(vehicle, recording)
    of_axes = np.zeros((len(forces), 3))
    for axis in range(3):
        of_axes[:, axis] = np.sqrt(np.sum(forces[:, vehicle.forces_of(axis)] ** 2, axis=1))
    return np.asarray(of_axes.T @ of_axes * (recording.duration / len(forces)))


def least_share(part: Array, rest: Array) -> float:
    """The least share of any effort (3, 3) that either has, of both together.

    Two axes count where they are driven at once more than now and then.
    """
    whole = part + rest
    most = np.sqrt(np.outer(np.diag(whole), np.diag(whole)))
    counts = whole > AT_ONCE * most
    if not counts.any():
        return 0.5
    return float((np.minimum(part, rest)[counts] / whole[counts]).min())


def excitation(vehicle: Vehicle, recording: Recording) -> Excitation:
    """RMS of the generalised forces by axis, over the duration of the poses while commands are known."""
    forces = _forces(vehicle, recording)
    rms, largest, both = np.zeros(3), np.zeros(3), [False] * 3
    for axis in range(3):
        mine = forces[:, vehicle.forces_of(axis)]
        if mine.size == 0:
            continue
        rms[axis] = np.sqrt(np.mean(np.sum(mine**2, axis=1)))
        largest[axis] = np.abs(mine).max()
        sides = np.array([np.maximum(mine, 0).sum(), np.maximum(-mine, 0).sum()])
        both[axis] = bool(sides.min() >= BOTH_SIDES * sides.sum() > 0)
    total = float(np.sum(rms**2))
    share = rms**2 / total if total > 0 else np.zeros(3)
    least, most = forces.min(axis=0), forces.max(axis=0)
    return Excitation(rms, largest, share, (both[0], both[1], both[2]), least, most)


def find_roles(
    vehicle: Vehicle,
    recordings: Sequence[Recording],
    given: Mapping[str, Sequence[str]] | None = None,
) -> tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]:
    """The recordings that identify surge, sway and yaw (the paper's S1, S2, S3).

    Given roles have priority. Next, recordings with a dominant axis serve that axis. An axis without
    any takes all recordings that excite it; an axis without a force takes all.
    """
    found = [excitation(vehicle, r) for r in recordings]
    names = [r.name for r in recordings]
    if odd := set(given or ()) - set(AXES):
        raise RecordingError(f"no role {', '.join(map(str, odd))}; there are {', '.join(AXES)}")
    for label, chosen_names in (given or {}).items():
        expect_each(chosen_names, str, f"role {label}")
    roles: list[tuple[int, ...]] = []
    for axis, label in enumerate(AXES):
        named = dict.fromkeys((given or {}).get(label, ()))
        chosen = [_index(names, name, label) for name in named]
        if not chosen:
            chosen = [i for i, e in enumerate(found) if e.dominant == axis]
        if not chosen:
            chosen = [i for i, e in enumerate(found) if e.rms[axis] >= EXCITED]
        if not chosen and not _driven(vehicle, axis):
            chosen = list(range(len(recordings)))
        if not chosen:
            # allocations leave rounding errors
            most = round(max(float(e.rms[axis]) for e in found), 9)
            how = "hardly" if most > 0.0 else "never"
            raise RecordingError(
                f"{', '.join(names)}: {label} is {how} excited (RMS command {most:.2g}, {EXCITED} is "
                f"the least); drive a minute of {label} pulses in both directions, or remove it from the "
                "structure"
            )
        if _driven(vehicle, axis):
            _refuse_constant(vehicle, [found[i] for i in chosen], axis, ", ".join(names))
        roles.append(tuple(chosen))
    return roles[0], roles[1], roles[2]


def _refuse_constant(vehicle: Vehicle, chosen: Sequence[Excitation], axis: int, names: str) -> None:
    """Refuse an axis with constant forces: thrust, drag and trim are then not separately identifiable."""
    mine = vehicle.forces_of(axis)
    least = np.min([e.least for e in chosen], axis=0)[mine]
    most = np.max([e.most for e in chosen], axis=0)[mine]
    if (most - least < LEAST_CHANGE).all():
        held = zip(mine, most, strict=True)
        values = " and ".join(f"{vehicle.forces[i].name} is {value:.2g}" for i, value in held)
        raise RecordingError(
            f"{names}: {values} throughout; constant thrust and drag are not distinguishable: drive a minute "
            f"of {AXES[axis]} pulses in both directions, or remove it from the structure"
        )


def _driven(vehicle: Vehicle, axis: int) -> bool:
    """Whether any force is in the equation of its own axis."""
    own = {force.name for force in vehicle.forces if force.axis == axis}
    return any(term.axis == axis and own & set(term.factors) for term in vehicle.structure.terms)


def _index(names: Sequence[str], name: str, label: str) -> int:
    if name not in names:
        raise RecordingError(
            f"role {label}={name}: no such recording; there are {', '.join(names)}"
        )
    return names.index(name)
