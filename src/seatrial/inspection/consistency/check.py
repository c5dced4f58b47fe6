# SPDX-License-Identifier: MIT
"""The check of a vehicle file against recordings, and its report."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from seatrial.boat.actuators import STAGES
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.accelerations import held_rows
from seatrial.inspection.consistency.clock import clock_offset, later
from seatrial.inspection.consistency.findings import Finding, clock_finding, findings
from seatrial.inspection.consistency.gains import (
    Gains,
    Run,
    block_count,
    enough,
    gains,
    read_run,
    unexplained,
)
from seatrial.inspection.consistency.hypotheses import Search, negated, swapped
from seatrial.inspection.consistency.poses import (
    as_measured,
    clearly_better,
    heading_unit,
    length_factors,
    length_units,
    usual_speed,
)
from seatrial.inspection.consistency.repair import Repair, mended
from seatrial.recording.recording import Recording, Signal
from seatrial.util.errors import RecordingError
from seatrial.util.frames import AXES, Array

STRAIGHT = 0.1  # [rad] standard deviation of the heading on a way that shows no hand
LONG = 7200.0  # [s] of recordings: of longer ones fewer windows tell as much
WAYS = (("forward", "backward"), ("to the left", "to the right"), ("to the left", "to the right"))
DARK = "hardly excited, its sign is not checked"
NOT_STEERED = "the commands never change: were they recorded while the boat was driven?"
TOO_SHORT = "too short to check signs: drive two minutes or more"


@dataclass(frozen=True)
class Gain:
    """What one of the file's inputs does to one axis, as it is read now."""

    input: str
    axis: int
    value: float  # [m/s^2] or [rad/s^2] per unit of the file's command; forward-left-up
    t: float


@dataclass(frozen=True)
class SignReport:
    """What is wrong, what was seen, and what could not be told."""

    findings: tuple[Finding, ...]  # none: all that could be checked is well
    table: tuple[Gain, ...]
    text: tuple[str, ...]  # what each input moves, and what was not checked
    repair: Repair
    search: Search | None = field(default=None, compare=False)  # None: nothing could be told

    def mended(self, vehicle: Vehicle) -> Vehicle:
        """The vehicle file with all findings put right."""
        return mended(vehicle, self.repair)


def check_signs(recordings: Sequence[Recording], vehicle: Vehicle) -> SignReport:
    """Units, signs and order of a vehicle file's signals, from all recordings taken together.

    With a lever arm, the poses are judged where they were measured: a wrong heading took it off to the wrong
    side, and no reading would make that good.
    """
    if any(vehicle.lever):
        with suppress(RecordingError):
            measured = _checked([as_measured(r, vehicle) for r in recordings], vehicle)
            if measured.repair.pose_edits or any(measured.repair.units):
                return measured
    return _checked(recordings, vehicle)


def _checked(recordings: Sequence[Recording], vehicle: Vehicle) -> SignReport:
    """The same, of poses as they are given."""
    thinned = max(1.0, sum(r.duration for r in recordings) / LONG)
    runs = [read_run(r, file_commands(vehicle, r), thinned=thinned) for r in recordings]
    steered = any(np.ptp(r.commands.values, axis=0).any() for r in recordings)
    if not (steered and enough(runs)):
        n = len(vehicle.inputs)
        nothing = Repair(order=tuple(range(n)), input_signs=(1,) * n)
        dark = [f"{name}: {DARK}" for name in vehicle.inputs]
        return SignReport((), (), (TOO_SHORT,) if steered else (NOT_STEERED, *dark), nothing)
    speed, lengths = usual_speed(runs), length_units(runs, vehicle)
    factors = length_factors(lengths, vehicle)
    angle, read = heading_unit(runs, vehicle, factors)
    runs = [replace(run, smooth=s) for run, s in zip(runs, read, strict=True)]
    offset = clock_offset(runs)
    runs = [later(run, offset) for run in runs] if offset else runs
    mirrored = _turns(runs) and clearly_better(unexplained(runs), unexplained(runs, mirrored=True))
    found = gains(runs, mirrored=mirrored)
    search = Search(vehicle, found, mirrored, block_count(runs))
    repair = replace(search.best(), units=(*lengths, angle))
    seen = _sentences(vehicle, search, repair)
    return SignReport(
        (*clock_finding(offset), *findings(vehicle, repair, seen, speed)),
        _table(vehicle, found),
        (*(f"{name} {does}" for name, does in seen.items()), *_untold(vehicle, search, repair)),
        repair,
        search,
    )


