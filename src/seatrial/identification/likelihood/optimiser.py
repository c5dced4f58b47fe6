# SPDX-License-Identifier: MIT
"""Maximisation of the likelihood over parameters and noise.

Levenberg-Marquardt steps on the parameters, Fisher scoring on the log-noise. Both come from one
filter run, as the information between parameters and noise is 0 for normal innovations; other noise
is evaluated on the run's linearised trajectory, without integration.
"""

from contextlib import suppress
from dataclasses import dataclass, field

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
    oscillates,
    repeated_cost,
)
from seatrial.identification.likelihood.problem import FilterRuns, Problem
from seatrial.identification.likelihood.start_noise import gauss_markov_for_white
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

# All gains and costs are falls of -2 log likelihood.
# that a step still promises at convergence: 0.1 standard errors, all parameters together
CONVERGED_GAIN = 0.01
CONVERGED_NOISE_GAIN = 0.3  # that other noise still promises there
COARSE_GAIN = 100.0  # CONVERGED_GAIN of a descent that only has to come near
STUCK_GAIN = 1000.0  # promised, and yet no trial step falls: there is no solution
# by other noise: from here on noise takes a double step, far from the end
NOISE_EXTRAPOLATION_GAIN = 10.0
CORRELATION_GAIN = 10.0  # that correlated pose errors must reach, else they are left out
FAR_COST_PER_POSE = 100.0  # -2 log likelihood a pose: a model so far off has useless sensitivities
START_DAMPING, LEAST_RETRY_DAMPING = 1e-4, 1e-3  # Levenberg-Marquardt, relative to the diagonal
DAMPING_FACTOR = 10.0  # of the damping: up after a failed trial, down after a good one
LEAST_DAMPING = 1e-12  # keeps the step unique where two terms are the same
INFORMATION_FLOOR = 1e-12  # on the diagonal, for parameters without any information
DAMPING_TRIALS = 6  # of one step; the last changes the noise only
MOST_ITERATIONS = 40
FLAT_STEPS = 2  # in a row that gain less than NOISE_SETTLED: converged
# after so many steps, so many falls like the last two must beat the rival
RACE_STEPS, RACE_FALLS = 5, 10.0
NEGLIGIBLE_NOISE = 0.01  # share of a usual noise level (RAISED) below which it is as good as absent
AT_LONGEST = 0.99  # of the longest memory: there it counts as reached
# in a row with pose errors at their longest memory: the filter takes motion for pose errors
DRIFT_STEPS = 8
# times the first process noise, to begin where the model is far off
PROCESS_NOISE_FACTORS = (10.0, 1.0)
ALIGNED_COSINE = 0.9  # between two moves of log-noise in a row: the same direction
# after so many aligned moves a move so many times as long is tried
CREEP_STEPS, CREEP_LEAP = 3, 5.0
BOX_STEPS_PER_PARAMETER = 4  # of the active-set solver, at most


@dataclass(frozen=True)
class Point:
    """Parameters, noise, and the filter run with them."""

    theta: Array  # (p,) all parameters
    noise: Array  # (11,)
    runs: FilterRuns


def maximise_likelihood(
    problem: Problem,
    theta: Array,
    noise: Array,
    *,
    hold: bool = False,
    least: Array = NOISE_LEAST,
) -> Point:
    """The maximum-likelihood parameters and, unless `hold`, noise levels not below `least` (11,).

    Correlated pose errors stay only where they gain `CORRELATION_GAIN`. Where they drift to the longest
    memory, the descent restarts with all pose errors correlated, then with none.
    Raises IdentificationError where the model diverges, or where the descent does not converge.
    """
    # start inside the bounds; with much process noise where the model is far from the poses
    begin = _started_within_bounds(_point(problem, theta, np.clip(noise, least, most_noise(noise))))
    if far_from_poses(begin):
        begin = _with_more_process_noise(begin, hold, least)
    if hold:
        return _descent(begin, hold, least)
    try:
        at = _descent(begin, hold, least)
    except IdentificationError:
        if not has_correlated_poses(begin.noise):
            raise
        at = _restarted_after_drift(begin, theta, least)
    return _without_needless_correlation(at, least)


