# SPDX-License-Identifier: MIT
"""The fit horizon under model mismatch.

The likelihood weighs every pose by its own noise. Under model mismatch, coefficients then fit what happens
within a few poses, where noise is smallest, and predict worse one second ahead. So longer fit horizons are tried
as well: pose noise of at least horizon times the RMS speed, with which the innovations span about that time.
Cross-validation by blocks of the error one second ahead decides. Where the innovations are white, model and noise
explain the poses, and the maximum of the likelihood stays.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from seatrial.boat.noise_parameters import (
    noise_entry,
)
from seatrial.boat.noise_scoring import fitted_noise
from seatrial.evaluation.prediction import DEFAULT_HORIZON, Lookahead
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import Point, boxed_step
from seatrial.identification.likelihood.noise_structures import (
    in_likelier_frame,
    refined,
    screened,
    searched,
)
from seatrial.identification.likelihood.optimiser import Outcome, continued, search
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.whiteness import (
    is_white,
    without_process_noise,
)
from seatrial.recording.velocity import usual_velocities
from seatrial.util.errors import ModelError, RecordingError
from seatrial.util.frames import Array
from seatrial.util.parallel import spread

# [s] under model mismatch: pose noise of so many seconds at the RMS speed
FIT_HORIZONS = (0.8, 1.6)
LONGER_BETTER = 2.5  # [standard errors] by which a longer one must predict better
FOLDS = 4  # of the cross-validation
ERROR_FLOOR = 1e-12  # [m/s, rad/s] against a division by 0 where nothing moves


def with_noise_or_horizon(at: Point) -> tuple[Point, Point, float]:
    """The likelihood's maximum over noise structures, the solution that predicts best, and its fit horizon [s].

    Where a noise structure makes the innovations white, model and noise explain the poses. Where none does, the
    model is at fault, and longer fit horizons are tried; only if none predicts better, the likeliest counts.
    `at` need not have converged. Raises IdentificationError where the likelihood's search does not.
    """
    if not is_white(at):
        structures = screened(at, poses_only=False)
        at = searched(at, [s for s in structures if s.explains(at)])
    if is_white(at):
        at = refined(continued(at))
        return at, at, 0.0
    # with large pose noise the filter simulates: pose errors alone are screened about that
    fits = _fits(at)
    if fits:
        _, simulating = fits[-1]
        simulated = screened(simulating, poses_only=True)
        by_poses = searched(at, [s for s in simulated if s.explains(at)])
        if by_poses is at and (best := _best_predicting(at, fits)) is not None:
            horizon, fitted = best
            # the other frame of the disturbance may be likelier with this noise
            return at, in_likelier_frame(fitted, noise_floor(at.runs.problem, horizon)), horizon
        at, structures = by_poses, sorted(structures + simulated, key=lambda s: s.cost)
    at = searched(at, structures)
    at = refined(continued(at))
    return at, at, 0.0


def _fits(at: Point) -> list[tuple[float, Point]]:
    """Fit horizons [s] and the solutions with them, each from the one before; without those that fail."""
    found: list[tuple[float, Point]] = []
    for horizon in FIT_HORIZONS:
        least = noise_floor(at.runs.problem, horizon)
        fitted, outcome = search(at.runs.problem, at.theta, at.noise, least=least)
        if outcome is Outcome.CONVERGED:
            found.append((horizon, fitted))
            at = fitted
    return found


def _best_predicting(at: Point, fits: Sequence[tuple[float, Point]]) -> tuple[float, Point] | None:
    """The fit horizon and solution with the smallest errors one second ahead in cross-validation.

    As the model is at fault, the first must only be better; a longer one must be by `LONGER_BETTER`. None where
    none is better than `at`.
    """
    if not comparable(at.runs.problem) or without_process_noise(at):
        return None
    chosen, least = None, held_out_errors(at)
    if least is None:
        return None
    for horizon, fitted in fits:
        errors = held_out_errors(fitted)
        if errors is None:
            continue
        worse, error = _worse(errors, least)
        if worse < (0.0 if chosen is None else -LONGER_BETTER * error):
            chosen, least = (horizon, fitted), errors
    return chosen


def _worse(ahead: Array, best: Array) -> tuple[float, float]:
    """Mean difference in log errors of blocks (b, 3), and its standard error."""
    apart = 0.5 * np.mean(np.log(ahead / best), axis=1)
    return float(apart.mean()), float(apart.std() / np.sqrt(len(apart)))


def held_out_errors(at: Point) -> Array | None:
    """Mean squared errors (blocks, 3) one second ahead, each fold by the parameters of the others.

    The parameters without a fold are a Gauss-Newton step away: its scores are left out. None where a model
    diverges, or nothing can be predicted.
    """
    problem, scores = at.runs.problem, at.runs.scores
    fold = np.arange(len(scores)) * FOLDS // len(scores)
    information = at.runs.information * (FOLDS - 1) / FOLDS
    ends = np.cumsum([int(b[-1]) + 1 for b in problem.blocks])

    def left_out(k: int) -> list[Array]:
        """Mean squared errors of a fold's blocks."""
        found = []
        theta = at.theta + boxed_step(at, scores[fold != k].sum(axis=0), information)
        model = problem.model(theta, noise_entry(at.noise))
        for i, (recording, block) in enumerate(
            zip(problem.recordings, problem.blocks, strict=True)
        ):
            own = fold[ends[i] - int(block[-1]) - 1 : ends[i]] == k
            poses = own[block]
            if poses.sum() < 2:
                continue
            times = recording.t[poses]
            part = problem.origin_poses(i, theta, (times[0], times[-1]))
            with suppress(RecordingError):  # too short
                found += _by_block(*Lookahead(model, part).errors(DEFAULT_HORIZON), problem.block)
        return found

    try:
        of_folds = spread(left_out, range(FOLDS))
    except ModelError:
        return None
    errors = np.array([block for fold in of_folds for block in fold]).reshape(-1, 3)
    return errors if len(errors) > 1 and np.isfinite(errors).all() else None


