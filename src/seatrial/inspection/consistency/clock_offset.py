# SPDX-License-Identifier: MIT
"""Offset between the clock of the commands and the clock of the poses, from their correlation."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.inspection.consistency.accelerations import smooth_signals
from seatrial.inspection.consistency.gains import DELAYS, Run, unexplained_share, without_drag
from seatrial.recording.recording import Signal
from seatrial.util.frames import Array

OFFSETS = np.arange(-33, 34) * 0.15  # [s] that are tried: 5 s to either side
OFFSET_BATCHES = 9  # evaluated one after another, to bound memory
UNEXPLAINED_ENOUGH = 0.1  # share of the acceleration; an axis below it needs no other delay
CLEAR_FALL = 2.0  # least fall of sum(log(unexplained share)) over the axes for another delay
USUAL_MARGIN = 0.2  # [s] beyond `DELAYS` that still counts as a delay of the boat, not as a clock


def clock_offset(runs: Sequence[Run]) -> float:
    """Delay of the commands' effect [s] where it is outside the usual delays; else 0."""
    # 1. The usual delays: enough where one axis is explained.
    motion, inputs = without_drag(runs)
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


def _log_unexplained(runs: Sequence[Run], offsets: Array) -> Array:
    """Sum over the axes of log(unexplained share), for each offset [s]: (offsets,)."""
    averaged = [
        smooth_signals(r.commands, r.recording.origin, r.smooth.t, r.smooth.half, offsets.tolist())
        for r in runs
    ]
    return np.asarray(
        np.log(unexplained_share(*without_drag(runs, np.concatenate(averaged, axis=1)))).sum(axis=1)
    )


def delayed(run: Run, offset: float) -> Run:
    """The run with its commands delayed by `offset` [s]."""
    c = run.commands
    return replace(run, commands=Signal(c.names, c.stamps + round(1e9 * offset), c.values))
