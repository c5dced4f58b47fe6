# SPDX-License-Identifier: MIT
"""Searches that ended in a corner of the noise begin anew.

Corners hold a search though the likelihood is higher elsewhere, above all where a boat is pushed and
errors of its poses are correlated. Such errors that were let go, since they looked like motion as long as
parameters were far off, have no states any more to come back by; others end at the longest memory that a first
search allows. Where they last for seconds, as those of GNSS do, a wandering velocity stands for them, and
coefficients that follow it. Where errors are correlated and the boat is pushed, walks of the velocity may
stand for both. Where a random walk of the velocity stands for a push that comes and goes, a little
of the latter beside it explains nothing more. A push may turn with the boat, or come from one side of the world.
And waves are errors that swing, which a search comes to only from
near their period. So where there are signs of one the search begins anew from the corner opposite, and the
likelier solution is kept.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from seatrial import _core
from seatrial.boat.noise_parameters import (
    COLOUR,
    COLOUR_MEMORY,
    COLOUR_TURN,
    DISTURBANCES,
    MEMORY,
    NOISE_LEAST,
    NOISE_MOST,
    NOISE_START,
    RAISED,
    WALKS_AND_DISTURBANCES,
    fitted_noise,
    repeated_cost,
)
from seatrial.identification.likelihood.optimiser import NOTHING, Point, approach, descend
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.start_noise import (
    LASTING,
    all_coloured,
    lasting,
    pushed_and_coloured,
    swinging,
)
from seatrial.identification.likelihood.whiteness import white
from seatrial.identification.regression.start_lever import of_origin
from seatrial.identification.regression.start_values import start_values
from seatrial.identification.regression.weak_rows import Widths
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

WIDE = Widths(0.6, 3.0)  # [s] of windows that see the boat, and no waves
BRIEF = (3.0, 0.3)  # times the white errors, [s]: errors of the poses that a drift is none of
WAVES = np.geomspace(0.5, 10.0, 17)  # [s] periods to look at
NEARING = 12  # steps of a search that is only to come near
MOST_OFTEN = 3.0  # poses in a period, at the least
SIZES = (3.0, 10.0, 30.0)  # times the white errors
LONGER = 1.5  # times the longest memory of a first search: from there it may go on
WORTH = 20.0  # -2 log likelihood by which another solution must be more likely
CHANCE = 3.0  # the same of the other frame: neither is the simpler, but by chance is not found


def anew(at: Point, theta: Array) -> Point:
    """The most likely of `at` and what is found from the corners opposite.

    `theta` (p,): where the search began.
    """
    let_go = bool((at.noise[COLOUR] <= _core.NO_COLOUR).any())
    if let_go and not white(at):
        at = _likelier(at, theta, all_coloured(at.passes.problem.recordings))
    if not white(at):
        at = _likelier(at, theta, pushed_and_coloured(at.passes.problem.recordings))
    if (other := longer(at.noise)) is not None:
        at = _likelier(at, at.theta, other)
    for walk, disturbance in WALKS_AND_DISTURBANCES:
        other = exchanged(at.noise, walk, disturbance)
        if other is not None and _promises(at, other):
            at = _likelier(at, at.theta, other)
    at = reframed(at)
    problem = at.passes.problem
    if not _disturbed(at) and not white(at):
        pushes = pushed_and_coloured(problem.recordings)
        at = _likelier(at, theta, pushes, _other_frame(problem))
    for times, memory in LASTING:
        if not white(at):
            at = _likelier(at, theta, lasting(at.passes.problem.recordings, times, memory))
    if not white(at) and (other := pushed(at.noise)) is not None:
        at = _likelier(at, at.theta, other)
    if not white(at):
        at = _waved(at, theta)
    return at


def reframed(at: Point, least: Array = NOISE_LEAST) -> Point:
    """The more likely of `at` and what is found if what pushes the boat comes from one side of the world, or if it
    turns with the boat where that was so before. `least` (11,): noise is not below it."""
    if not _disturbed(at):
        return at
    other = _other_frame(at.passes.problem)
    return _likelier(at, at.theta, at.noise, other, worth=CHANCE, least=least)


def _disturbed(at: Point) -> bool:
    """Whether something pushes the boat that has a frame."""
    return bool((at.noise[DISTURBANCES] > NOTHING * RAISED[DISTURBANCES]).any())


def _other_frame(problem: Problem) -> Problem:
    return replace(problem, earth_fixed=not problem.earth_fixed)


def _waved(at: Point, theta: Array) -> Point:
    """The most likely of `at` and what is found where the poses' errors are said to swing.

    Windows that are wider than such a swing see the boat without it. From there correlated errors
    for a short while are tried: beside them the swing is seen, whose period is then the likeliest.
    """
    problem = at.passes.problem
    near = _near(problem, theta)
    waves = list(_waves(problem))
    if near is None or not waves:
        return at
    each = near.passes.each
    costs = [
        (repeated_cost(each, problem.series, noise, problem.outlier), noise) for noise in waves
    ]
    found = _likelier(at, near.theta, min(costs, key=lambda c: c[0])[1])
    swings = found.noise[COLOUR_MEMORY] * found.noise[COLOUR_TURN] > 1.0  # else it only comes back
    return found if swings else at


def _near(problem: Problem, theta: Array) -> Point | None:
    """Near a solution where all that the model does not say are errors of the poses; None: there is none."""
    with suppress(IdentificationError):  # windows that wide find no room
        noise = lasting(problem.recordings, *BRIEF)
        return approach(problem, _calm(problem, theta), noise, NEARING)
    return None


def _waves(problem: Problem) -> Iterator[Array]:
    """Noise (11,) with errors that swing, of all periods that the poses show, and sizes."""
    for period in _periods(problem):
        for times in SIZES:
            yield swinging(problem.recordings, times, float(period))


def _periods(problem: Problem) -> Array:
    """Those of waves that the poses show [s]; none where poses are rare."""
    least = MOST_OFTEN * float(np.median([r.period for r in problem.recordings]))
    return np.asarray(WAVES[least < WAVES])


def _calm(problem: Problem, theta: Array) -> Array:
    """The parameters (p,) to begin with, by windows that average swings out."""
    n, m = problem.size, problem.constants
    found = theta.copy()
    sought = [i - n for i in problem.free if n <= i < n + m]
    arms = (theta[problem.effects(i)][:2] for i in range(len(problem.recordings)))
    origins = [of_origin(r, arm) for r, arm in zip(problem.recordings, arms, strict=True)]
    found[:n], found[n : n + m] = start_values(origins, problem.vehicle, sought, widths=WIDE)
    held = [i for i in range(n + m) if i not in problem.free]
    found[held] = theta[held]
    return found


def longer(noise: Array) -> Array | None:
    """The noise (11,) with errors that may last longer, where they last as long as a first search lets them."""
    bound = NOISE_MOST[COLOUR_MEMORY]
    least = (noise[COLOUR] <= _core.NO_COLOUR).all()
    if least or not 0.99 * bound < noise[COLOUR_MEMORY] <= bound:
        return None
    other = noise.copy()
    other[COLOUR_MEMORY] = LONGER * bound
    return np.asarray(other)


def pushed(noise: Array) -> Array | None:
    """The noise (11,) with disturbances for all walks, and white errors; None where nothing walks."""
    walks = [walk for walk, _ in WALKS_AND_DISTURBANCES]
    if (noise[walks] < NOTHING * RAISED[walks]).all():
        return None
    other = noise.copy()
    other[MEMORY] = NOISE_START[MEMORY]
    for walk, disturbance in WALKS_AND_DISTURBANCES:
        made = other[walk] / np.sqrt(2.0 * other[MEMORY])
        other[disturbance] = max(other[disturbance], made, RAISED[disturbance])
        other[walk] = NOISE_LEAST[walk]
    other[COLOUR[0] :] = NOISE_START[COLOUR[0] :]
    return other


def exchanged(noise: Array, walk: int, disturbance: int) -> Array | None:
    """The noise (11,) with a disturbance for the walk of the same motion; None where there is one.

    One of size d and memory T makes the velocity walk by d sqrt(2 T) in times longer than T.
    """
    makes = np.sqrt(2.0 * noise[MEMORY])
    idle = noise[walk] < NOTHING * RAISED[walk]
    if idle or noise[disturbance] * makes > NOTHING * noise[walk]:
        return None
    other = noise.copy()
    other[disturbance] = noise[walk] / makes
    other[walk] = NOISE_LEAST[walk]
    return np.asarray(other)


def _promises(at: Point, noise: Array) -> bool:
    """Whether other noise makes likelier what the parameters are as they are."""
    passes = at.passes.each
    _, cost = fitted_noise(passes, at.passes.problem.series, noise, WORTH)
    return cost < sum(p.cost for p in passes) - WORTH


def _likelier(
    at: Point,
    theta: Array,
    noise: Array,
    problem: Problem | None = None,
    *,
    worth: float = WORTH,
    least: Array = NOISE_LEAST,
) -> Point:
    """The more likely of `at` and what is found from other parameters and noise, or as another problem.

    The other by `worth` at least.
    """
    try:
        other = descend(problem or at.passes.problem, theta, noise, at.passes.cost, least)
    except IdentificationError:
        return at
    return other if other.passes.cost < at.passes.cost - worth else at
