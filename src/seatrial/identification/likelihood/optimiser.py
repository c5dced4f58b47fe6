# SPDX-License-Identifier: MIT
"""The search for the likelihood's maximum.

Gauss and Newton's steps, damped as Levenberg and Marquardt's, on the parameters; Fisher's scoring
on the noise, by passes linearised about the last full one. Both steps come from one pass: the
information between parameters and noise is 0 for normal errors.
"""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.noise_parameters import (
    COLOUR,
    COLOUR_MEMORY,
    NOISE_LEAST,
    NOISE_SETTLED,
    NOISE_STEP,
    PROCESS,
    RAISED,
    likelier_noise,
    loosened,
    most_noise,
    repeated_cost,
    swings,
)
from seatrial.identification.likelihood.problem import Passes, Problem
from seatrial.identification.likelihood.start_noise import all_coloured
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

FAR = 10.0  # the cost's fall by other noise from which on the search is far from its end
TINY = 1e-12
RIDGE = 1e-12  # of damping, at the least: terms that are one and the same have no single step
SETTLED = 0.01  # the cost's fall that the next step promises: 0.1 standard errors of all together
NOISE_ENOUGH = 0.3  # by other noise, then
COLOUR_WORTH = 10.0  # -2 log likelihood that correlated errors must be worth
NOTHING = 0.01  # share of other process noise, or of what is tried, that does not matter
DRIFTS = 8  # steps in a row with hanging errors as long as they may get: rather motion
ASTRAY = 100.0  # -2 log likelihood of each pose: a model that far off says not where to go
LOOSE = (10.0, 1.0)  # times the process noise of a first one, that it is believed with then
NEAR = 100.0  # the cost's fall that the next step promises: enough for less of it
STUCK = 1000.0  # the same, or that of other noise, where no step is a step down: no solution
BOX_STEPS = 4  # for each parameter, at most
ALONG = 0.9  # cosine of two moves of the noise that go the same way
CREEPS, LEAP = 3, 5.0  # after so many of them it goes so many times as far again
ITERATIONS = 40
PATIENCE, FALLS = 5, 10.0  # steps, then so many falls like the last two must reach its aim
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
    """The most likely parameters and, unless they are held, noise levels, not below `least` (11,).

    Correlated errors of the poses are believed only where the data ask for them. Where they
    drift it begins again with all errors correlated, then with none.
    Raises IdentificationError where the boat diverges, or where the search gets nowhere.
    """
    begin = _within(_point(problem, theta, np.clip(noise, least, most_noise(noise))))
    if astray(begin):
        begin = _loosely(begin, hold, least)
    if hold:
        return _descent(begin, hold, least)
    try:
        at = _descent(begin, hold, least)
    except IdentificationError:
        if not coloured(begin.noise):
            raise
        at = _otherwise(begin, theta, least)
    return _needed(at, least)


def _otherwise(begin: Point, theta: Array, least: Array) -> Point:
    """What is found where correlated errors drifted: from all errors correlated, then
    without such errors, then by waiting for how they end."""
    problem = begin.passes.problem
    all_of_it = np.clip(all_coloured(problem.recordings), least, None)
    white = begin.noise.copy()
    white[COLOUR] = least[COLOUR]
    for noise in (all_of_it, white):
        with suppress(IdentificationError):
            return _descent(_point(problem, theta, noise), False, least)
    return _descent(_whole(begin), False, least, drifts=np.inf)


def _within(at: Point) -> Point:
    """The same, or where that is outside bounds what is more likely: a step from there into them, which
    moves the others as they then must, or the nearest place."""
    problem = at.passes.problem
    nearest = problem.bounded(at.theta)
    if (nearest == at.theta).all():
        return at
    if not np.isfinite(at.passes.cost):  # then its slopes say nothing
        return _point(problem, nearest, at.noise)
    stepped = problem.bounded(at.theta + step_within(at, 0.0)[0])
    tried = (_point(problem, theta, at.noise) for theta in (stepped, nearest))
    return min(tried, key=lambda p: p.passes.cost if np.isfinite(p.passes.cost) else np.inf)


def astray(at: Point) -> bool:
    """Whether the model is far from the poses, or diverges."""
    poses = sum(len(r.t) for r in at.passes.problem.recordings)
    return not at.passes.cost < ASTRAY * poses


def _point(problem: Problem, theta: Array, noise: Array) -> Point:
    return Point(theta, noise, problem.passes(theta, noise))


