# SPDX-License-Identifier: MIT
"""The search for the likelihood's maximum.

Gauss and Newton's steps, damped as Levenberg and Marquardt's, on the parameters; Fisher's scoring
on the noise, by passes linearised about the last full one. Both steps come from one pass: the
information between parameters and noise is 0 for normal errors.
"""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.causal import NOISE_LEAST, NOISE_MOST, spread
from seatrial.errors import IdentificationError
from seatrial.frames import Array
from seatrial.identify.problem import Passes, Problem

# position [m], heading [rad], walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory [s]
RAISED = np.array([0.0, 0.0, 5e-4, 2e-3, 1e-3, 3e-3, 0.0])
PROCESS, DISTURBANCES, MEMORY = (2, 6), [4, 5], 6
NOISE_STEP = 2.5  # the largest of a logarithm
FAR = 10.0  # the cost's fall by other noise from which on the search is far from its end
FALLING = 0.3  # a step of a logarithm that may be one of an endless way down
TINY = 1e-12
CURVATURE = 0.3  # at the least, of a logarithm: what the data do not speak of stays where it is
SETTLED = 0.01  # the cost's fall that the next step promises: 0.1 standard errors of all together
NOISE_SETTLED = 0.1
ITERATIONS = 40
TRIALS = 6


@dataclass(frozen=True)
class Point:
    """Where the search stands."""

    theta: Array
    noise: Array
    passes: Passes


def search(
    problem: Problem,
    theta: Array,
    noise: Array,
    *,
    hold: bool = False,
    least: Array = NOISE_LEAST,
) -> Point:
    """The most likely parameters and, unless they are held, noise levels, not below `least` (7,).

    Raises IdentificationError where the boat diverges, or where the search gets nowhere.
    """
    noise = np.maximum(noise, least)
    at = Point(theta, noise, problem.passes(theta, noise))
    if not np.isfinite(at.passes.cost):
        raise IdentificationError(
            "the boat diverges from the start values; look at the recordings with inspect"
        )
    damping, flat = 1e-4, 0
    for _ in range(ITERATIONS):
        better, gain = (at.noise, 0.0) if hold else fitted_noise(at, least)
        for trial in range(TRIALS):
            move, promised = step_within(at, damping)
            if (promised < SETTLED and gain < NOISE_SETTLED) or flat == 2:
                return at
            last = trial == TRIALS - 1  # then the noise alone
            there = at.theta if last else at.theta + move
            believed = _further(at.noise, better) if trial == 0 and gain > FAR else better
            found = problem.passes(there, believed)
            if found.cost < at.passes.cost:
                flat = flat + 1 if at.passes.cost - found.cost < NOISE_SETTLED else 0
                at = Point(there, believed, found)
                damping /= 10.0
                break
            damping = max(10.0 * damping, 1e-3)
        else:
            return at
    raise IdentificationError(
        f"no solution after {ITERATIONS} steps; drive more, or state what is known of "
        "the thrusters in the vehicle file (chain)"
    )


def _further(before: Array, after: Array) -> Array:
    """Process noise that falls falls as far again: the parameters' step will leave less to it."""
    further = after * np.clip(after / before, np.exp(-NOISE_STEP), 1.0)
    out = after.copy()
    first, last = PROCESS
    out[first:last] = np.maximum(further, NOISE_LEAST)[first:last]
    return out


def step_within(at: Point, damping: float) -> tuple[Array, float]:
    """A step of all parameters within bounds and reach, and the fall of the cost that it promises.

    Parameters that would go further stop there, and the others' step is solved anew.
    """
    problem = at.passes.problem
    free = np.array(problem.free)
    low, high = (bound - at.theta[free] for bound in problem.bounds)
    near, far = np.maximum(low, -problem.reach), np.minimum(high, problem.reach)
    gradient, information = at.passes.gradient, at.passes.information
    damped = information + damping * np.diag(np.diag(information) + TINY)
    step, held = np.zeros(len(free)), np.zeros(len(free), dtype=bool)
    for _ in range(len(free)):
        go = ~held
        pull = gradient[go] - information[np.ix_(go, held)] @ step[held]
        scale = 1.0 / np.sqrt(np.diag(damped)[go] + TINY)
        matrix = damped[np.ix_(go, go)] * np.outer(scale, scale)
        step[go] = scale * np.linalg.solve(matrix, scale * pull)
        beyond = go & ((step < low) | (step > high))  # first: what pulls the others along with it
        if not beyond.any():
            beyond = go & ((step < near) | (step > far))
        if not beyond.any():
            break
        step[beyond] = np.clip(step, near, far)[beyond]
        held |= beyond
    move = np.zeros(len(at.theta))
    move[free] = step
    return move, float(2.0 * step @ gradient - step @ information @ step)


def fitted_noise(at: Point, least: Array = NOISE_LEAST) -> tuple[Array, float]:
    """Noise under which the errors are more likely, the model as it is; the fall of the cost.

    One step of Fisher's scoring on the logarithms. What falls is tried at its least, too: there
    the way down is endless and ever flatter; what is at its least is tried higher up again.
    """
    problem = at.passes.problem
    pairs = list(zip(at.passes.each, problem.series, strict=True))
    low, high = np.log(least), np.log(NOISE_MOST)

    def cost(phi: Array) -> float:
        one = np.exp(phi)
        return sum(spread(lambda p: _core.repeated(*p, one, problem.outlier), pairs))

    phi = np.log(at.noise)
    active = phi > low
    active[MEMORY] = active[DISTURBANCES].any()
    mask = int(np.sum(active.astype(int) << np.arange(len(phi))))
    parts = spread(lambda p: _core.noise_slopes(*p, at.noise, problem.outlier, mask), pairs)
    first = here = sum(p[0] for p in parts)
    gradient, information = sum(p[1] for p in parts), sum(p[2] for p in parts)
    damping = 1e-3
    for _ in range(TRIALS):
        matrix = information + np.diag(damping * np.diag(information) + CURVATURE)
        move = np.clip(np.linalg.solve(matrix, gradient), -NOISE_STEP, NOISE_STEP)
        trial = np.clip(phi - move, low, high)
        found = cost(trial)
        if found < here:
            phi, here = trial, found
            break
        damping = max(10.0 * damping, 1e-2)
    for i in range(*PROCESS):
        fell = active[i] and move[i] > FALLING
        raised = not active[i] and first - here < NOISE_SETTLED
        if fell or raised:
            trial = phi.copy()
            trial[i] = low[i] if fell else np.log(RAISED[i])
            found = cost(trial)
            phi, here = (trial, found) if found < here else (phi, here)
    return np.exp(phi), first - here
