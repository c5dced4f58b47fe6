# SPDX-License-Identifier: MIT
"""Readings of the poses: the unit of length, the unit of heading."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.boat.physics import ABSURD_SPEED
from seatrial.boat.vehicle import Vehicle, as_column
from seatrial.inspection.consistency.accelerations import Smooth, smooth_poses
from seatrial.inspection.consistency.gains import Run, squared, unexplained
from seatrial.inspection.consistency.repair import ANGLES, LENGTHS, Unit
from seatrial.recording.pose_faults import UNKNOWN, FaultKind, examine
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Mask

CLEAR = 2.4  # t over blocks, given many, that another reading must be better by;
FEW = 4.0  # so many blocks double it
WORTH = 1.03  # and the least ratio of what is left unexplained
STILL = 0.004  # [m/s] a boat that is slower hardly moves ...
MOVED = 0.9  # ... unless its commands leave less than this share of its acceleration unexplained
TYPICAL = 0.04  # [m/s] speed of a slow boat: cm are rarer than mm
RADIANS = 6.6  # a turn and its noise, in radians
APART = 30.0  # speeds along x and y that differ by more are in different units

Factors = tuple[float, float]  # on x and y


def clearly_better(now: Array, other: Array) -> bool:
    """Whether another reading leaves clearly less unexplained. (blocks,) each; of none it does not."""
    if not len(now):
        return False
    usual = 0.5 * float(np.mean(now + other))  # so that quiet blocks count little
    if usual <= 0 or float(now.sum()) < WORTH * float(other.sum()):
        return False
    gain = np.log((now + usual) / (other + usual))
    t = float(gain.sum()) / float(np.sqrt(gain @ gain))
    return t > CLEAR * (1.0 + FEW / len(gain))


def declared(vehicle: Vehicle) -> tuple[str, str, str]:
    """Units of x, y and psi that the file states or implies."""
    pose = vehicle.file.pose
    x, y, psi = (as_column(c).unit for c in (pose.x, pose.y, pose.psi))
    return x or "m", y or "m", psi or "rad"


def usual_speed(runs: Sequence[Run]) -> float:
    """90th percentile of the speed [m/s]."""
    return float(np.percentile(np.abs(np.concatenate([r.smooth.velocity for r in runs])), 90))


def length_units(runs: Sequence[Run], vehicle: Vehicle) -> tuple[Unit, Unit]:
    """Units that x and y are really in, by speeds that no boat has. None: as the file says.

    Of a boat that hardly moves the file's unit must be other than m, and its commands must move it.
    """
    velocity = np.concatenate([run.smooth.velocity for run in runs])
    speeds = [float(np.percentile(np.abs(v), 90)) for v in (velocity.real, velocity.imag)]
    units, top, usual = declared(vehicle)[:2], max(speeds), usual_speed(runs)
    if usual > ABSURD_SPEED:
        unit = _nearest(units[int(np.argmax(speeds))], usual)
        new = [unit if APART * speed > top else None for speed in speeds]
    elif usual < STILL and "m" not in units and _left(runs) < MOVED:
        new = ["m", "m"]
    else:
        new = [_slower(*axis, top) for axis in zip(units, speeds, strict=True)]
    x, y = (None if n == o else n for n, o in zip(new, units, strict=True))
    return x, y


def _slower(unit: str, speed: float, top: float) -> Unit:
    """m where one coordinate alone is too slow for its unit: as metres it would go as the other."""
    if speed >= STILL or APART * speed >= top:
        return None
    return "m" if top < APART * speed / LENGTHS[unit] < APART**2 * top else None


def length_factors(units: tuple[Unit, Unit], vehicle: Vehicle) -> Factors:
    """What x and y must be multiplied by."""
    old = declared(vehicle)[:2]
    x, y = (LENGTHS[n or o] / LENGTHS[o] for n, o in zip(units, old, strict=True))
    return x, y


def heading_unit(
    runs: Sequence[Run], vehicle: Vehicle, lengths: Factors
) -> tuple[Unit, list[Smooth]]:
    """The unit that psi is really in, if not the file's, and the poses read so."""
    old = declared(vehicle)[2]
    new = next(unit for unit in ANGLES if unit != old)
    factor = ANGLES[new] / ANGLES[old]
    as_is = [stretched(run.smooth, lengths) for run in runs]
    if new == "deg" and _within_a_turn(runs):
        return None, as_is
    read: list[Smooth] = []
    for run in runs:
        try:
            read.append(reread(run, (*lengths, factor)))
        except RecordingError:  # so read, they are no poses
            return None, as_is
        own = [replace(run, smooth=read[-1])]
        if clearly_better(_least(own, 1.0), _least(own, 1.0 / factor)):
            return None, as_is  # one recording is enough to say so
    if sum(len(s.t) for s in read) < 0.5 * sum(len(s.t) for s in as_is):
        return None, as_is
    other = [replace(run, smooth=s) for run, s in zip(runs, read, strict=True)]
    if clearly_better(_least(other, 1.0 / factor), _least(other, 1.0)):
        return new, read
    return None, as_is


