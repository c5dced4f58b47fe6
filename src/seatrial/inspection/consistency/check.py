# SPDX-License-Identifier: MIT
"""The consistency check of a vehicle file with recordings, clocks included, and its report."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from seatrial.boat.actuators import STAGES
from seatrial.boat.steering import angle_names
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.accelerations import held_rows, smooth_signals
from seatrial.inspection.consistency.changed_input import changed_input
from seatrial.inspection.consistency.effects import effects_of, surge_t
from seatrial.inspection.consistency.gains import (
    DELAYS,
    Gains,
    Runs,
    block_count,
    enough,
    gains,
    read_runs,
    unexplained,
    unexplained_share,
    without_drag,
)
from seatrial.inspection.consistency.hypotheses import HypothesisSearch, negated, swapped
from seatrial.inspection.consistency.inconsistencies import (
    Inconsistency,
    change_inconsistency,
    clock_inconsistency,
    delay_inconsistency,
    inconsistencies,
    steering_inconsistencies,
)
from seatrial.inspection.consistency.oblique import oblique_angle, with_heading_turned
from seatrial.inspection.consistency.pose_units import (
    as_measured,
    clearly_better,
    heading_unit,
    length_factors,
    length_units,
    usual_speed,
)
from seatrial.inspection.consistency.position_delay import paired, position_delay
from seatrial.inspection.consistency.repair import Repair, apply_repair
from seatrial.inspection.consistency.steering_angle import angle_text, steering_angles
from seatrial.recording.delays import at_one_time
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.recording.undriven import without_undriven_ends
from seatrial.util.errors import RecordingError
from seatrial.util.frames import AXES, Array

STRAIGHT_HEADING = 0.1  # [rad] least standard deviation of the heading that shows the handedness
MOST_WINDOWED = 7200.0  # [s] of recordings at full window rate; longer ones are thinned to it
NOT_EXCITED = "hardly excited; its sign is not checked"
NEVER_COMMANDED = "the commands never change; record them while the boat is driven"
TOO_SHORT = "too short to check signs; record two minutes or more"
ONE_LINE = (
    "the heading varies by {:.1f} deg (standard deviation): on one line exchanged x and y, another zero of the "
    "heading and another sign of an input look alike; record turns, too"
)
OFFSETS = np.arange(-33, 34) * 0.15  # [s] that are tried: 5 s to either side
OFFSET_BATCHES = 9  # evaluated one after another, to bound memory
UNEXPLAINED_ENOUGH = 0.1  # share of the acceleration; an axis below it needs no other delay
CLEAR_FALL = 2.0  # least fall of sum(log(unexplained share)) over the axes for another delay
USUAL_MARGIN = 0.2  # [s] beyond `DELAYS` that still counts as a delay of the boat, not as a clock


@dataclass(frozen=True)
class Gain:
    """Gain from one input to one axis, with the columns as the file reads them."""

    input: str
    axis: int
    value: float  # [m/s^2] or [rad/s^2] per unit of the file's command; forward-left-up
    t: float


@dataclass(frozen=True)
class ConsistencyReport:
    """Inconsistencies, the effect of each input, and what the data do not determine."""

    findings: tuple[Inconsistency, ...]  # empty: all that can be checked is consistent
    table: tuple[Gain, ...]
    text: tuple[str, ...]  # the effect of each input, and what is not checked
    repair: Repair
    search: HypothesisSearch | None = field(default=None, compare=False)  # None: too little data
    unexcited: tuple[str, ...] = ()  # inputs whose sign the recordings do not determine
    angles: tuple[str, ...] = ()  # inputs that look like angles, and are none in the file, in words

    def repaired(self, vehicle: Vehicle) -> Vehicle:
        """The vehicle file with all inconsistencies corrected."""
        return apply_repair(vehicle, self.repair)


def check_consistency(recordings: Sequence[Recording], vehicle: Vehicle) -> ConsistencyReport:
    """Units, signs and order of a vehicle file's signals, from all recordings taken together.

    With a lever arm, the poses are first checked at the measured point: the reader removes the lever
    with the heading as read, and a wrong heading moves the origin to the wrong side.
    """
    if any(vehicle.lever):
        with suppress(RecordingError):
            measured = _checked([as_measured(r, vehicle) for r in recordings], vehicle)
            if measured.repair.pose_edits or any(measured.repair.units):
                return measured
    return _checked(recordings, vehicle)


def _checked(recordings: Sequence[Recording], vehicle: Vehicle) -> ConsistencyReport:
    """The check of poses as they are read.

    Units come first, then a change of an input's effect, the clock, the positions' delay, the handedness: each is
    corrected before the next.
    """
    # 1. Local quadratics through the poses; enough data?
    recordings = [without_undriven_ends(at_one_time(r)) for r in recordings]
    spacing = max(1.0, sum(r.duration for r in recordings) / MOST_WINDOWED)
    runs = read_runs(recordings, [file_commands(vehicle, r) for r in recordings], spacing=spacing)
    commanded = any(np.ptp(r.commands.values, axis=0).any() for r in recordings)
    if not (commanded and enough(runs)):
        return _not_excited(vehicle, commanded=commanded)
    # 2. Units of length by plausible speeds, unit of heading by the unexplained acceleration.
    speed, lengths = usual_speed(runs), length_units(runs, vehicle)
    angle, read = heading_unit(runs, vehicle, length_factors(lengths, vehicle))
    runs = [replace(run, smooth=s) for run, s in zip(runs, read, strict=True)]
    # 3. A part in which an input has less effect: what follows is of the rest.
    moved = without_drag(runs)
    known = {*angle_names(vehicle.file.chain), *_rudders_in_flow(vehicle)}
    change = changed_input(runs, unexplained_share(*moved), known)
    if change is not None:
        runs = change.left_out(runs)
        moved = without_drag(runs)
    # 4. Clock of the commands, or positions older than headings, where these turn; both, one after the other.
    spread = _heading_spread(runs)
    turns = spread > STRAIGHT_HEADING
    offset = clock_offset(runs, *moved)
    late = position_delay(runs, offset) if turns else 0.0
    offset = 0.0 if late else offset
    if offset:
        runs = [run.delayed(offset) for run in runs]
        late = position_delay(runs) if turns else 0.0
    runs = [paired(run, late)[1] for run in runs] if late else runs
    moved = without_drag(runs)
    # 5. Handedness of the plane, then the gain from every input to every axis.
    other_hand = without_drag(runs, mirrored=True)
    mirrored = turns and clearly_better(unexplained(runs, *moved), unexplained(runs, *other_hand))
    found = gains(runs, *(other_hand if mirrored else moved))
    # 6. The fewest edits of signs and order that explain the gains.
    search = HypothesisSearch(vehicle, found, mirrored, block_count(runs))
    best = search.best()
    off = oblique_angle(search, best)
    if off:  # in the axes of the file
        search = with_heading_turned(search, off)
        best = replace(search.no_edit, angle=vehicle.axes.lateral_sign * off)
    repair = replace(best, units=(*lengths, angle), late=late)
    effects, said = effects_of(vehicle, search, repair, recordings)
    unexcited = _unexcited(vehicle, search, repair)
    wrong = (
        *clock_inconsistency(offset),
        *delay_inconsistency(vehicle, late),
        *change_inconsistency(change, recordings),
        *inconsistencies(vehicle, repair, effects, speed),
        *steering_inconsistencies(vehicle, surge_t(vehicle, search, repair), effects),
    )
    angles = steering_angles(runs, np.array([g.t for g in found]), mirrored=mirrored)
    steer = tuple(f"{n}: {angle_text(turned)}" for n, turned in angles.items() if n not in known)
    remarks = (
        *said,
        *steer,
        *(() if turns else (ONE_LINE.format(np.degrees(spread)),)),
        *(f"{vehicle.inputs[i]}: {NOT_EXCITED}" for i in unexcited),
        *_exchangeable(vehicle, search, repair, unexcited),
    )
    names = tuple(vehicle.inputs[i] for i in unexcited)
    return ConsistencyReport(wrong, _table(vehicle, found), remarks, repair, search, names, steer)


def _rudders_in_flow(vehicle: Vehicle) -> set[str]:
    """Inputs whose force in yaw the structure has with |u| only."""
    turning = {name: f.of for name, f in (vehicle.file.forces or {}).items() if f.axis == AXES[2]}
    terms = [t.factors for t in vehicle.structure.terms if set(t.factors) & set(turning)]
    still = {name for factors in terms if "|u|" not in factors for name in factors}
    flow = {name for factors in terms for name in factors} - still
    return {n for name, of in turning.items() if name in flow for n in of}


def _not_excited(vehicle: Vehicle, *, commanded: bool) -> ConsistencyReport:
    """The report on recordings that are too short, or in which nothing is commanded."""
    n = len(vehicle.inputs)
    nothing = Repair(order=tuple(range(n)), input_signs=(1,) * n)
    not_excited = [f"{name}: {NOT_EXCITED}" for name in vehicle.inputs]
    text = (TOO_SHORT,) if commanded else (NEVER_COMMANDED, *not_excited)
    return ConsistencyReport((), (), text, nothing)


def _heading_spread(runs: Runs) -> float:
    """Standard deviation [rad] of twice the heading, halved: what shows the handedness.

    A mirrored plane turns by twice the heading: on a straight track that is a constant rotation,
    which the gains absorb.
    """
    twice = np.exp(2j * np.concatenate([run.smooth.psi for run in runs]))
    return float(np.sqrt(-np.log(np.clip(np.abs(twice.mean()), 1e-9, 1.0)) / 2.0))


def file_commands(vehicle: Vehicle, recording: Recording) -> Signal:
    """Commands in the file's own axes, times the thrust factor of known signals (`scales`)."""
    signal, scales = recording.commands, recording.scales
    turned = (vehicle.input_signs < 0).any()  # else no copy of a long recording
    own = replace(signal, values=signal.values * vehicle.input_signs) if turned else signal
    if scales is None or all(group.scale is None for group in vehicle.file.chain):
        return own
    stamps = np.union1d(signal.stamps, scales.stamps)
    stamps = stamps[stamps >= signal.stamps[0]]
    t = (stamps - stamps[0]) * 1e-9
    origin = int(stamps[0])
    factor = _thrust_factor(vehicle, scales.values[held_rows(scales.stamps, origin, t)])
    return Signal(own.names, stamps, own.values[held_rows(own.stamps, origin, t)] * factor)


