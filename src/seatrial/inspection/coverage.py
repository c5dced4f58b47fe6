# SPDX-License-Identifier: MIT
"""Coverage of the commands: each axis by amplitude, direction and minutes; each input's values."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from seatrial.boat.model import thrust_trace
from seatrial.boat.physics import full_forces
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.excitation import Excitation, even_times, excitation
from seatrial.recording.faults.pose_faults import GAP_FACTOR
from seatrial.recording.recording import Recording
from seatrial.util.frames import AXES, Array, Index

AT_REST_COMMAND = 0.05  # of full command, below which an axis is at rest
SIZE_BOUNDS = (1 / 3, 2 / 3)  # of full command, between small, medium and large
MOST_GRID_LEVELS = 4096  # levels of a quantised command (12 bits); above it is continuous
ON_GRID_SHARE = 0.95  # of the values not at rest that lie on the grid of a quantised command
EQUAL_STEPS = 1.02  # ratio below which two steps between levels are equal
GRID_TOLERANCE = 0.1  # of a step, distance of a value from the grid
LIMIT_MARGIN = 0.002  # of the range, within which a command is at its limit


@dataclass(frozen=True)
class AxisCoverage:
    """Commanded force of one axis while poses were recorded."""

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
    at_limit: float  # share of the driven time at its least or most value
    never_moves: bool


def coverage(vehicle: Vehicle, recording: Recording) -> tuple[Excitation, list[AxisCoverage]]:
    """Minutes by axis, direction and size of the generalised forces."""
    found = excitation(vehicle, recording)
    times = even_times(recording)
    period = float(times[1] - times[0]) if len(times) > 1 else recording.duration
    t = _with_poses(recording, times)
    forces = thrust_trace(vehicle, vehicle.constants.values, recording).forces(t)
    shares = forces / list(full_forces(vehicle).values())  # of full command
    axes = []
    for axis, largest in enumerate((largest_of_each(vehicle, shares) * vehicle.axes.signs).T):
        size = np.abs(largest)
        bounds = (AT_REST_COMMAND, *SIZE_BOUNDS, np.inf)
        within = [(size > a) & (size <= b) for a, b in pairwise(bounds)]
        minutes = [float(inside.sum()) * period / 60 for inside in within]
        axes.append(
            AxisCoverage(
                AXES[axis], float(found.rms[axis]), float(found.largest[axis]), float(found.share[axis]),
                found.both_signs[axis], float((largest > AT_REST_COMMAND).sum()) * period / 60,
                float((largest < -AT_REST_COMMAND).sum()) * period / 60, *minutes,
            )
        )  # fmt: skip
    return found, axes


def _with_poses(recording: Recording, t: Array) -> Array:
    """Times [s] that lie between usable poses, not in a gap."""
    good = recording.t[recording.valid]
    after = np.searchsorted(good, t, side="right").clip(1, len(good) - 1)
    inside = (t >= good[0]) & (good[after] - good[after - 1] <= GAP_FACTOR * recording.usual_step)
    return np.asarray(t[inside])


def input_use(vehicle: Vehicle, recording: Recording) -> list[InputUse]:
    """Every input's range, steps and limits, in the vehicle file's axes."""
    signal = recording.commands
    held = np.append(np.diff(signal.stamps), 0).astype(np.float64)
    values = signal.values * vehicle.input_signs + 0.0  # no -0
    return [_use(name, values[:, i], held) for i, name in enumerate(signal.names)]


def _use(name: str, values: Array, held: Array) -> InputUse:
    levels, rows = np.unique(values, return_counts=True)
    least, most = float(levels[0]), float(levels[-1])
    if len(levels) == 1:
        return InputUse(name, least, most, 0.0, 1, 0.0, never_moves=True)
    near = LIMIT_MARGIN * (most - least)
    limit = (values >= most - near) | (values <= least + near)
    moving = np.abs(values - np.median(values)) > AT_REST_COMMAND * max(abs(least), abs(most))
    driven = float(held[moving].sum())
    share = float(held[moving & limit].sum()) / driven if driven > 0 else 0.0
    return InputUse(
        name, least, most, _resolution(levels, rows), len(levels), share,
        never_moves=False,
    )  # fmt: skip


def _resolution(levels: Array, rows: Index) -> float:
    """Step of the grid of a quantised command; 0 for a continuous one.

    The most frequent step between neighbouring levels, if nearly all values are whole steps from
    the resting value.
    """
    steps = np.sort(np.diff(levels))
    alike = np.searchsorted(steps, EQUAL_STEPS * steps, side="right") - np.arange(len(steps))
    first = int(np.argmax(alike))
    usual = float(np.median(steps[first : first + alike[first]]))
    driven = np.where(np.arange(len(levels)) == np.argmax(rows), 0, rows)
    for step in (usual, usual / 2, usual / 3):  # not all levels occur
        off = (levels - levels[np.argmax(rows)]) / step
        on_grid = float(driven[np.abs(off - np.rint(off)) < GRID_TOLERANCE].sum())
        few = levels[-1] - levels[0] < MOST_GRID_LEVELS * step
        if few and on_grid >= ON_GRID_SHARE * driven.sum():
            return step
    return 0.0


def largest_of_each(vehicle: Vehicle, forces: Array) -> Array:
    """Of forces (n, forces) the one of largest magnitude in each axis (n, 3); 0 where there is none."""
    found = np.zeros((len(forces), 3))
    for axis in range(3):
        mine = forces[:, vehicle.forces_of(axis)]
        if mine.shape[1]:
            found[:, axis] = mine[np.arange(len(mine)), np.argmax(np.abs(mine), axis=1)]
    return found