def _by_block(t: Array, errors: Array, block: float) -> list[Array]:
    """Mean squared errors (3,) of each block of time, from times (m,) [s] and errors (m, 3)."""
    numbers = (t // block).astype(int)
    return [np.mean(errors[numbers == n] ** 2, axis=0) + ERROR_FLOOR**2 for n in np.unique(numbers)]


def noise_floor(problem: Problem, horizon: float) -> Array:
    """Lower bounds (12,) of the noise for a fit horizon [s]: so many seconds at the RMS speed, of all poses."""
    least = problem.least_noise.copy()
    if horizon > 0.0:
        rms = np.sqrt(np.mean(usual_velocities(problem.recordings) ** 2, axis=0))
        distance = horizon * np.array([np.hypot(rms[0], rms[1]), rms[2]])
        # a second with fewer poses keeps its weight
        distance *= np.sqrt((problem.whole_period or problem.period) / problem.period)
        least[:2] = np.maximum(least[:2], distance)
    return least


def likelihood_noise(at: Point, noise: Array) -> Array:
    """The noise (12,) of highest likelihood with these parameters, for the filter on board.

    `noise`: that at the likelihood's maximum, before a fit horizon was chosen.
    """
    problem = at.runs.problem
    held = replace(problem, free=problem.free_effects)  # the filter needs the effects
    least_gain = 2.0  # of -2 log L
    for _ in range(3):  # filter runs
        runs = filter_along(held, at.theta, noise)
        if not np.isfinite(runs.cost):  # a model that diverges is refused later
            break
        noise, cost = fitted_noise(runs.linearised(), noise, 0.5 * least_gain)
        if runs.cost - cost < least_gain:
            break
    return noise


def comparable(problem: Problem) -> bool:
    """Whether a prediction has all estimated effects: it has no trim and no wind."""
    missing = ("trim", "wind")
    return not any(problem.names[i].startswith(missing) for i in problem.free_effects)
