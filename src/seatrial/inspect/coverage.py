# SPDX-License-Identifier: MIT
"""How the boat was driven: each axis by amplitude, direction and minutes; each input's values."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from seatrial.excitation import Excitation, excitation
from seatrial.frames import AXES, Array
from seatrial.model import thrust_trace
from seatrial.recording import Recording, Signal
from seatrial.vehicle import Vehicle

REST = 0.05  # command below which an axis counts as at rest
LEVELS = (1 / 3, 2 / 3)  # bounds of small, medium and large commands
MOST_LEVELS = 1024  # more different values than these are not called steps
OFF_GRID = 0.1  # share of a step by which values on a grid may miss it
EDGE = 0.002  # share of the range within which a command counts as at its limit


@dataclass(frozen=True)
class AxisCoverage:
    """What one axis was asked for while poses were recorded."""

    axis: str
    rms: float  # in command units
    largest: float
    share: float  # of all effort
    both_directions: bool
    minutes_positive: float  # forward, to port or counter-clockwise; in the vehicle file's axes
    minutes_negative: float
    minutes_small: float  # by size of the command
    minutes_medium: float
    minutes_large: float


@dataclass(frozen=True)
class InputUse:
    """The values of one input over time."""

    name: str
    least: float
    most: float
    resolution: float  # step of the grid that the values are on; 0: none
    levels: int  # different values
    at_limit: float  # share of the time not at rest that it spends at its least or most
    never_moves: bool


def coverage(vehicle: Vehicle, recording: Recording) -> tuple[Excitation, list[AxisCoverage]]:
    """Minutes by axis, direction and size of the generalised forces."""
    found = excitation(vehicle, recording)
    period = min(0.05, recording.period)
    t = np.arange(0.0, recording.duration, period)
    forces = thrust_trace(vehicle, vehicle.constants.values, recording).forces(t)
    signs = np.array([vehicle_sign(vehicle, axis) for axis in range(3)])
    axes = []
    for axis, name in enumerate(AXES):
        mine = forces[:, [i for i, f in enumerate(vehicle.forces) if f.axis == axis]]
        largest = _largest(mine) * signs[axis]
        size = np.abs(largest)
        bounds = (REST, *LEVELS, np.inf)
        minutes = [
            float(((size > a) & (size <= b)).sum()) * period / 60 for a, b in pairwise(bounds)
        ]
        axes.append(
            AxisCoverage(
                name, float(found.rms[axis]), float(found.largest[axis]), float(found.share[axis]),
                found.both_signs[axis], float((largest > REST).sum()) * period / 60,
                float((largest < -REST).sum()) * period / 60, *minutes,
            )
        )  # fmt: skip
    return found, axes


def vehicle_sign(vehicle: Vehicle, axis: int) -> float:
    """1, or -1 where the vehicle file's axis points the other way than forward-left-up."""
    return -1.0 if vehicle.axes.value == "forward-right-down" and axis > 0 else 1.0


def input_use(recording: Recording) -> list[InputUse]:
    """Every input's range, steps and limits, as forward-left-up commands."""
    signal = recording.commands
    held = np.append(np.diff(signal.stamps), 0).astype(np.float64)
    return [_use(name, signal.values[:, i], held, signal) for i, name in enumerate(signal.names)]


def _use(name: str, values: Array, held: Array, signal: Signal) -> InputUse:
    levels = np.unique(values)
    least, most = float(levels[0]), float(levels[-1])
    if len(levels) == 1:
        return InputUse(name, least, most, 0.0, 1, 0.0, never_moves=True)
    near = EDGE * (most - least)
    limit = (values >= most - near) | (values <= least + near)
    moving = np.abs(values - np.median(values)) > REST * max(abs(least), abs(most))
    driven = float(held[moving].sum())
    share = float(held[moving & limit].sum()) / driven if driven > 0 else 0.0
    return InputUse(
        name, least, most, _resolution(levels, len(signal.stamps)), len(levels), share,
        never_moves=False,
    )  # fmt: skip


def _resolution(levels: Array, rows: int) -> float:
    """Step of the grid that the values come from; 0 where they come from none."""
    if len(levels) > min(MOST_LEVELS, max(2, rows // 4)):
        return 0.0
    steps = np.diff(levels)
    step = float(np.median(steps[steps < 1.5 * steps.min()]))
    off = np.abs(steps / step - np.rint(steps / step))
    return step if float(np.percentile(off, 95)) < OFF_GRID else 0.0


def _largest(mine: Array) -> Array:
    """At every time the force of largest magnitude; 0 where there is none."""
    if mine.shape[1] == 0:
        return np.zeros(len(mine))
    return np.asarray(mine[np.arange(len(mine)), np.argmax(np.abs(mine), axis=1)])
