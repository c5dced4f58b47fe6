# SPDX-License-Identifier: MIT
"""Gains of inputs whose actuators follow their commands at different times: each with its own delay and lag.

With one delay for all, the slower one of two equal thrusters looks weak.
"""

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from seatrial.inspection.consistency.accelerations import averaged
from seatrial.inspection.consistency.gains import (
    UNEXPLAINED_BLOCK,
    Run,
    blocks,
    solved,
    without_drag,
)
from seatrial.inspection.consistency.pose_units import clearly_better
from seatrial.util.frames import Array

OWN_DELAYS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)  # [s] tried
OWN_LAGS = (0.0, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)  # [s] tried: of motors and gears
QUANTILES = 12  # delays whose mean stands for a lag: of equal shares of its response
SHARED = [0, 2]  # surge and yaw, the axes that thrusters share


def own_gains(runs: Sequence[Run]) -> Array | None:
    """Gains (3, n) of inputs with their own delay and lag; None where these explain no more than common ones."""
    responses = list(product(OWN_DELAYS, OWN_LAGS))
    every = np.concatenate([_followed(run, responses) for run in runs], axis=1)
    motion, inputs = without_drag(runs, every)
    same, own = _best_responses(motion, inputs)
    # they must explain clearly more
    now, then = (
        np.column_stack([inputs[k][:, i] for i, k in enumerate(one)]) for one in (same, own)
    )
    better = clearly_better(_by_block(runs, motion, now), _by_block(runs, motion, then))
    return solved(then, motion).T if better else None


def _followed(run: Run, responses: Sequence[tuple[float, float]]) -> Array:
    """The commands as actuators with each delay and lag [s] follow them, averaged like the accelerations."""
    left = 1.0 - np.arange(QUANTILES) / QUANTILES  # of a step, at the beginning of each share
    moments = np.append(left * (1.0 - np.log(left)), 0.0)
    spread = -np.diff(moments) * QUANTILES  # mean time of each share of the response, in lags
    s = run.smooth
    if len(s.t) == 0:
        return np.zeros((len(responses), 0, len(run.commands.names)))
    delays = np.array([delay + lag * spread for delay, lag in responses])
    bounds = (float(delays.min()), float(delays.max()))
    found = averaged(run.commands, run.recording.origin, s.t, s.half, bounds)
    return np.array([found.before(s.t, own).mean(axis=0) for own in delays])


def _best_responses(motion: Array, inputs: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The response that explains most as one for all, and each input's own (n,); inputs: (responses, m, n)."""
    count, _, n = inputs.shape
    columns = np.concatenate(list(inputs), axis=1)  # (m, count n)
    normal, right = columns.T @ columns, columns.T @ motion[:, SHARED]
    total = np.sum(motion[:, SHARED] ** 2, axis=0)

    def best(tries: NDArray[np.int64]) -> NDArray[np.int64]:
        """Of responses by input (tries, n) those with the least sum of log squares over the axes."""
        at = tries * n + np.arange(n)
        own = normal[at[:, :, None], at[:, None, :]]
        ridge = 1e-6 * np.trace(own, axis1=1, axis2=2) / n + np.finfo(float).tiny
        gain = np.linalg.solve(own + ridge[:, None, None] * np.eye(n), right[at])
        left = np.maximum(total - np.sum(gain * right[at], axis=1), np.finfo(float).tiny)
        return np.asarray(tries[np.argmin(np.log(left).sum(axis=1))], dtype=np.int64)

    same = best(np.repeat(np.arange(count)[:, None], n, axis=1))
    own = same
    both = np.array(list(product(range(count), repeat=2)))
    for i, j in combinations(range(n), 2):
        tries = np.repeat(own[None], len(both), axis=0)
        tries[:, [i, j]] = both
        own = best(tries)
    return same, own


def _by_block(runs: Sequence[Run], motion: Array, inputs: Array) -> Array:
    """Squares (blocks,) that inputs do not explain of the shared axes, each over its mean."""
    left = (motion - inputs @ solved(inputs, motion))[:, SHARED] ** 2
    size = np.mean(motion[:, SHARED] ** 2, axis=0)
    squares = np.sum(left / np.where(size > 0.0, size, np.inf), axis=1)
    return np.asarray(np.bincount(blocks(runs, UNEXPLAINED_BLOCK), squares), dtype=np.float64)
