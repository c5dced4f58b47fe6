# SPDX-License-Identifier: MIT
"""Commands whose stamps are of another clock: what they do is seen seconds before or after them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.inspection.consistency.accelerations import smooth_signals
from seatrial.inspection.consistency.gains import DELAYS, Run, cleared, left_over
from seatrial.recording.recording import Signal
from seatrial.util.frames import Array

OFFSETS = np.arange(-33, 34) * 0.15  # [s] 5 s to either side
PARTS = 9  # one after the other: all at once would be large
POOR = 0.1  # share of the accelerations that is left in every axis: then it is looked further
CLEAR = 2.0  # fall of the sum of its logarithms over the axes from which on another delay is right


def clock_offset(runs: Sequence[Run]) -> float:
    """How much later than their stamps [s] the commands act; 0 where usual delays explain them as well."""
    motion, inputs = cleared(runs)
    near = left_over(motion, inputs)
    if near.min() < POOR:
        return 0.0
    far = np.concatenate([_explained(runs, part) for part in np.array_split(OFFSETS, PARTS)])
    best = int(np.argmin(far))
    inside = (DELAYS[0] - 0.2 < OFFSETS) & (DELAYS[-1] + 0.2 > OFFSETS)
    if inside[best] or far[best] > np.log(near).sum(axis=1).min() - CLEAR:
        return 0.0
    return float(OFFSETS[best])


def _explained(runs: Sequence[Run], offsets: Array) -> Array:
    """Sums (offsets,) over the axes of the logarithm of what is left."""
    averaged = [
        smooth_signals(r.commands, r.recording.origin, r.smooth.t, r.smooth.half, offsets.tolist())
        for r in runs
    ]
    return np.asarray(
        np.log(left_over(*cleared(runs, np.concatenate(averaged, axis=1)))).sum(axis=1)
    )


def later(run: Run, offset: float) -> Run:
    """The run with its commands so much later [s]."""
    c = run.commands
    return replace(run, commands=Signal(c.names, c.stamps + round(1e9 * offset), c.values))
