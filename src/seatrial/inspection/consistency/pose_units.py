# SPDX-License-Identifier: MIT
"""Readings of the poses: unit of length by plausible speeds, unit of heading by the track."""

from dataclasses import replace

import numpy as np

from seatrial.boat.physics import ABSURD_SPEED
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.accelerations import Smooth, smooth_poses
from seatrial.inspection.consistency.gains import Run, Runs, unexplained, without_drag
from seatrial.inspection.consistency.repair import ANGLES, LENGTHS, Unit
from seatrial.recording.faults.pose_faults import COMMANDS_UNKNOWN, FaultKind, examine
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Mask, earth_offset

BETTER_T = 2.4  # least t over blocks for a better reading, with many blocks
BETTER_FEW_BLOCKS = 4.0  # blocks at which that t doubles
BETTER_RATIO = 1.03  # least ratio of the unexplained acceleration for a better reading
UNIT_DOUBT_SPEED = 0.004  # [m/s] 90th percentile of the speed below which the unit is in question
UNDRIVEN_SHARE = 0.9  # of the acceleration; commands that leave less unexplained do move the boat
TYPICAL_SPEED = 0.04  # [m/s] of a slow boat in the right unit; low, as mm are more usual than cm
RADIAN_RANGE = 6.6  # one turn plus noise, in radians: a smaller range is no heading in degrees
UNIT_RATIO = 30.0  # of the speeds along x and y, above which their units differ
LEAST_WINDOWS_LEFT = 0.5  # of the windows that another unit of heading must keep usable
STAMP_TOLERANCE = 1e-6  # [s] around a fault

Factors = tuple[float, float]  # on x and y


def clearly_better(now: Array, other: Array, least_t: float = BETTER_T) -> bool:
    """Whether another reading leaves clearly less unexplained (a t-test of log ratios over blocks)."""
    if not len(now):
        return False
    usual = 0.5 * float(np.mean(now + other))  # gives quiet blocks little weight
    if usual <= 0 or float(now.sum()) < BETTER_RATIO * float(other.sum()):
        return False
    gain = np.log((now + usual) / (other + usual))
    t = float(gain.sum()) / float(np.sqrt(gain @ gain))
    return t > least_t * (1.0 + BETTER_FEW_BLOCKS / len(gain))


def declared(vehicle: Vehicle) -> tuple[str, str, str]:
    """Units of x, y and psi that the file states or implies."""
    x, y, psi = (column.unit for column in vehicle.file.pose.columns.values())
    return x or "m", y or "m", psi or "rad"


def usual_speed(runs: Runs) -> float:
    """90th percentile of the speed [m/s]."""
    return float(np.percentile(np.abs(np.concatenate([r.smooth.velocity for r in runs])), 90))


def length_units(runs: Runs, vehicle: Vehicle) -> tuple[Unit, Unit]:
    """Units of x and y that give plausible speeds; None: as the file states.

    A boat that hardly moves gets m only if the file states another unit and its commands move it.
    """
    velocity = np.concatenate([run.smooth.velocity for run in runs])
    speeds = [float(np.percentile(np.abs(v), 90)) for v in (velocity.real, velocity.imag)]
    units, top, usual = declared(vehicle)[:2], max(speeds), usual_speed(runs)
    if usual > ABSURD_SPEED:
        unit = _nearest(units[int(np.argmax(speeds))], usual)
        new = [unit if UNIT_RATIO * speed > top else None for speed in speeds]
    elif usual < UNIT_DOUBT_SPEED and "m" not in units and _is_driven(runs):
        new = ["m", "m"]
    else:
        new = [_slower(*axis, top) for axis in zip(units, speeds, strict=True)]
    x, y = (None if n == o else n for n, o in zip(new, units, strict=True))
    return x, y


def _slower(unit: str, speed: float, top: float) -> Unit:
    """m where only one coordinate is too slow in its unit, and as fast as the other in metres."""
    if speed >= UNIT_DOUBT_SPEED or UNIT_RATIO * speed >= top:
        return None
    return "m" if top < UNIT_RATIO * speed / LENGTHS[unit] < UNIT_RATIO**2 * top else None


def length_factors(units: tuple[Unit, Unit], vehicle: Vehicle) -> Factors:
    """Factors on x and y from the file's units to those found."""
    old = declared(vehicle)[:2]
    x, y = (LENGTHS[n or o] / LENGTHS[o] for n, o in zip(units, old, strict=True))
    return x, y