def _thrust_factor(vehicle: Vehicle, scales: Array) -> Array:
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


def _unexcited(vehicle: Vehicle, search: HypothesisSearch, repair: Repair) -> list[int]:
    """Inputs that explain the motion as well with the other sign."""
    every = range(len(vehicle.inputs))
    return [i for i in every if search.relative_misfit(repair, negated(repair, i)) < 1.0]


def _exchangeable(
    vehicle: Vehicle, search: HypothesisSearch, repair: Repair, unexcited: Sequence[int]
) -> Iterator[str]:
    """Pairs of inputs that explain the motion as well in the other order."""
    names = vehicle.inputs
    for i, j in combinations([k for k in range(len(names)) if k not in unexcited], 2):
        alike = search.relative_misfit(repair, swapped(repair, i, j)) < 1.0
        if alike and not search.interchangeable(i, j):
            yield f"{names[i]} and {names[j]}: not distinguishable"


def clock_offset(runs: Runs, motion: Array, inputs: Array) -> float:
    """Delay of the commands' effect [s] where it is outside the usual delays; else 0.

    motion, inputs: those of the runs, `without_drag`.
    """
    # 1. The usual delays: enough where one axis is explained.
    usual = unexplained_share(motion, inputs)
    if usual.min() < UNEXPLAINED_ENOUGH:
        return 0.0
    # 2. A grid of offsets, the same criterion.
    batches = np.array_split(OFFSETS, OFFSET_BATCHES)
    far = np.concatenate([_log_unexplained(runs, batch) for batch in batches])
    best = int(np.argmin(far))
    # 3. The best offset counts if it is no usual delay and explains clearly more.
    near_usual = (DELAYS[0] - USUAL_MARGIN < OFFSETS) & (DELAYS[-1] + USUAL_MARGIN > OFFSETS)
    if near_usual[best] or far[best] > np.log(usual).sum(axis=1).min() - CLEAR_FALL:
        return 0.0
    return float(OFFSETS[best])


def _log_unexplained(runs: Runs, offsets: Array) -> Array:
    """Sum over the axes of log(unexplained share), for each offset [s]: (offsets,)."""
    averaged = [
        smooth_signals(r.commands, r.recording.origin, r.smooth.t, r.smooth.half, offsets.tolist())
        for r in runs
    ]
    share = unexplained_share(*without_drag(runs, np.concatenate(averaged, axis=1)))
    return np.asarray(np.log(share).sum(axis=1))
