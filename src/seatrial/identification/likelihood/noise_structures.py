# SPDX-License-Identifier: MIT
"""Multi-start over noise structures: restarts where a solution is at a corner of the noise space.

The likelihood has local optima in the noise, above all for a boat with a disturbance force and correlated pose
errors:
- Correlated pose errors that were set to 0 while the parameters were far off do not return by themselves.
- Pose errors with a memory of seconds (GNSS) end at the longest memory of a first search; process noise and
  wrong coefficients explain the rest.
- A random walk of the velocity stands for a Gauss-Markov disturbance, or for both kinds of errors.
- A disturbance may be fixed to the boat or to the earth.
- Oscillating pose errors (waves) are found only from near their period.
For each sign of one of these the search restarts from the opposite corner, and the likelier solution stays.
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
from seatrial.identification.likelihood.optimiser import (
    NEGLIGIBLE_NOISE,
    Point,
    descend_below,
    descend_some_steps,
)
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.start_noise import (
    LONG_CORRELATIONS,
    disturbance_and_gauss_markov,
    gauss_markov_for_white,
    gauss_markov_poses,
    oscillating_poses,
)
from seatrial.identification.likelihood.whiteness import is_white
from seatrial.identification.regression.start_lever import poses_of_origin
from seatrial.identification.regression.start_values import start_values
from seatrial.identification.regression.weak_rows import Widths
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

# All gains are falls of -2 log likelihood.
# that another noise structure must reach: it may have several parameters more
NOISE_SWITCH_GAIN = 20.0
# that the other frame of the disturbance must reach: it has no parameter more
FRAME_SWITCH_GAIN = 3.0
# times the longest memory of a first search, as start of one with a longer memory
MEMORY_EXTENSION = 1.5
AT_LONGEST_MEMORY = 0.99  # of that longest memory: there a search counts as stopped by it
TRIED_WAVE_PERIODS = np.geomspace(0.5, 10.0, 17)  # [s] that are tried
WAVE_SIZES = (3.0, 10.0, 30.0)  # times the white errors, that are tried
POSES_PER_WAVE = 3.0  # at the least: fewer do not show an oscillation
# [s] of windows that average waves out, but not the boat's motion
WAVE_FREE_WIDTHS = Widths(0.6, 3.0)
BRIEF_CORRELATION = (3.0, 0.3)  # times the white errors, [s]: too short to be taken for motion
NEAR_STEPS = 12  # of a descent that only has to come near


def multi_start(at: Point, theta: Array) -> Point:
    """The likeliest of `at` and the solutions of restarts from other noise structures.

    `theta` (p,): where the search of `at` began.
    """
    # all pose errors correlated, where such errors were set to 0
    uncorrelated = bool((at.noise[COLOUR] <= _core.NO_COLOUR).any())
    if uncorrelated and not is_white(at):
        at = _likelier_from(at, theta, gauss_markov_for_white(at.runs.problem.recordings))
    # correlated pose errors and a disturbance force, no random walk
    if not is_white(at):
        at = _likelier_from(at, theta, disturbance_and_gauss_markov(at.runs.problem.recordings))
    # a longer memory of the pose errors
    if (other := with_longer_memory(at.noise)) is not None:
        at = _likelier_from(at, at.theta, other)
    # a disturbance force instead of the random walk of the same motion
    for walk, disturbance in WALKS_AND_DISTURBANCES:
        other = disturbance_for_walk(at.noise, walk, disturbance)
        if other is not None and _noise_alone_gains(at, other):
            at = _likelier_from(at, at.theta, other)
    # the other frame of the disturbance
    at = in_likelier_frame(at)
    problem = at.runs.problem
    if not _has_disturbance(at) and not is_white(at):
        noise = disturbance_and_gauss_markov(problem.recordings)
        at = _likelier_from(at, theta, noise, _other_frame(problem))
    # pose errors with a long memory, no process noise
    for times, memory in LONG_CORRELATIONS:
        if not is_white(at):
            at = _likelier_from(
                at, theta, gauss_markov_poses(at.runs.problem.recordings, times, memory)
            )
    # disturbance forces instead of all random walks
    if not is_white(at) and (other := disturbances_for_walks(at.noise)) is not None:
        at = _likelier_from(at, at.theta, other)
    # oscillating pose errors
    if not is_white(at):
        at = _with_waves(at, theta)
    return at


def in_likelier_frame(at: Point, least: Array = NOISE_LEAST) -> Point:
    """The likelier of `at` and the solution with the disturbance force in the other frame, earth or body.

    `least` (11,): lower bounds of the noise.
    """
    if not _has_disturbance(at):
        return at
    other = _other_frame(at.runs.problem)
    return _likelier_from(at, at.theta, at.noise, other, gain=FRAME_SWITCH_GAIN, least=least)


def _has_disturbance(at: Point) -> bool:
    """Whether there is a disturbance force, which has a frame."""
    return bool((at.noise[DISTURBANCES] > NEGLIGIBLE_NOISE * RAISED[DISTURBANCES]).any())


def _other_frame(problem: Problem) -> Problem:
    return replace(problem, earth_fixed=not problem.earth_fixed)


def _with_waves(at: Point, theta: Array) -> Point:
    """The likelier of `at` and the solution with oscillating pose errors.

    Wide windows average waves out of the start values. A short descent with briefly correlated errors comes
    near the boat; on its linearised trajectory the likeliest period and size of the waves start the search.
    """
    problem = at.runs.problem
    near = _near_solution(problem, theta)
    waves = list(_wave_noises(problem))
    if near is None or not waves:
        return at
    each = near.runs.by_recording
    costs = [
        (repeated_cost(each, problem.series, noise, problem.outlier), noise) for noise in waves
    ]
    found = _likelier_from(at, near.theta, min(costs, key=lambda c: c[0])[1])
    oscillates = found.noise[COLOUR_MEMORY] * found.noise[COLOUR_TURN] > 1.0  # else it only decays
    return found if oscillates else at


def _near_solution(problem: Problem, theta: Array) -> Point | None:
    """A point near the solution without process noise, all residuals being pose errors; None: there is none."""
    with suppress(IdentificationError):  # no recording is as long as such a window
        noise = gauss_markov_poses(problem.recordings, *BRIEF_CORRELATION)
        return descend_some_steps(problem, _start_without_waves(problem, theta), noise, NEAR_STEPS)
    return None


def _wave_noises(problem: Problem) -> Iterator[Array]:
    """Noise (11,) with oscillating pose errors, of all periods and sizes that are tried."""
    for period in _wave_periods(problem):
        for times in WAVE_SIZES:
            yield oscillating_poses(problem.recordings, times, float(period))


def _wave_periods(problem: Problem) -> Array:
    """Periods [s] of waves that the poses can show; none where poses are rare."""
    least = POSES_PER_WAVE * float(np.median([r.period for r in problem.recordings]))
    return np.asarray(TRIED_WAVE_PERIODS[least < TRIED_WAVE_PERIODS])


def _start_without_waves(problem: Problem, theta: Array) -> Array:
    """Start values (p,) by windows that average waves out."""
    n, m = problem.n_coefficients, problem.n_constants
    found = theta.copy()
    sought = [i - n for i in problem.free if n <= i < n + m]
    arms = (theta[problem.effects(i)][:2] for i in range(len(problem.recordings)))
    origins = [poses_of_origin(r, arm) for r, arm in zip(problem.recordings, arms, strict=True)]
    found[:n], found[n : n + m] = start_values(
        origins, problem.vehicle, sought, widths=WAVE_FREE_WIDTHS
    )
    held = [i for i in range(n + m) if i not in problem.free]
    found[held] = theta[held]
    return found


def with_longer_memory(noise: Array) -> Array | None:
    """The noise (11,) with a longer memory of the pose errors, where a first search stopped at its longest."""
    bound = NOISE_MOST[COLOUR_MEMORY]
    absent = (noise[COLOUR] <= _core.NO_COLOUR).all()
    if absent or not AT_LONGEST_MEMORY * bound < noise[COLOUR_MEMORY] <= bound:
        return None
    other = noise.copy()
    other[COLOUR_MEMORY] = MEMORY_EXTENSION * bound
    return np.asarray(other)


def disturbances_for_walks(noise: Array) -> Array | None:
    """The noise (11,) with disturbance forces for all random walks, and white pose errors; None: no walks."""
    walks = [walk for walk, _ in WALKS_AND_DISTURBANCES]
    if (noise[walks] < NEGLIGIBLE_NOISE * RAISED[walks]).all():
        return None
    other = noise.copy()
    other[MEMORY] = NOISE_START[MEMORY]
    for walk, disturbance in WALKS_AND_DISTURBANCES:
        equal = other[walk] / np.sqrt(2.0 * other[MEMORY])
        other[disturbance] = max(other[disturbance], equal, RAISED[disturbance])
        other[walk] = NOISE_LEAST[walk]
    other[COLOUR[0] :] = NOISE_START[COLOUR[0] :]
    return other


def disturbance_for_walk(noise: Array, walk: int, disturbance: int) -> Array | None:
    """The noise (11,) with a disturbance force for the random walk of the same motion; None where there is one.

    A force of size d and memory T is a walk of d sqrt(2 T) over times longer than T.
    """
    walk_per_force = np.sqrt(2.0 * noise[MEMORY])
    absent = noise[walk] < NEGLIGIBLE_NOISE * RAISED[walk]
    if absent or noise[disturbance] * walk_per_force > NEGLIGIBLE_NOISE * noise[walk]:
        return None
    other = noise.copy()
    other[disturbance] = noise[walk] / walk_per_force
    other[walk] = NOISE_LEAST[walk]
    return np.asarray(other)


def _noise_alone_gains(at: Point, noise: Array) -> bool:
    """Whether other noise is likelier by `NOISE_SWITCH_GAIN` with the same parameters."""
    runs = at.runs.by_recording
    _, cost = fitted_noise(runs, at.runs.problem.series, noise, NOISE_SWITCH_GAIN)
    return cost < sum(p.cost for p in runs) - NOISE_SWITCH_GAIN


def _likelier_from(
    at: Point,
    theta: Array,
    noise: Array,
    problem: Problem | None = None,
    *,
    gain: float = NOISE_SWITCH_GAIN,
    least: Array = NOISE_LEAST,
) -> Point:
    """The likelier of `at` and the solution from another start, or of another problem.

    gain: fall of -2 log likelihood that the other must reach.
    """
    try:
        other = descend_below(problem or at.runs.problem, theta, noise, at.runs.cost, least)
    except IdentificationError:
        return at
    return other if other.runs.cost < at.runs.cost - gain else at