def heading_unit(runs: Runs, vehicle: Vehicle, lengths: Factors) -> tuple[Unit, list[Smooth]]:
    """The unit of psi, if not the file's, and the poses read in it."""
    old = declared(vehicle)[2]
    new = next(unit for unit in ANGLES if unit != old)
    factor = ANGLES[new] / ANGLES[old]
    as_is = [scaled(run.smooth, lengths) for run in runs]
    if new == "deg" and _within_a_turn(runs):
        return None, as_is
    read: list[Smooth] = []
    for run in runs:
        try:
            read.append(reread_poses(run, (*lengths, factor)))
        except RecordingError:  # in this unit every pose is a fault
            return None, as_is
        if _better(1.0, 1.0 / factor, [replace(run, smooth=read[-1])]):
            return None, as_is  # one recording is enough to keep the file's unit
    if sum(len(s.t) for s in read) < LEAST_WINDOWS_LEFT * sum(len(s.t) for s in as_is):
        return None, as_is
    other = [replace(run, smooth=s) for run, s in zip(runs, read, strict=True)]
    return (new, read) if _better(1.0 / factor, 1.0, other) else (None, as_is)


def _better(heading: float, other: float, runs: Runs) -> bool:
    """Whether the `other` factor on psi leaves clearly less unexplained than `heading`."""
    now, then = (_unexplained_either_hand(runs, factor) for factor in (heading, other))
    return clearly_better(now, then)


def _within_a_turn(runs: Runs) -> bool:
    """Whether the headings span less than a turn of radians: as degrees the boat would hardly turn."""
    raw = np.concatenate([run.recording.raw[run.recording.valid, 2] for run in runs])
    return float(np.ptp(raw)) < RADIAN_RANGE


def reread_poses(run: Run, factors: tuple[float, float, float]) -> Smooth:
    """The raw poses times factors, faults detected again. Raises RecordingError."""
    recording = run.recording
    raw = recording.raw * factors
    found = examine(recording.name, recording.stamps, raw, _unmarked(recording))
    return smooth_poses(
        recording.t, found.eta, found.valid, found.segment, stride=run.stride, window=run.window
    )


def as_measured(recording: Recording, vehicle: Vehicle) -> Recording:
    """The poses of the measured point: the vehicle file's lever arm added again.

    With the heading that the reader used to remove it, right or wrong. Faults are detected again.
    Raises RecordingError.
    """
    ahead, left = vehicle.lever
    raw = recording.raw.copy()
    raw[:, :2] += earth_offset(raw[:, 2], ahead, left)
    found = examine(recording.name, recording.stamps, raw, _unmarked(recording))
    return replace(recording, raw=raw, eta=found.eta, valid=found.valid, segment=found.segment)


def scaled(smooth: Smooth, factors: Factors) -> Smooth:
    """Velocity and acceleration with x and y multiplied."""
    x, y = factors
    if x == y == 1.0:
        return smooth
    velocity, acceleration = (
        x * part.real + 1j * y * part.imag for part in (smooth.velocity, smooth.acceleration)
    )
    return replace(smooth, velocity=velocity, acceleration=acceleration)


def _unmarked(recording: Recording) -> Mask:
    """Poses without faults that are independent of the pose values: marked, or without commands."""
    kept = np.ones(len(recording.t), dtype=bool)
    for fault in recording.faults:
        if fault.kind is FaultKind.MARKED or fault.kind in COMMANDS_UNKNOWN:
            before = recording.t < fault.start - STAMP_TOLERANCE
            kept &= before | (recording.t > fault.end + STAMP_TOLERANCE)
    return kept


def _unexplained_either_hand(runs: Runs, heading: float) -> Array:
    """Unexplained acceleration (blocks,) with the better handedness; heading: factor on psi."""
    hands = (without_drag(runs, heading=heading, mirrored=hand) for hand in (False, True))
    return min((unexplained(runs, *own) for own in hands), key=lambda left: float(left.sum()))


def _is_driven(runs: Runs) -> bool:
    """Whether inputs and drag explain a part of the squared acceleration: the commands move the boat."""
    whole = float(sum(np.sum(np.abs(run.smooth.acceleration) ** 2) for run in runs))
    return float(_unexplained_either_hand(runs, 1.0).sum()) < UNDRIVEN_SHARE * whole


def _nearest(old: str, speed: float) -> str:
    """The unit that brings a speed [m/s] nearest to `TYPICAL_SPEED`."""
    return min(
        (unit for unit in LENGTHS if LENGTHS[unit] < LENGTHS[old]),
        key=lambda unit: abs(np.log(speed * LENGTHS[unit] / LENGTHS[old] / TYPICAL_SPEED)),
        default=old,
    )
