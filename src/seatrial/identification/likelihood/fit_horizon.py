# SPDX-License-Identifier: MIT
"""The fit horizon under model mismatch.

The likelihood weighs every pose by its own noise. Under model mismatch, coefficients then fit what happens
within a few poses, where noise is smallest, and predict worse one second ahead. So longer fit horizons are tried
as well: pose noise of at least horizon times the RMS speed, with which the innovations span about that time.
The RMS error one second ahead decides. Where the innovations are white, model and noise explain the poses, and
the maximum of the likelihood stays.
"""

from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import (
    DISTURBANCES,
    NOISE_LEAST,
    PROCESS,
    fitted_noise,
    likelier_noise,
    noise_entry,
)
from seatrial.boat.schema import EnvelopeEntry, Integration
from seatrial.evaluation.prediction import DEFAULT_HORIZON, predict
from seatrial.identification.diagnostics.scale_factors import thrust_and_drag
from seatrial.identification.likelihood.noise_structures import NOISE_SWITCH_GAIN, in_likelier_frame
from seatrial.identification.likelihood.optimiser import Point, maximise_likelihood
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.whiteness import (
    autocorrelation_ratio,
    is_white,
    without_process_noise,
)
from seatrial.recording.velocity import motion
from seatrial.util.errors import IdentificationError, ModelError, RecordingError
from seatrial.util.frames import AXES, Array
from seatrial.util.statistics import inverse_of

# [s] that are tried: pose noise of at least so many seconds at the RMS speed
FIT_HORIZONS = (0.2, 0.8)
# times the limit of whiteness: beyond it the innovations show a mismatch for certain
CLEAR_MISMATCH = 1.5
# of the log error one second ahead, that a horizon may cost under a certain mismatch
TOLERATED_LOSS = 0.01
# of the log error one second ahead, that it must gain else: any fit to it gains a little
REQUIRED_GAIN = 0.03
# times the squared noise floor: below it squared errors say nothing of the model
NOISE_DOMINATED = 2.0
POOR_RATIO = 0.9  # RMS error over that of a constant or zero velocity: from here on the model predicts nothing
# of the RMS error: with smaller process noise in a second, pose noise hides a good model
DISTURBANCE_SHARE = 0.3
# standard errors of a force's coefficient: beyond it poses and commands belong together
EVIDENT_THRUST = 15.0
ERROR_FLOOR = 1e-12  # [m/s, rad/s] against a division by 0 where nothing moves
# filter runs, and fall of -2 log likelihood that ends them
REFINED_NOISE_STEPS, REFINED_NOISE_GAIN = 3, 2.0


@dataclass(frozen=True)
class PredictionErrors:
    """RMS errors of the velocities one second ahead, over all recordings."""

    rms: Array  # (3,)
    floor: Array  # (3,) that pose noise alone makes
    constant: Array  # (3,) of a constant velocity
    zero: Array  # (3,) of a zero velocity: the velocity itself


def with_fit_horizon(at: Point, *, hold: bool = False) -> tuple[Array, Point, float]:
    """The noise (11,) at the likelihood's maximum, the solution that predicts best, and its fit horizon [s].

    A longer horizon has fewer local optima, too: where the likelihood is higher there, the maximum is sought
    again from there.
    """
    problem = at.runs.problem
    if hold or not _comparable(problem) or without_process_noise(at) or is_white(at):
        return at.noise, at, 0.0
    # a certain mismatch may cost a little one second ahead, a doubtful one must gain
    may_cost = TOLERATED_LOSS if autocorrelation_ratio(at) > CLEAR_MISMATCH else -REQUIRED_GAIN
    best = _prediction_errors(problem, at.theta, at.noise)
    if best is None or (best.rms**2 < NOISE_DOMINATED * best.floor**2).all():
        return at.noise, at, 0.0
    # longer and longer horizons, each from the one before
    chosen, horizon = at, 0.0
    for tried in FIT_HORIZONS:
        try:
            found = maximise_likelihood(
                problem, chosen.theta, chosen.noise, least=noise_floor(problem, tried)
            )
        except IdentificationError:
            continue
        likelier = _likelier_near(at, found)
        if likelier is not at:
            return with_fit_horizon(likelier)
        ahead = _prediction_errors(problem, found.theta, at.noise)
        if ahead is None:
            continue
        worse = float(np.mean(np.log(ahead.rms / best.rms)))
        if worse < may_cost:  # as good one second ahead: the longer horizon
            chosen, horizon, best = found, tried, ahead if worse < 0.0 else best
    if horizon:  # the other frame of the disturbance may be likelier with this noise
        chosen = in_likelier_frame(chosen, noise_floor(problem, horizon))
    return at.noise, chosen, horizon


