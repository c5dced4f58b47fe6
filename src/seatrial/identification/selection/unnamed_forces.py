# SPDX-License-Identifier: MIT
"""Forces that the commands drive and the vehicle file does not name, for `structure: auto`.

Actuators that serve the same forces have as many independent forces as there are actuators. Those that the file
does not name, such as the difference of two thrusters across, are added: coupled thrust may need them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import msgspec
import numpy as np

from seatrial import _core
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.schema import ForceEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.selection.actuator_stages import actuator_groups
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

LEAST_DRIVEN = 0.1  # RMS of such a force over that of its actuators: less is not driven
NO_WEIGHT = 1e-9  # less is rounding: a singular value over the largest, a weight


def with_unnamed_forces(vehicle: Vehicle, recordings: Sequence[Recording]) -> Vehicle:
    """The vehicle with the forces that its recordings drive beyond those of its file.

    Unchanged where the file states thrusters, or forces that are none of thrusters alone.
    """
    file = vehicle.file
    turned = any(force.deflection for force in file.forces.values()) or any(
        g.steered for g in file.chain
    )
    if file.thrusters or turned or not file.forces:
        return vehicle
    rows = np.concatenate([r.commands.values for r in recordings])
    outputs = _core.allocate(vehicle.chain, np.ascontiguousarray(rows))[0]
    forces = dict(file.forces)
    for first, weights in _unnamed(vehicle):
        driven = _rms(outputs @ weights) > LEAST_DRIVEN * _rms(outputs @ np.abs(weights))
        if driven and len(forces) < _core.MAX_FORCES:
            name = f"{first}_d"
            while name in forces:
                name += "d"
            of = {
                n: round(w, 6)
                for n, w in zip(vehicle.actuators, weights.tolist(), strict=True)
                if w
            }
            forces[name] = ForceEntry(axis=file.forces[first].axis, of=of)
    return replace(vehicle, file=msgspec.structs.replace(file, forces=forces))


def added_forces(named: Vehicle, whole: Vehicle) -> tuple[Finding, ...]:
    """A finding for each force that a vehicle has beyond those of its file."""
    return tuple(
        finding_of(FindingKind.FORCE_ADDED, name, entry.axis, *entry.of)
        for name, entry in whole.file.forces.items()
        if name not in named.file.forces
    )


def with_forces_of(known: Vehicle, vehicle: Vehicle) -> Vehicle:
    """The vehicle with the forces that a known one of the same actuators has beyond those of its own file."""
    own, others = vehicle.file.forces, known.file.forces
    if not own or tuple(vehicle.actuators) != tuple(known.actuators) or set(others) <= set(own):
        return vehicle
    return replace(vehicle, file=msgspec.structs.replace(vehicle.file, forces={**others, **own}))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _unnamed(vehicle: Vehicle) -> Iterator[tuple[str, Array]]:
    """The first named force of a group of actuators, and weights (actuators,) of each force that has no name."""
    for members in actuator_groups(vehicle).values():
        own = [vehicle.actuators.index(name) for name in members]
        serves = np.flatnonzero(vehicle.mix[:, own].any(axis=1))
        _, sizes, directions = np.linalg.svd(vehicle.mix[serves][:, own])
        for direction in directions[int(np.sum(sizes > NO_WEIGHT * sizes[0])) :]:
            weights = np.zeros(len(vehicle.actuators))
            weights[own] = np.where(np.abs(direction) > NO_WEIGHT, direction, 0.0)
            weights /= np.abs(weights).sum() * np.sign(weights[weights != 0.0][0])
            yield vehicle.forces[serves[0]].name, weights