def _restarted_after_drift(begin: Point, theta: Array, least: Array) -> Point:
    """The solution after correlated pose errors drifted: first from all errors correlated, then from
    none, then from the same start without a limit on the drift."""
    problem = begin.runs.problem
    correlated = np.clip(gauss_markov_for_white(problem.recordings), least, None)
    white = begin.noise.copy()
    white[COLOUR] = least[COLOUR]
    for noise in (correlated, white):
        with suppress(IdentificationError):
            return _descent(_point(problem, theta, noise), False, least)
    return _descent(_with_linearisation(begin), False, least, drifts=np.inf)


def _started_within_bounds(at: Point) -> Point:
    """The same point, or if it is outside the bounds, the likelier of two inside: a Gauss-Newton step into
    them, which moves the other parameters along, or the nearest point."""
    problem = at.runs.problem
    nearest = problem.clipped(at.theta)
    if (nearest == at.theta).all():
        return at
    if not np.isfinite(at.runs.cost):  # its gradient is useless
        return _point(problem, nearest, at.noise)
    stepped = problem.clipped(at.theta + bounded_step(at, 0.0)[0])
    tried = (_point(problem, theta, at.noise) for theta in (stepped, nearest))
    return min(tried, key=lambda p: p.runs.cost if np.isfinite(p.runs.cost) else np.inf)


def far_from_poses(at: Point) -> bool:
    """Whether the model misses the poses by far, or diverges."""
    poses = sum(len(r.t) for r in at.runs.problem.recordings)
    return not at.runs.cost < FAR_COST_PER_POSE * poses


def _point(problem: Problem, theta: Array, noise: Array) -> Point:
    return Point(theta, noise, problem.run_filter(theta, noise))


def _with_more_process_noise(at: Point, hold: bool, least: Array) -> Point:
    """The same with more process noise, which the descent reduces again; where the noise is held, the
    parameters found with less and less of it."""
    problem, theta = at.runs.problem, at.theta
    for times in PROCESS_NOISE_FACTORS:
        loose = _point(problem, theta, loosened(at.noise, times))
        if not hold:
            return loose
        theta = _descent(loose, hold, least, COARSE_GAIN).theta
    return _point(problem, theta, at.noise)


def descend_below(
    problem: Problem,
    theta: Array,
    noise: Array,
    beat: float = np.inf,
    least: Array = NOISE_LEAST,
) -> Point:
    """`maximise_likelihood` without a restart where correlated pose errors drift: long ones may stay long.

    Raises IdentificationError as soon as it falls too slowly to get below the cost to `beat`."""
    begin, most = _point(problem, theta, noise), most_noise(noise)
    at = _descent(begin, False, least, most=most, beat=beat, drifts=np.inf)
    return _without_needless_correlation(at, least)


def descend_some_steps(problem: Problem, theta: Array, noise: Array, steps: int) -> Point:
    """The point after so many steps, or at convergence if that is earlier."""
    return _descent(_point(problem, theta, noise), False, NOISE_LEAST, steps=steps)


def _without_needless_correlation(at: Point, least: Array) -> Point:
    """Without correlated pose errors that gain too little; unchanged where there is no solution without them."""
    while (whiter := _whiter_noise(at, least)) is not None:
        try:
            at = _descent(_point(at.runs.problem, at.theta, whiter), False, least)
        except IdentificationError:
            break
    return at


def has_correlated_poses(noise: Array) -> bool:
    """Whether the noise has correlated pose errors."""
    return bool((noise[COLOUR] > _core.NO_COLOUR).any())


def _pose_noise_drifts(noise: Array, most: Array) -> bool:
    """Whether correlated pose errors are at their longest memory, large, and beside process noise."""
    longest = noise[COLOUR_MEMORY] > AT_LONGEST * most[COLOUR_MEMORY]
    larger = (noise[COLOUR] > noise[:2]).any()
    disturbed = (noise[PROCESS] > NEGLIGIBLE_NOISE * RAISED[PROCESS]).any()
    return bool(longest and larger and disturbed and not oscillates(noise))


def _whiter_noise(at: Point, least: Array) -> Array | None:
    """The noise (11,) without correlated pose errors that gain too little; None where all gain enough.

    They are set to 0, or added to the white errors, which they equal if they fade within one pose period.
    """
    problem, runs = at.runs.problem, at.runs.by_recording
    here = sum(p.cost for p in runs)
    for white, i in enumerate(COLOUR):
        if at.noise[i] <= _core.NO_COLOUR:
            continue
        for size in (at.noise[white], np.hypot(at.noise[white], at.noise[i])):
            without = at.noise.copy()
            without[i], without[white] = least[i], size
            cost = repeated_cost(runs, problem.series, without, problem.outlier)
            if cost < here + CORRELATION_GAIN:
                return without
    return None


