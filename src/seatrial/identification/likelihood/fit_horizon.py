# SPDX-License-Identifier: MIT
"""How closely the model is believed.

The likelihood weighs every pose by its own noise. A structure that is not quite right then spends
its coefficients on what happens within a few poses, where noise is smallest, and predicts a second
ahead the worse for it. So models that are believed less closely are tried as well: the filter takes
the poses for noisier than they are, by a share of the way that the boat goes in one second, and the
fit looks as much further ahead. They are compared by what they are for: the error one second
ahead. Where the filter's errors follow no pattern, structure and noise explain them, and the
likelihood's choice stays.
"""

from dataclasses import dataclass, replace

import numpy as np

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
from seatrial.identification.regression.start_lever import poses_of_origin
from seatrial.recording.velocity import motion
from seatrial.util.errors import IdentificationError, ModelError, RecordingError
from seatrial.util.frames import AXES, Array
from seatrial.util.statistics import inverse_of

FIT_HORIZONS = (0.2, 0.8)  # of the way gone in one second
TOLERATED_LOSS = 0.01  # share of the error one second ahead that a looser belief may cost
CLEAR_MISMATCH = 1.5  # times the limit from which on a pattern is no chance
REQUIRED_GAIN = (
    0.03  # share of that error that a looser belief must gain there: fits to it gain some
)
DISTURBANCE_SHARE = (
    0.3  # of the error: what the velocity is pushed about by in the meantime is no more
)
POOR_RATIO = 0.9  # error over that of a velocity that stays, from which on a model says nothing
EVIDENT_THRUST = (
    15.0  # standard errors of a force's coefficient from which on commands move the boat
)
NOISE_DOMINATED = (
    2.0  # errors of less than so many times their floor, squared, say nothing of the model
)


@dataclass(frozen=True)
class PredictionErrors:
    """Errors one second ahead, over all recordings."""

    rms: Array  # (3,)
    floor: Array  # (3,) what pose noise alone makes
    still: Array  # (3,) of a velocity that stays as it is
    moving: Array  # (3,) of a boat at rest: the velocity itself


def with_fit_horizon(at: Point, *, hold: bool = False) -> tuple[Array, Point, float]:
    """The likelihood's noise (11,), the solution that predicts best, and the share it was believed to.

    A looser belief has fewer local optima, too: where the likelihood is higher there, it is followed
    from there.
    """
    problem = at.runs.problem
    if hold or not _comparable(problem) or without_process_noise(at) or is_white(at):
        return at.noise, at, 0.0
    may_cost = TOLERATED_LOSS if autocorrelation_ratio(at) > CLEAR_MISMATCH else -REQUIRED_GAIN
    best = _prediction_errors(problem, at.theta, at.noise)
    if best is None or (best.rms**2 < NOISE_DOMINATED * best.floor**2).all():
        return at.noise, at, 0.0
    chosen, share = at, 0.0
    for tried in FIT_HORIZONS:
        try:
            found = maximise_likelihood(
                problem, chosen.theta, chosen.noise, least=noise_floor(problem, tried)
            )
        except IdentificationError:
            continue
        closer = _likelier_near(at, found)
        if closer is not at:
            return with_fit_horizon(closer)
        ahead = _prediction_errors(problem, found.theta, at.noise)
        if ahead is None:
            continue
        worse = float(np.mean(np.log(ahead.rms / best.rms)))
        if worse < may_cost:  # as good a second ahead: then what was fitted a second ahead
            chosen, share, best = found, tried, ahead if worse < 0.0 else best
    if share:  # what is more likely so may come from another side
        chosen = in_likelier_frame(chosen, noise_floor(problem, share))
    return at.noise, chosen, share


