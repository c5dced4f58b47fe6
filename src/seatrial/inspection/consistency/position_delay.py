# SPDX-License-Identifier: MIT
"""Positions that are older than the headings beside them by more than a search that begins at none gets over."""

from dataclasses import replace

import numpy as np

from seatrial.inspection.consistency.gains import (
    Run,
    Runs,
    body,
    less,
    orthonormal,
    solved,
    unexplained,
    unexplained_share,
    without_drag,
)
from seatrial.inspection.consistency.pose_units import clearly_better
from seatrial.util.frames import Array, Index, Mask

LONGEST = 5.0  # [s] that is tried, to either side: as a clock's offset
COARSE = 2  # of so many windows the first scan takes one: half a window's weight
# [s] from which on it is stated: shorter ones are a score test's, which holds half a window to either side
LEAST_STATED = 0.6
# share of the acceleration; commands that leave less of surge and yaw have no delay
EXPLAINED = 0.1
MOST_NUMBERS = 2_000_000  # of the inputs of all delays at once: bounds memory


def position_delay(runs: Runs, offset: float = 0.0) -> float:
    """Time [s] by which positions are older than headings; negative: headings are older; 0 where it is short.

    Thrust and drag act along the heading, so positions of another time leave more of the plane's acceleration
    unexplained. offset: of the commands' clock [s], which may explain as much.
    """
    surge, _, yaw = unexplained_share(*without_drag(runs)).min(axis=0)
    if max(surge, yaw) < EXPLAINED:
        return 0.0
    # 1. A scan by whole steps between windows, which leaves their noise as it is: of some of them, then of all
    # beside the best
    step = max(float(np.median(np.diff(r.smooth.t))) for r in runs if len(r.smooth.t) > 1)
    count = int(LONGEST / (COARSE * step))
    best = _best([run.thinned(COARSE) for run in runs], step, COARSE * np.arange(-count, count + 1))
    best = _best(runs, step, best + np.arange(-1, 2))
    late = round(best * step, 3)
    if abs(late) < LEAST_STATED:
        return 0.0
    # 2. It must explain clearly more than none, than commands that act as much later (then headings are as old as
    # positions) or by another clock, than a plane of the other hand, and than a measured point beside the origin
    pairs = [paired(run, late) for run in runs]
    now, moved = ([pair[i] for pair in pairs] for i in (0, 1))
    then = unexplained(moved, *without_drag(moved))
    clocks = [[run.delayed(by) for run in now] for by in {0.0, abs(late), offset}]
    others = [*(without_drag(own) for own in clocks)]
    others += [without_drag(now, mirrored=True), without_drag(now, lever=True)]
    return late if all(clearly_better(unexplained(now, *o), then) for o in others) else 0.0


def paired(run: Run, late: float) -> tuple[Run, Run]:
    """The windows of a run that have another `late` [s] after them, and the same with that one's positions.

    Where headings are the older ones, commands are delayed like them.
    """
    nearest, known = _windows_at(run.smooth.t, run.smooth.t + late)
    own, other = run.smooth.at(known), run.smooth.at(nearest[known])
    moved = replace(own, velocity=other.velocity, acceleration=other.acceleration)
    return replace(run, smooth=own), replace(run, smooth=moved).delayed(max(-late, 0.0))


def _windows_at(t: Array, wanted: Array) -> tuple[Index, Mask]:
    """Indices of the windows nearest to the times wanted, and which are within half a step of them."""
    after = np.clip(np.searchsorted(t, wanted), 1, max(len(t) - 1, 1))
    nearest = np.where(wanted - t[after - 1] < t[after] - wanted, after - 1, after)
    return nearest, np.abs(t[nearest] - wanted) < 0.5 * float(np.median(np.diff(t)))


def _best(runs: Runs, step: float, steps: Index) -> int:
    """Of positions late by so many steps [s]: those that leave least of the plane's acceleration."""
    lates = np.asarray(steps * step, dtype=np.float64)
    numbers = sum(run.inputs.size for run in runs)
    batches = np.array_split(lates, 1 + len(steps) * numbers // MOST_NUMBERS)
    return int(steps[np.argmin(np.concatenate([_left(runs, batch) for batch in batches]))])


def _left(runs: Runs, lates: Array) -> Array:
    """Mean square of the plane's acceleration that drag, wind and inputs leave, for each delay [s] (lates,)."""
    every = [_moved(run, lates) for run in runs]
    plane, drag, inputs = (np.concatenate(parts, axis=-2) for parts in zip(*every, strict=True))
    basis = orthonormal(drag)
    plane, inputs = less(plane, basis)[:, None], less(inputs, basis[:, None])
    left = np.sum((plane - inputs @ solved(inputs, plane)) ** 2, axis=-2)  # (lates, delays, 2)
    count = np.count_nonzero(drag[..., 0], axis=-1)  # drag's first column is 1
    return np.asarray(
        np.where(count > 0, left.min(axis=1).sum(axis=-1), np.inf) / np.maximum(count, 1)
    )


def _moved(run: Run, lates: Array) -> tuple[Array, Array, Array]:
    """The second run of `paired` for each delay, 0 where a window has no other.

    Accelerations of the plane (lates, m, 2), drag (lates, m, DRAG_COLUMNS), inputs (lates, delays, m, n): those of
    whole steps between windows, without averaging them again.
    """
    s = run.smooth
    nearest, known = _windows_at(s.t, s.t + lates[:, None])
    own = np.broadcast_to(np.arange(len(s.t)), nearest.shape)
    moved = replace(s.at(own), velocity=s.velocity[nearest], acceleration=s.acceleration[nearest])
    motion, drag = body(moved)
    inputs = run.inputs[:, np.where(lates[:, None] >= 0.0, own, nearest)].swapaxes(0, 1)
    there = known[..., None]
    return motion[..., :2] * there, drag * there, inputs * there[:, None]