def _descent(
    at: Point,
    hold: bool,
    least: Array,
    settled: float = CONVERGED_GAIN,
    *,
    most: Array | None = None,
    beat: float = np.inf,
    steps: int = MOST_ITERATIONS,
    drifts: float = DRIFT_STEPS,
) -> Point:
    """Downhill from a point, until the next step promises less than `settled`.

    steps: at most; fewer than `MOST_ITERATIONS` need not converge. drifts: steps in a row with pose errors at
    their longest memory, after which it gives up. beat: cost of a rival solution."""
    if not np.isfinite(at.runs.cost):
        raise IdentificationError(
            "the boat diverges from the start values; look at the recordings with inspect"
        )
    noise_steps = _NoiseSteps(hold, least, most_noise(at.noise) if most is None else most, drifts)
    parameter_steps = _ParameterSteps(settled)
    costs: list[float] = []
    for _ in range(steps):
        # give up a race against a rival that the recent falls can not win
        costs.append(at.runs.cost)
        if len(costs) > RACE_STEPS and costs[-1] - beat > RACE_FALLS * (costs[-3] - costs[-1]):
            raise IdentificationError("a rival solution is likelier")
        # Fisher scoring on the log-noise, the parameters held
        noise, gain = noise_steps.take(at)
        # Levenberg-Marquardt on the parameters, with that noise
        lower = parameter_steps.take(at, noise, noise_steps.extrapolated(at, noise, gain), gain)
        if lower is None:
            return _with_linearisation(at)
        at = lower
    if steps < MOST_ITERATIONS:
        return _with_linearisation(at)
    raise IdentificationError(
        f"no solution after {MOST_ITERATIONS} steps; do poses and commands belong together, by one "
        "clock? If so, drive more, or state known constants of the thrusters in the vehicle file (chain)"
    )


@dataclass
class _NoiseSteps:
    """Steps of the log-noise along a descent, which watch for drift and for creeping."""

    hold: bool  # the noise stays as it is
    least: Array  # (11,)
    most: Array  # (11,)
    drifts: float  # steps in a row with drifting pose errors that are too many
    # last one, of log-noise
    move: Array = field(default_factory=lambda: np.zeros(len(NOISE_LEAST)))
    aligned: int = 0  # moves in a row in the same direction
    drifting: int = 0  # steps in a row with drifting pose errors

    def take(self, at: Point) -> tuple[Array, float]:
        """Likelier noise (11,), and the fall of the cost. Raises IdentificationError where pose errors drift."""
        noise, gain = at.noise, 0.0
        if not self.hold:
            noise, gain = likelier_noise(
                at.runs.by_recording, at.runs.problem.series, at.noise, at.runs.problem.outlier,
                least=self.least, most=self.most,
            )  # fmt: skip
        before, self.move = self.move, np.log(noise / at.noise)
        lengths = np.linalg.norm(self.move) * np.linalg.norm(before)
        self.aligned = self.aligned + 1 if self.move @ before > ALIGNED_COSINE * lengths else 0
        self.drifting = self.drifting + 1 if _pose_noise_drifts(noise, self.most) else 0
        if self.drifting == self.drifts:
            raise IdentificationError("pose errors that drift are not separable from motion")
        return noise, gain

    def extrapolated(self, at: Point, noise: Array, gain: float) -> Array:
        """The noise (11,) further along its move, where it creeps or is far from its end."""
        if self.aligned >= CREEP_STEPS:
            return np.clip(noise * np.exp(CREEP_LEAP * self.move), self.least, self.most)
        return _extrapolated_noise(at.noise, noise) if gain > NOISE_EXTRAPOLATION_GAIN else noise


