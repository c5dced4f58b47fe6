# SPDX-License-Identifier: MIT
"""An input that moves the boat less in a part of a recording: a thruster that stops, a fouled propeller."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from seatrial.inspection.consistency.effects import CLEAR_T
from seatrial.inspection.consistency.gains import (
    UNEXPLAINED_BLOCK,
    Run,
    Runs,
    blocks,
    body,
    enough,
    gains,
    less,
    orthonormal,
    without_drag,
)
from seatrial.inspection.consistency.pose_units import clearly_better
from seatrial.util.frames import Array, Mask

TIMES = 16  # of a change that are tried over all recordings, then beside the best
FINER = 2  # times
MARGIN = 4.0  # [s] beside the change that is left out with the part
SHORTEST = 20.0  # [s] before a change, and after it
# of the effect, from which on it is stated: curves and dead zones reach 0.3 where manoeuvres differ
LEAST_CHANGE = 0.4
LEAST_T = 4.0  # of the accelerations that it explains: the best of many times and inputs
EVERY = 3  # of so many windows, which overlap, one is looked at
LEAST_LENGTH = 1e-6  # of a step beside other inputs and drag, over its own: a shorter one is theirs


@dataclass(frozen=True)
class InputChange:
    """A part of a recording in which an input has less effect than in the rest."""

    input: str
    run: int
    begin: float  # [s] from the recording's start; 0: from there
    end: float  # infinite: to its end
    factor: float  # of the effect in it to that in the rest

    def left_out(self, runs: Runs) -> list[Run]:
        """The runs without that part."""
        own = runs[self.run]
        rest = own.smooth.at((own.smooth.t < self.begin) | (own.smooth.t > self.end))
        return [replace(run, smooth=rest) if k == self.run else run for k, run in enumerate(runs)]


@dataclass(frozen=True)
class _Constant:
    """What constant effects of all inputs leave of the accelerations."""

    runs: Runs
    inputs: Array  # (m, n)
    drag: Array  # (m, DRAG_COLUMNS)
    motion: Array  # (m, 3)
    basis: Array  # (m, DRAG_COLUMNS + n) orthonormal
    left: Array  # (m, 3)


@dataclass(frozen=True)
class _Step:
    """From a time on, another effect of one input."""

    run: int
    at: float  # [s]
    input: int
    direction: Array  # (m,) of length 1, beside all inputs and drag


def changed_input(runs: Runs, shares: Array, angles: Collection[str] = ()) -> InputChange | None:
    """The most evident change of an input's effect on all axes; None where none is large and clear.

    shares: (delays, 3) of the accelerations that are left without one, `unexplained_share`. angles: inputs whose
    effect is that of another's thrust, or of the speed.
    """
    # 1. Constant effects at the best delay, in some of the windows
    delay = int(np.argmin(np.log(shares).sum(axis=1)))
    constant = _constant_effects([run.thinned(EVERY) for run in runs], delay)
    # 2. The step of an input that explains most of what they leave, and clearly
    names = runs[0].commands.names
    step = _best_step(constant, np.array([name not in angles for name in names]))
    if step is None or not _is_clear(constant, step):
        return None
    # 3. It is large, and of an input that moves the boat in the rest
    change = _as_change(constant, step)
    rest = change.left_out(constant.runs)
    if change.factor > 1.0 - LEAST_CHANGE or not enough(rest):
        return None
    t = max(abs(float(own.t[step.input])) for own in gains(rest, *without_drag(rest)))
    return change if t >= CLEAR_T else None


def _constant_effects(runs: Runs, delay: int) -> _Constant:
    parts = [body(run.smooth) for run in runs]
    motion, drag = (np.concatenate(part) for part in zip(*parts, strict=True))
    inputs = np.concatenate([run.inputs[delay] for run in runs])
    basis = orthonormal(np.hstack([drag, inputs]))
    return _Constant(runs, inputs, drag, motion, basis, less(motion, basis))


def _best_step(constant: _Constant, thrusts: Mask) -> _Step | None:
    """The step of a thrust (n,) that explains most, of a grid of times, then finer ones; None: no time for one."""
    runs = constant.runs
    span = max(SHORTEST, sum(np.ptp(run.smooth.t) for run in runs if len(run.smooth.t)) / TIMES)
    every = [(k, t) for k, run in enumerate(runs) for t in _times(run, 0.0, np.inf, span)]
    if not every or not thrusts.any() or not constant.left.any(axis=0).all():
        return None
    step = _best_of(constant, thrusts, every)
    for _ in range(FINER):
        beside = _times(runs[step.run], step.at - span, step.at + span, 2.0 * span / TIMES)
        step = _best_of(constant, thrusts, [(step.run, t) for t in beside])
        span *= 2.0 / TIMES
    return step


def _times(run: Run, first: float, last: float, step: float) -> Iterator[float]:
    """Possible changes of a run between two times [s], each so far from the next."""
    t = run.smooth.t
    if len(t):
        begin, end = max(first, t[0] + SHORTEST), min(last, t[-1] - SHORTEST)
        yield from np.arange(begin, end, step).tolist()


def _best_of(constant: _Constant, thrusts: Mask, every: list[tuple[int, float]]) -> _Step:
    """Of steps of each thrust in these runs at these times [s]: the one that explains most of what is left."""
    inputs, left = constant.inputs, constant.left
    after = np.column_stack([_after(constant.runs, k, at) for k, at in every])
    steps = (after[:, :, None] * inputs[:, None, :]).reshape(len(inputs), -1)
    own = less(steps, constant.basis)
    length = np.linalg.norm(own, axis=0)
    own /= np.where(length > LEAST_LENGTH * np.linalg.norm(steps, axis=0), length, np.inf)
    share = np.minimum((own.T @ left) ** 2 / np.sum(left**2, axis=0), 1.0 - LEAST_LENGTH)
    best = int(np.argmax(-np.log1p(-share).sum(axis=1) * np.tile(thrusts, len(every))))
    time, i = divmod(best, inputs.shape[1])
    k, at = every[time]
    return _Step(k, at, i, own[:, best])


def _after(runs: Runs, k: int, at: float) -> Array:
    """(m,): 1 in the windows of a run from a time [s] on."""
    after = [(j == k) & (run.smooth.t >= at) for j, run in enumerate(runs)]
    return np.concatenate(after).astype(float)


def _is_clear(constant: _Constant, step: _Step) -> bool:
    """Whether the step leaves clearly less of the accelerations of all axes, each over its own size."""
    left, block = constant.left, blocks(constant.runs, UNEXPLAINED_BLOCK)
    size = np.sum(left**2, axis=0)
    now, then = (
        np.asarray(np.bincount(block, np.sum(rest**2 / size, axis=1)), dtype=np.float64)
        for rest in (left, left - np.outer(step.direction, step.direction @ left))
    )
    return clearly_better(now, then, LEAST_T)


def _as_change(constant: _Constant, step: _Step) -> InputChange:
    """The side of the step on which the input has less effect."""
    # 1. The effect on each axis before and after it, over what is left there
    own, after = constant.inputs[:, step.input], _after(constant.runs, step.run, step.at)
    others = np.delete(constant.inputs, step.input, axis=1)
    columns = np.column_stack([own * (1.0 - after), own * after, others, constant.drag])
    effects = np.linalg.lstsq(columns, constant.motion, rcond=None)[0][:2]
    more, fewer = effects / np.linalg.norm(constant.left, axis=0)
    # 2. The smaller one
    begin, end = step.at - MARGIN, np.inf
    if more @ more < fewer @ fewer:
        more, fewer, begin, end = fewer, more, 0.0, step.at + MARGIN
    name = constant.runs[step.run].commands.names[step.input]
    return InputChange(name, step.run, begin, end, float(more @ fewer / (more @ more)))