def _loosely(at: Point, hold: bool, least: Array) -> Point:
    """The same with more process noise, which the search then lessens; where noise is held, what is
    found with less and less of it."""
    problem, theta = at.passes.problem, at.theta
    for times in LOOSE:
        loose = _point(problem, theta, loosened(at.noise, times))
        if not hold:
            return loose
        theta = _descent(loose, hold, least, NEAR).theta
    return _point(problem, theta, at.noise)


def descend(
    problem: Problem,
    theta: Array,
    noise: Array,
    beat: float = np.inf,
    least: Array = NOISE_LEAST,
) -> Point:
    """`search` that does not start anew without correlated errors where they drift; those
    that begin as ones that last may do so all the way. Given up where it does not fall
    fast enough to get below the cost to `beat`."""
    begin, most = _point(problem, theta, noise), most_noise(noise)
    at = _descent(begin, False, least, most=most, beat=beat, drifts=np.inf)
    return _needed(at, least)


def approach(problem: Problem, theta: Array, noise: Array, steps: int) -> Point:
    """Where a search has got to after so many steps, or before, if that is its end."""
    return _descent(_point(problem, theta, noise), False, NOISE_LEAST, steps=steps)


def _needed(at: Point, least: Array) -> Point:
    """Without errors that are correlated but make little likelier; as it is, where none is found without."""
    while (whiter := _whiter(at, least)) is not None:
        try:
            at = _descent(_point(at.passes.problem, at.theta, whiter), False, least)
        except IdentificationError:
            break
    return at


def coloured(noise: Array) -> bool:
    """Whether errors of the poses are believed to be correlated."""
    return bool((noise[COLOUR] > _core.NO_COLOUR).any())


def _drifting(noise: Array, most: Array) -> bool:
    """Whether errors of the poses last as long as they may, beside a boat that is pushed, too."""
    longest = noise[COLOUR_MEMORY] > 0.99 * most[COLOUR_MEMORY]
    larger = (noise[COLOUR] > noise[:2]).any()
    pushed = (noise[PROCESS] > NOTHING * RAISED[PROCESS]).any()
    return bool(longest and larger and pushed and not swings(noise))


def _whiter(at: Point, least: Array) -> Array | None:
    """The noise (11,) without errors that are correlated but make little likelier; None: all do.

    Let go, or counted as white: so those are that fade within a pose.
    """
    problem, passes = at.passes.problem, at.passes.each
    here = sum(p.cost for p in passes)
    for white, i in enumerate(COLOUR):
        if at.noise[i] <= _core.NO_COLOUR:
            continue
        for size in (at.noise[white], np.hypot(at.noise[white], at.noise[i])):
            without = at.noise.copy()
            without[i], without[white] = least[i], size
            cost = repeated_cost(passes, problem.series, without, problem.outlier)
            if cost < here + COLOUR_WORTH:
                return without
    return None


