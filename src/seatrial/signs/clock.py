# SPDX-License-Identifier: MIT
"""Commands whose stamps are of another clock: what they do is seen seconds before or after them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.frames import Array
from seatrial.recording import Signal
from seatrial.signs.gains import DELAYS, Run, cleared, left_over
from seatrial.signs.smooth import smooth_signals

OFFSETS = np.arange(-33, 34) * 0.15  # [s] 5 s to either side
POOR = 0.1  # share of the accelerations that is left in every axis: then it is looked further
CLEAR = 2.0  # fall of the sum of its logarithms over the axes from which on another delay is right


def clock_offset(runs: Sequence[Run]) -> float:
    """How much later than their stamps [s] the commands act; 0 where usual delays explain them as well."""
    motion, inputs = cleared(runs)
    near = left_over(motion, inputs)
    if near.min() < POOR:
        return 0.0
    wide = np.concatenate([_averaged(run) for run in runs], axis=1)
    far = np.log(left_over(*cleared(runs, wide))).sum(axis=1)
    best = int(np.argmin(far))
    inside = (DELAYS[0] - 0.2 < OFFSETS) & (DELAYS[-1] + 0.2 > OFFSETS)
    if inside[best] or far[best] > np.log(near).sum(axis=1).min() - CLEAR:
        return 0.0
    return float(OFFSETS[best])


def _averaged(run: Run) -> Array:
    s = run.smooth
    return smooth_signals(run.commands, run.recording.origin, s.t, s.half, OFFSETS.tolist())


def later(run: Run, offset: float) -> Run:
    """The run with its commands so much later [s]."""
    c = run.commands
    return replace(run, commands=Signal(c.names, c.stamps + round(1e9 * offset), c.values))