@dataclass
class _ParameterSteps:
    """Damped Gauss-Newton steps of the parameters along a descent."""

    settled: float  # gain that a step promises at convergence
    damping: float = START_DAMPING
    flat: int = 0  # steps in a row that gained next to nothing

    def take(self, at: Point, noise: Array, extrapolated: Array, gain: float) -> Point | None:
        """A point that is likelier; None at convergence.

        gain: fall of the cost by `noise` alone. The first trial takes the extrapolated noise, the last one no step
        of the parameters. Raises IdentificationError where much is promised, and no trial falls.
        """
        promised_first = 0.0
        for trial in range(DAMPING_TRIALS):
            # converged where neither parameters nor noise promise any more
            move, promised = bounded_step(at, self.damping)
            promised_first = max(gain, promised) if trial == 0 else promised_first
            if (promised < self.settled and gain < CONVERGED_NOISE_GAIN) or self.flat == FLAT_STEPS:
                return None
            # one full filter run; two sets of a long recording's poses need not be in memory
            at.runs.drop_poses()
            there = at.theta if trial == DAMPING_TRIALS - 1 else at.theta + move
            tried = extrapolated if trial == 0 else noise
            found = at.runs.problem.run_filter(there, tried)
            if found.cost < at.runs.cost:
                self.flat = self.flat + 1 if at.runs.cost - found.cost < NOISE_SETTLED else 0
                self.damping /= DAMPING_FACTOR
                return Point(there, tried, found)
            # uphill: a shorter step
            found.drop_poses()
            self.damping = max(DAMPING_FACTOR * self.damping, LEAST_RETRY_DAMPING)
        if promised_first > STUCK_GAIN:
            raise IdentificationError(
                "no solution: no step improves the likelihood, far from its maximum; do poses and commands "
                "belong together, by one clock? If so, state known constants of the thrusters in the "
                "vehicle file (chain)"
            )
        return None


def _with_linearisation(at: Point) -> Point:
    """The same with its linearised trajectory, which other noise is evaluated on."""
    if at.runs.repeatable:
        return at
    return Point(at.theta, at.noise, at.runs.problem.run_filter(at.theta, at.noise))


def _extrapolated_noise(before: Array, after: Array) -> Array:
    """The noise (11,) after a double step of falling process noise: better parameters leave less to it."""
    further = after * np.clip(after / before, np.exp(-NOISE_STEP), 1.0)
    out = after.copy()
    out[PROCESS] = np.maximum(further, NOISE_LEAST)[PROCESS]
    return out


def bounded_step(at: Point, damping: float) -> tuple[Array, float]:
    """A Gauss-Newton step (names,) within bounds and step limits, and the fall of the cost that it promises."""
    problem = at.runs.problem
    free = np.array(problem.free)
    low, high = (bound - at.theta[free] for bound in problem.bounds)
    gradient, information = at.runs.gradient, at.runs.information
    diagonal = np.diag(information) + INFORMATION_FLOOR
    scale = 1.0 / np.sqrt(diagonal)
    step = scale * box_minimum(
        (information + max(damping, LEAST_DAMPING) * np.diag(diagonal)) * np.outer(scale, scale),
        scale * gradient,
        np.maximum(low, -problem.step_limits) / scale,
        np.minimum(high, problem.step_limits) / scale,
    )
    move = np.zeros(len(at.theta))
    move[free] = step
    return move, float(2.0 * step @ gradient - step @ information @ step)


def box_minimum(matrix: Array, linear: Array, low: Array, high: Array) -> Array:
    """The minimum (p,) of x' M x / 2 - b' x in a box around 0.

    matrix: M (p, p), positive definite; linear: b (p,); low, high: (p,). Active sets: Nocedal and Wright,
    Numerical Optimization, 2nd ed., algorithm 16.3.
    """
    x = np.clip(np.zeros(len(linear)), low, high)
    held = np.zeros(len(linear), dtype=bool)
    for _ in range(BOX_STEPS_PER_PARAMETER * len(linear)):
        # minimum over the variables that are not held at a bound
        go = np.flatnonzero(~held)
        to = x.copy()
        rest = linear[go] - matrix[np.ix_(go, held)] @ x[held]
        to[go] = np.linalg.solve(matrix[np.ix_(go, go)], rest)
        # outside the box: only as far as the first bound, which then holds its variable
        edge = np.clip(to, low, high)
        beyond = go[edge[go] != to[go]]
        if len(beyond):
            shares = (edge - x)[beyond] / (to - x)[beyond]
            first = beyond[int(np.argmin(shares))]
            x += float(shares.min()) * (to - x)
            x[first], held[first] = edge[first], True
            continue
        # inside: release the held variable with the steepest way down into the box
        x = to
        slope = linear - matrix @ x
        back = held & (low < high) & np.where(x <= low, slope > 0.0, slope < 0.0)
        if not back.any():
            break
        held[int(np.argmax(np.where(back, np.abs(slope), 0.0)))] = False
    return x