def prediction_findings(at: Point, horizon: float = 0.0) -> list[Finding]:
    """A finding if the model predicts no better one second ahead than a constant or zero velocity.

    No note where pose noise hides how good the model is, unless it was fitted to a `horizon` [s].
    """
    if without_process_noise(at) or not _comparable(at.runs.problem):
        return []
    ahead = _prediction_errors(at.runs.problem, at.theta, at.noise)
    if ahead is None:
        return [finding_of(FindingKind.NOT_PREDICTABLE)]
    moves = ahead.zero**2 > NOISE_DOMINATED * ahead.floor**2
    least = np.where(moves, np.minimum(ahead.constant, ahead.zero), ahead.constant)
    ratio = ahead.rms / np.maximum(least, ERROR_FLOOR)
    process = np.hypot(at.noise[PROCESS][:2], at.noise[DISTURBANCES])[[0, 0, 1]]  # in a second
    known = (process < DISTURBANCE_SHARE * ahead.rms) & (horizon == 0.0)
    known |= ahead.rms**2 < NOISE_DOMINATED * ahead.floor**2
    known |= np.array([_thrust_is_evident(at, axis) for axis in range(3)])
    poor = [axis for axis, r, k in zip(AXES, ratio, known, strict=True) if r > POOR_RATIO and not k]
    if not poor:
        return []
    return [finding_of(FindingKind.NO_BETTER_THAN_CONSTANT, *poor)]


def _thrust_is_evident(at: Point, axis: int) -> bool:
    """Whether a force coefficient of an axis is so significant that poses and commands belong together."""
    problem = at.runs.problem
    thrust, _ = thrust_and_drag(problem.vehicle.structure, axis)
    free = np.array(problem.free)
    errors = np.sqrt(np.diag(inverse_of(at.runs.information)))
    own = np.array([problem.names[i] in thrust for i in free])
    return bool((np.abs(at.theta[free]) > EVIDENT_THRUST * errors)[own].any())


def _likelier_near(at: Point, found: Point) -> Point:
    """A likelier solution than `at`, sought from `found`; `at` where there is none."""
    problem = at.runs.problem
    likelier = []
    for process in (at.noise, found.noise):
        noise = np.concatenate([at.noise[:2], process[2:]])
        there = Point(found.theta, noise, problem.run_filter(found.theta, noise))
        if np.isfinite(there.runs.cost):
            better, gain = likelier_noise(
                there.runs.by_recording, problem.series, noise, problem.outlier
            )
            likelier.append((there.runs.cost - gain, better))
    cost, noise = min(likelier, key=lambda found: found[0], default=(np.inf, at.noise))
    if cost > at.runs.cost - NOISE_SWITCH_GAIN:
        return at
    try:
        other = maximise_likelihood(problem, found.theta, noise)
    except IdentificationError:
        return at
    return other if other.runs.cost < at.runs.cost - NOISE_SWITCH_GAIN else at


def noise_floor(problem: Problem, horizon: float) -> Array:
    """Lower bounds (11,) of the noise for a fit horizon [s]: so many seconds at the RMS speed."""
    least = NOISE_LEAST.copy()
    if horizon > 0.0:
        nu = np.concatenate([m.nu[m.valid] for m in map(motion, problem.recordings)])
        rms = np.sqrt(np.mean(nu**2, axis=0))
        distance = horizon * np.array([np.hypot(rms[0], rms[1]), rms[2]])
        least[:2] = np.maximum(least[:2], distance)
    return least


def likelihood_noise(at: Point, noise: Array) -> Array:
    """The noise (11,) of highest likelihood with these parameters, for the filter on board.

    `noise`: that at the likelihood's maximum, before a fit horizon was chosen.
    """
    problem = at.runs.problem
    held = replace(problem, free=problem.free_effects)  # the filter needs the effects
    for _ in range(REFINED_NOISE_STEPS):
        runs = held.run_filter(at.theta, noise)
        if not np.isfinite(runs.cost):  # a model that diverges is refused later
            break
        noise, cost = fitted_noise(runs.by_recording, held.series, noise, 1.0)
        if runs.cost - cost < REFINED_NOISE_GAIN:
            break
    return noise


def _prediction_errors(problem: Problem, theta: Array, noise: Array) -> PredictionErrors | None:
    """Errors of the model with these parameters and this noise (11,); None where it diverges."""
    n, m = problem.n_coefficients, problem.n_constants
    model = Model(
        problem.vehicle, theta[:n], np.zeros((n, n)), theta[n : n + m],
        Integration("runge-kutta", problem.step), noise_entry(noise), EnvelopeEntry({}, {}),
    )  # fmt: skip
    squares, floors, constant, zero = np.zeros((4, 3))
    count = 0
    for i in range(len(problem.recordings)):
        try:
            found = predict(model, problem.origin_poses(i, theta), DEFAULT_HORIZON)
        except RecordingError:  # too short for that
            continue
        except ModelError:
            return None
        squares += np.sum(found.errors**2, axis=0)
        floors += len(found.t) * found.floor**2
        constant += np.sum((found.measured - found.start) ** 2, axis=0)
        zero += np.sum(found.measured**2, axis=0)
        count += len(found.t)
    if count == 0:
        return None
    rms, floor, constant, zero = (np.sqrt(x / count) for x in (squares, floors, constant, zero))
    return PredictionErrors(rms + ERROR_FLOOR, floor, constant, zero)


def _comparable(problem: Problem) -> bool:
    """Whether a prediction has all estimated effects: it has no trim and no wind."""
    missing = ("trim", "wind")
    return not any(problem.names[i].startswith(missing) for i in problem.free_effects)