def prediction_notes(at: Point, share: float = 0.0) -> list[str]:
    """What is to be said where the model is no better one second ahead than no model.

    Not where errors of the poses hide how good it is: it is believed to know the velocity better than
    that, and rightly, unless it was believed to a `share` only.
    """
    if without_process_noise(at) or not _comparable(at.runs.problem):
        return []
    ahead = _prediction_errors(at.runs.problem, at.theta, at.noise)
    if ahead is None:
        return [
            "no second of these recordings can be predicted: the model runs away from the velocities "
            "that occur, or there are no poses in a row; look at them with inspect"
        ]
    moves = ahead.moving**2 > NOISE_DOMINATED * ahead.floor**2
    least = np.where(moves, np.minimum(ahead.still, ahead.moving), ahead.still)
    ratio = ahead.rms / np.maximum(least, 1e-12)
    pushed = np.hypot(at.noise[PROCESS][:2], at.noise[DISTURBANCES])[[0, 0, 1]]  # in a second
    known = (pushed < DISTURBANCE_SHARE * ahead.rms) & (share == 0.0)
    known |= ahead.rms**2 < NOISE_DOMINATED * ahead.floor**2
    known |= np.array([_thrust_is_evident(at, axis) for axis in range(3)])
    poor = [axis for axis, r, k in zip(AXES, ratio, known, strict=True) if r > POOR_RATIO and not k]
    if not poor:
        return []
    return [
        f"in {' and '.join(poor)}, one second ahead hardly better than constant or zero velocity: do commands "
        "and poses belong together? Check with inspect, and the vehicle file's signs"
    ]


def _thrust_is_evident(at: Point, axis: int) -> bool:
    """Whether thrust of an axis is so clearly seen that poses and commands do belong together."""
    problem = at.runs.problem
    thrust, _ = thrust_and_drag(problem.vehicle.structure, axis)
    free = np.array(problem.free)
    errors = np.sqrt(np.diag(inverse_of(at.runs.information)))
    own = np.array([problem.names[i] in thrust for i in free])
    return bool((np.abs(at.theta[free]) > EVIDENT_THRUST * errors)[own].any())


def _likelier_near(at: Point, found: Point) -> Point:
    """A more likely solution than `at`, followed from `found`; `at` where there is none."""
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


def noise_floor(problem: Problem, share: float) -> Array:
    """The noise (11,) below which the filter does not go."""
    least = NOISE_LEAST.copy()
    if share > 0.0:
        nu = np.concatenate([m.nu[m.valid] for m in map(motion, problem.recordings)])
        rms = np.sqrt(np.mean(nu**2, axis=0))
        way = share * np.array([np.hypot(rms[0], rms[1]), rms[2]])
        least[:2] = np.maximum(least[:2], way)
    return least


def likelihood_noise(at: Point, noise: Array) -> Array:
    """The likeliest noise (11,) with the parameters as they are: what a filter is to believe.

    `noise`: what the likelihood found before the model was believed less closely.
    """
    problem = at.runs.problem
    held = replace(problem, free=problem.free_effects)  # the filter is to know of them
    for _ in range(3):
        runs = held.run_filter(at.theta, noise)
        if not np.isfinite(runs.cost):  # a model that runs away is refused later, in words
            break
        noise, cost = fitted_noise(runs.by_recording, held.series, noise, 1.0)
        if runs.cost - cost < 2.0:
            break
    return noise


def _prediction_errors(problem: Problem, theta: Array, noise: Array) -> PredictionErrors | None:
    """Errors of the model with these parameters, the noise being (11,); None where it runs away."""
    n, m = problem.n_coefficients, problem.n_constants
    model = Model(
        problem.vehicle, theta[:n], np.zeros((n, n)), theta[n : n + m],
        Integration("runge-kutta", problem.step), noise_entry(noise), EnvelopeEntry({}, {}),
    )  # fmt: skip
    squares, floors, stays, moves, count = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), 0
    for i, recording in enumerate(problem.recordings):
        lever, current = np.split(theta[problem.effects(i)][:4], 2)
        try:
            found = predict(model, poses_of_origin(recording, lever, current), DEFAULT_HORIZON)
        except RecordingError:  # too short for that
            continue
        except ModelError:
            return None
        squares += np.sum(found.errors**2, axis=0)
        floors += len(found.t) * found.floor**2
        stays += np.sum((found.measured - found.start) ** 2, axis=0)
        moves += np.sum(found.measured**2, axis=0)
        count += len(found.t)
    if count == 0:
        return None
    rms, floor, still, moving = (np.sqrt(x / count) for x in (squares, floors, stays, moves))
    return PredictionErrors(rms + 1e-12, floor, still, moving)


def _comparable(problem: Problem) -> bool:
    """Whether predictions a second ahead know all effects: what pushes the boat is not among theirs."""
    pushes = ("trim", "wind")
    return not any(problem.names[i].startswith(pushes) for i in problem.free_effects)