def _descent(
    at: Point,
    hold: bool,
    least: Array,
    settled: float = SETTLED,
    *,
    most: Array | None = None,
    beat: float = np.inf,
    steps: int = ITERATIONS,
    drifts: float = DRIFTS,
) -> Point:
    """Down from a point, until the next step promises less than `settled`.

    steps: at most; where they are fewer than a search may have, it ends where it got to. drifts: steps
    in a row with errors of the poses that last as long as they may, with which it is given up.
    """
    most = most_noise(at.noise) if most is None else most
    problem = at.passes.problem
    if not np.isfinite(at.passes.cost):
        raise IdentificationError(
            "the boat diverges from the start values; look at the recordings with inspect"
        )
    damping, hope, flat, drifting, creeps = 1e-4, 0.0, 0, 0, 0
    way = np.zeros(len(at.noise))
    costs: list[float] = []
    for _ in range(steps):
        costs.append(at.passes.cost)
        if len(costs) > PATIENCE and costs[-1] - beat > FALLS * (costs[-3] - costs[-1]):
            raise IdentificationError("what was found before is likelier")
        better, gain = (
            (at.noise, 0.0)
            if hold
            else likelier_noise(
                at.passes.each, problem.series, at.noise, problem.outlier, least=least, most=most
            )
        )
        before, way = way, np.log(better / at.noise)
        along = way @ before > ALONG * np.linalg.norm(way) * np.linalg.norm(before)
        creeps = creeps + 1 if along else 0
        drifting = drifting + 1 if _drifting(better, most) else 0
        if drifting == drifts:
            raise IdentificationError("errors of the poses that drift can't be told from motion")
        for trial in range(TRIALS):
            move, promised = step_within(at, damping)
            hope = max(gain, promised) if trial == 0 else hope
            if (promised < settled and gain < NOISE_ENOUGH) or flat == 2:
                return _whole(at)
            at.passes.forget_poses()  # those of long recordings need not be there twice
            last = trial == TRIALS - 1  # then the noise alone
            there = at.theta if last else at.theta + move
            believed = better
            if trial == 0 and creeps >= CREEPS:
                believed = np.clip(better * np.exp(LEAP * way), least, most)
            elif trial == 0 and gain > FAR:
                believed = _further(at.noise, better)
            found = problem.passes(there, believed)
            if found.cost < at.passes.cost:
                flat = flat + 1 if at.passes.cost - found.cost < NOISE_SETTLED else 0
                at = Point(there, believed, found)
                damping /= 10.0
                break
            found.forget_poses()
            damping = max(10.0 * damping, 1e-3)
        else:
            if hope > STUCK:
                raise IdentificationError(
                    "no solution: the search is stuck where it should still improve; do poses and commands "
                    "belong together, by one clock? If so, state what is known of the thrusters in the "
                    "vehicle file (chain)"
                )
            return _whole(at)
    if steps < ITERATIONS:
        return _whole(at)
    raise IdentificationError(
        f"no solution after {ITERATIONS} steps; do poses and commands belong together, by one "
        "clock? If so, drive more, or state what is known of the thrusters in the vehicle file (chain)"
    )


def _whole(at: Point) -> Point:
    """The same with all that was let go."""
    if at.passes.repeatable:
        return at
    return Point(at.theta, at.noise, at.passes.problem.passes(at.theta, at.noise))


def _further(before: Array, after: Array) -> Array:
    """Process noise that falls falls as far again: the parameters' step will leave less to it."""
    further = after * np.clip(after / before, np.exp(-NOISE_STEP), 1.0)
    out = after.copy()
    out[PROCESS] = np.maximum(further, NOISE_LEAST)[PROCESS]
    return out


def step_within(at: Point, damping: float) -> tuple[Array, float]:
    """A step of all parameters within bounds and reach, and the fall of the cost that it promises."""
    problem = at.passes.problem
    free = np.array(problem.free)
    low, high = (bound - at.theta[free] for bound in problem.bounds)
    gradient, information = at.passes.gradient, at.passes.information
    diagonal = np.diag(information) + TINY
    scale = 1.0 / np.sqrt(diagonal)
    step = scale * lowest_within(
        (information + max(damping, RIDGE) * np.diag(diagonal)) * np.outer(scale, scale),
        scale * gradient,
        np.maximum(low, -problem.reach) / scale,
        np.minimum(high, problem.reach) / scale,
    )
    move = np.zeros(len(at.theta))
    move[free] = step
    return move, float(2.0 * step @ gradient - step @ information @ step)


def lowest_within(matrix: Array, pull: Array, low: Array, high: Array) -> Array:
    """Where x' M x / 2 - b' x is lowest in a box around 0.

    matrix: M (p, p), positive definite; pull: b (p,); low, high: (p,). Active sets: Nocedal and Wright,
    Numerical Optimization, 2nd ed., algorithm 16.3. What stops at a bound goes on once the others let it.
    """
    x = np.clip(np.zeros(len(pull)), low, high)
    held = np.zeros(len(pull), dtype=bool)
    for _ in range(BOX_STEPS * len(pull)):
        go = np.flatnonzero(~held)
        to = x.copy()
        rest = pull[go] - matrix[np.ix_(go, held)] @ x[held]
        to[go] = np.linalg.solve(matrix[np.ix_(go, go)], rest)
        edge = np.clip(to, low, high)
        beyond = go[edge[go] != to[go]]
        if len(beyond):
            shares = (edge - x)[beyond] / (to - x)[beyond]
            first = beyond[int(np.argmin(shares))]
            x += float(shares.min()) * (to - x)
            x[first], held[first] = edge[first], True
            continue
        x = to
        slope = pull - matrix @ x
        back = held & (low < high) & np.where(x <= low, slope > 0.0, slope < 0.0)
        if not back.any():
            break
        held[int(np.argmax(np.where(back, np.abs(slope), 0.0)))] = False
    return x