def _within_a_turn(runs: Sequence[Run]) -> bool:
    """Whether headings stay where radians do: as degrees, the boat hardly turned at all."""
    raw = np.concatenate([run.recording.raw[run.recording.valid, 2] for run in runs])
    return float(np.ptp(raw)) < RADIANS


def reread(run: Run, factors: tuple[float, float, float]) -> Smooth:
    """The raw poses times factors, their faults found again. Raises RecordingError."""
    recording = run.recording
    raw = recording.raw * factors
    usable = _unmarked(recording)
    found = examine(recording.name, recording.stamps, raw, usable)
    return smooth_poses(recording.t, found.eta, found.valid, found.segment, stride=run.stride)


def as_measured(recording: Recording, vehicle: Vehicle) -> Recording:
    """The poses of the point that was measured, the vehicle file's lever arm put back.

    By the heading that it was taken off with: if that is read wrongly, so is where the origin went. Faults are
    found again. Raises RecordingError.
    """
    ahead, left = vehicle.lever
    raw = recording.raw.copy()
    c, s = np.cos(raw[:, 2]), np.sin(raw[:, 2])
    raw[:, :2] += np.column_stack([c * ahead - s * left, s * ahead + c * left])
    found = examine(recording.name, recording.stamps, raw, _unmarked(recording))
    return replace(recording, raw=raw, eta=found.eta, valid=found.valid, segment=found.segment)


def stretched(smooth: Smooth, factors: Factors) -> Smooth:
    """The same with x and y multiplied."""
    x, y = factors
    if x == y == 1.0:
        return smooth
    velocity, acceleration = (
        x * part.real + 1j * y * part.imag for part in (smooth.velocity, smooth.acceleration)
    )
    return replace(smooth, velocity=velocity, acceleration=acceleration)


def _unmarked(recording: Recording) -> Mask:
    """Poses that were not left out for other reasons than where they are."""
    kept = np.ones(len(recording.t), dtype=bool)
    for fault in recording.faults:
        if fault.kind is FaultKind.MARKED or fault.kind in UNKNOWN:
            kept &= (recording.t < fault.start - 1e-6) | (recording.t > fault.end + 1e-6)
    return kept


def _least(runs: Sequence[Run], heading: float) -> Array:
    """What is left unexplained by the better of both hands. (blocks,)."""
    both = [unexplained(runs, heading, mirrored=hand) for hand in (False, True)]
    return min(both, key=lambda left: float(left.sum()))


def _left(runs: Sequence[Run]) -> float:
    """Share of the squared acceleration that is left unexplained."""
    whole = squared(runs)
    return float(_least(runs, 1.0).sum()) / whole if whole > 0 else 1.0


def _nearest(old: str, speed: float) -> str:
    """The unit that brings a speed [m/s] nearest to a small boat's."""
    return min(
        (unit for unit in LENGTHS if LENGTHS[unit] < LENGTHS[old]),
        key=lambda unit: abs(np.log(speed * LENGTHS[unit] / LENGTHS[old] / TYPICAL)),
        default=old,
    )