def _turns(runs: Sequence[Run]) -> bool:
    """Whether the heading varies: of a straight way no one can tell whether it is mirrored.

    Mirrored, it is turned against the heading by twice that, and so it is explained as well where it is straight.
    """
    twice = np.exp(2j * np.concatenate([run.smooth.psi for run in runs]))
    return bool(np.abs(twice.mean()) < np.exp(-2.0 * STRAIGHT**2))


def file_commands(vehicle: Vehicle, recording: Recording) -> Signal:
    """Commands in the file's own axes, times what a known signal scales their thrust by."""
    signal, scales = recording.commands, recording.scales
    turned = (vehicle.input_signs < 0).any()  # else long recordings need not be there twice
    own = replace(signal, values=signal.values * vehicle.input_signs) if turned else signal
    if scales is None or all(group.scale is None for group in vehicle.file.chain):
        return own
    stamps = np.union1d(signal.stamps, scales.stamps)
    stamps = stamps[stamps >= signal.stamps[0]]
    t = (stamps - stamps[0]) * 1e-9
    origin = int(stamps[0])
    factor = _thrust(vehicle, scales.values[held_rows(scales.stamps, origin, t)])
    return Signal(own.names, stamps, own.values[held_rows(own.stamps, origin, t)] * factor)


def _thrust(vehicle: Vehicle, scales: Array) -> Array:
    """Factors (m, inputs) on thrust for known signals (m, scales)."""
    factor = np.ones((len(scales), len(vehicle.actuators)))
    for group in vehicle.file.chain:
        if group.scale is not None:
            members = [vehicle.actuators.index(n) for n in group.actuators or vehicle.actuators]
            reference = vehicle.file.scales[group.scale.signal].reference
            value = scales[:, vehicle.scales.index(group.scale.signal)]
            constants = vehicle.constants
            power = constants.values[constants.index[members[0], STAGES.index("scale_power")]]
            factor[:, members] *= (np.maximum(value, 0.0) / reference)[:, None] ** power
    if vehicle.actuators == vehicle.inputs:
        return factor
    return np.repeat(factor.mean(axis=1)[:, None], len(vehicle.inputs), axis=1)


def _table(vehicle: Vehicle, found: Sequence[Gains]) -> tuple[Gain, ...]:
    return tuple(
        Gain(name, axis, float(g.values[i]), float(g.t[i]))
        for i, name in enumerate(vehicle.inputs)
        for axis, g in enumerate(found)
    )


def _sentences(vehicle: Vehicle, search: Search, repair: Repair) -> dict[str, str]:
    """For each input what its column does, the poses put right: "moves surge forward (t 35)"."""
    t = search.body(repair) @ np.array([g.t for g in search.gains])
    said = {}
    for i, name in enumerate(vehicle.inputs):
        axis = int(np.argmax(np.abs(t[:, i])))
        way = WAYS[axis][0 if t[axis, i] > 0 else 1]
        said[name] = f"moves {AXES[axis]} {way} (t {abs(t[axis, i]):.0f})"
    return said


def _untold(vehicle: Vehicle, search: Search, repair: Repair) -> Iterator[str]:
    """What these recordings could not tell."""
    names = vehicle.inputs
    dark = {i for i in range(len(names)) if search.worth(repair, negated(repair, i)) < 1.0}
    yield from (f"{names[i]}: {DARK}" for i in sorted(dark))
    for i, j in combinations(sorted(set(range(len(names))) - dark), 2):
        if search.worth(repair, swapped(repair, i, j)) < 1.0 and not search.alike(i, j):
            yield f"{names[i]} and {names[j]}: not told apart"
