# SPDX-License-Identifier: MIT
"""Positions that are older than the headings beside them by more than a search that begins at none gets over."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.inspection.consistency.gains import (
    Run,
    projected,
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


def position_delay(runs: Sequence[Run], offset: float = 0.0) -> float:
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
    some = [run.thinned(COARSE) for run in runs]
    best = COARSE * min(range(-count, count + 1), key=lambda k: _left(some, k * COARSE * step))
    best = min((best - 1, best, best + 1), key=lambda k: _left(runs, k * step))
    late = round(best * step, 3)
    if abs(late) < LEAST_STATED:
        return 0.0
    # 2. It must explain clearly more than none, than commands that act as much later (then headings are as old as
    # positions) or by another clock, and than a plane of the other hand
    pairs = [paired(run, late) for run in runs]
    now, moved = ([pair[i] for pair in pairs] for i in (0, 1))
    then = unexplained(moved, *without_drag(moved))
    clocks = [[run.delayed(by) for run in now] for by in {0.0, abs(late), offset}]
    others = [*(without_drag(own) for own in clocks), without_drag(now, mirrored=True)]
    return late if all(clearly_better(unexplained(now, *o), then) for o in others) else 0.0


def paired(run: Run, late: float) -> tuple[Run, Run]:
    """The windows of a run that have another `late` [s] after them, and the same with that one's positions.

    Where headings are the older ones, commands are delayed like them.
    """
    index, known = _windows_at(run.smooth.t, run.smooth.t + late)
    own, other = run.smooth.at(known), run.smooth.at(index)
    moved = replace(own, velocity=other.velocity, acceleration=other.acceleration)
    return replace(run, smooth=own), replace(run, smooth=moved).delayed(max(-late, 0.0))


def _windows_at(t: Array, wanted: Array) -> tuple[Index, Mask]:
    """Indices of windows within half a step of the times wanted, and a mask of the wanted that have one."""
    after = np.clip(np.searchsorted(t, wanted), 1, max(len(t) - 1, 1))
    nearest = np.where(wanted - t[after - 1] < t[after] - wanted, after - 1, after)
    known = np.abs(t[nearest] - wanted) < 0.5 * float(np.median(np.diff(t)))
    return nearest[known].astype(np.int64), known


def _left(runs: Sequence[Run], late: float) -> float:
    """Mean square of the plane's acceleration that drag, wind and inputs leave with positions so late [s]."""
    own = [paired(run, late)[1] for run in runs]
    inputs = np.concatenate([_inputs(run, late) for run in runs], axis=1)
    count = sum(len(run.smooth.t) for run in own)
    return float(unexplained(own, *projected(own, inputs)[1]).sum()) / count if count else np.inf


def _inputs(run: Run, late: float) -> Array:
    """Inputs of the second run of `paired`, for whole steps between windows: without averaging them again."""
    index, known = _windows_at(run.smooth.t, run.smooth.t + late)
    return run.inputs[:, known if late >= 0.0 else index]
