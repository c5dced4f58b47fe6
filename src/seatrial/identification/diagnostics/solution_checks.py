# SPDX-License-Identifier: MIT
"""What a solution itself shows: outliers, a poor prediction, parameters at a bound, no significant coefficient."""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from seatrial import _core
from seatrial.boat.actuators.constants import ABSENT_AT
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import SURELY, Model
from seatrial.boat.noise_parameters import (
    COLOUR,
    COLOUR_MEMORY,
    DISTURBANCES,
    PROCESS,
    SWAY_RATIO,
    noise_entry,
)
from seatrial.evaluation.prediction import DEFAULT_HORIZON, predict
from seatrial.identification.diagnostics.boat_changes import LEAST_CLOCK_OFFSET
from seatrial.identification.likelihood.fit_horizon import ERROR_FLOOR, comparable
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import at_bounds, far_from_poses
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.whiteness import AT_LEAST, without_process_noise
from seatrial.util.errors import IdentificationError, ModelError, RecordingError
from seatrial.util.frames import AXES, Array
from seatrial.util.statistics import inverse_of

SIGNIFICANCE_LEVEL = 0.05  # that any coefficient differs from zero by chance
REPORTED_OUTLIERS = 0.03  # share of the poses: false matches are usually rarer
REFUSED_OUTLIERS = 0.3  # share of the poses: then the model is wrong, not the poses
# times the squared noise floor: below it squared errors say nothing of the model
NOISE_DOMINATED = 2.0
USELESS_RATIO = 0.9  # RMS error over that of a constant or zero velocity: from here on the model predicts nothing
# of the RMS error: with smaller process noise in a second, pose noise hides a good model
DISTURBANCE_SHARE = 0.3
# standard errors of a force's coefficient: beyond it poses and commands belong together
EVIDENT_THRUST = 15.0


@dataclass(frozen=True)
class _PredictionErrors:
    """RMS errors of the velocities one second ahead, over all recordings."""

    rms: Array  # (3,)
    floor: Array  # (3,) that pose noise alone makes
    constant: Array  # (3,) of a constant velocity
    zero: Array  # (3,) of a zero velocity: the velocity itself


def solution_findings(at: Point, horizon: float, covariance: Array) -> list[Finding]:
    """What every solution is checked for. horizon: [s] of the fit; covariance: (p, p) of the free parameters.

    Raises IdentificationError where no model of this structure explains the poses.
    """
    findings = [*_outliers(at), *_poor_prediction(at, horizon), *at_bound_findings(at)]
    findings += _of_a_filter(at)
    if horizon:
        findings.append(finding_of(FindingKind.MODEL_MISMATCH, horizon=horizon))
    return [*findings, *_nothing_significant(at, covariance)]


def late_command_findings(model: Model) -> list[Finding]:
    """Latencies that are clearly negative: no thruster acts before its command."""
    found = dict(zip(model.vehicle.constants.names, model.constants.tolist(), strict=True))
    findings = []
    for name, value in found.items():
        error = model.standard_errors[name]
        late = name.partition(".")[0] == "latency" and value < -LEAST_CLOCK_OFFSET
        if late and 0.0 < SURELY * error < -value:
            kind = FindingKind.LATE_COMMANDS
            findings.append(finding_of(kind, name, lead=-value, error=error))
    return findings


def _outliers(at: Point) -> list[Finding]:
    """A finding on the share of outliers. Raises IdentificationError where it is too large for any model."""
    weights = np.concatenate([np.asarray(p.weight) for p in at.runs.by_recording])
    used = weights > 0.0
    share = float(np.mean(weights[used] < 1.0))
    if share > REFUSED_OUTLIERS or far_from_poses(at):
        rejected = f"{100 * share:.0f} % of the poses are rejected as outliers"
        raise IdentificationError(
            f"{rejected if share else 'the poses are nowhere near'}: no model of this structure "
            "explains them. Check the recordings with 'seatrial inspect', and the vehicle file's signs"
        )
    if share > REPORTED_OUTLIERS:
        return [finding_of(FindingKind.OUTLIERS, share=share)]
    return []


def _poor_prediction(at: Point, horizon: float = 0.0) -> list[Finding]:
    """A finding if the model predicts no better one second ahead than a constant or zero velocity.

    No note where pose noise hides how good the model is, unless it was fitted to a `horizon` [s].
    """
    if without_process_noise(at) or not comparable(at.runs.problem):
        return []
    ahead = _prediction_errors(at.runs.problem, at.theta, at.noise)
    if ahead is None:
        return [finding_of(FindingKind.NOT_PREDICTABLE)]
    moves = ahead.zero**2 > NOISE_DOMINATED * ahead.floor**2
    least = np.where(moves, np.minimum(ahead.constant, ahead.zero), ahead.constant)
    ratio = ahead.rms / np.maximum(least, ERROR_FLOOR)
    process = np.hypot(at.noise[PROCESS][:2], at.noise[DISTURBANCES])[[0, 0, 1]]  # in a second
    process[1] *= at.noise[SWAY_RATIO]
    known = (process < DISTURBANCE_SHARE * ahead.rms) & (horizon == 0.0)
    known |= ahead.rms**2 < NOISE_DOMINATED * ahead.floor**2
    known |= np.array([_thrust_is_evident(at, axis) for axis in range(3)])
    poor = [
        axis for axis, r, k in zip(AXES, ratio, known, strict=True) if r > USELESS_RATIO and not k
    ]
    if not poor:
        return []
    return [finding_of(FindingKind.NO_BETTER_THAN_CONSTANT, *poor)]


def _thrust_is_evident(at: Point, axis: int) -> bool:
    """Whether a force coefficient of an axis is so significant that poses and commands belong together."""
    problem = at.runs.problem
    thrust, _ = problem.vehicle.structure.thrust_and_drag(axis)
    free = np.array(problem.free)
    errors = np.sqrt(np.diag(inverse_of(at.runs.information)))
    own = np.array([problem.names[i] in thrust for i in free])
    return bool((np.abs(at.theta[free]) > EVIDENT_THRUST * errors)[own].any())


def _prediction_errors(problem: Problem, theta: Array, noise: Array) -> _PredictionErrors | None:
    """Errors of the model with these parameters and this noise (12,); None where it diverges."""
    squares, floors, constant, zero = np.zeros((4, 3))
    count, model = 0, problem.model(theta, noise_entry(noise))
    for i in range(len(problem.recordings)):
        try:
            found = predict(model, problem.origin_poses(i, theta), DEFAULT_HORIZON)
        except RecordingError:  # too short
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
    return _PredictionErrors(rms + ERROR_FLOOR, floor, constant, zero)


def _of_a_filter(at: Point) -> list[Finding]:
    """A finding if position or heading has no white errors, but some that last: no sensor is so, a filter is."""
    # errors with a memory shorter than the step between poses are white
    steps = np.concatenate([np.diff(r.t) for r in at.runs.problem.recordings])
    memory = at.noise[COLOUR_MEMORY]
    if memory < np.median(steps):
        return []
    findings = []
    for i, kind in enumerate((FindingKind.SMOOTH_POSITION, FindingKind.SMOOTH_HEADING)):
        white, least, lasting = at.noise[i], at.runs.problem.least_noise[i], at.noise[COLOUR[i]]
        if white <= AT_LEAST * least and lasting > _core.NO_COLOUR:
            sizes = {"white": 1e3 * white, "lasting": 1e3 * lasting, "memory": memory}
            findings.append(finding_of(kind, **{k: float(v) for k, v in sizes.items()}))
    return findings


def at_bound_findings(at: Point) -> list[Finding]:
    """A finding on each parameter that ends at a bound: of its physical range, or of the one that is searched."""
    problem, findings = at.runs.problem, []
    for i, low, high in np.column_stack([problem.free, *problem.bounds])[at_bounds(at)]:
        value, name = at.theta[int(i)], problem.names[int(i)]
        end = int(abs(value - low) >= abs(value - high))
        bound, stage = float((low, high)[end]), name.partition(".")[0]
        searched = int(i) >= problem.n_coefficients and ABSENT_AT.get(stage) != end
        if searched:
            found = finding_of(FindingKind.BEYOND_RANGE, name, bound=bound, stage=stage)
        else:
            found = finding_of(FindingKind.AT_BOUND, name, bound=bound)
        findings.append(found)
    return findings


def _nothing_significant(at: Point, covariance: Array) -> list[Finding]:
    """A finding if no coefficient differs from zero at the 5 % level, which is shared by all (Bonferroni)."""
    free = np.array(at.runs.problem.free)
    own = free < at.runs.problem.n_coefficients
    limit = NormalDist().inv_cdf(1.0 - 0.5 * SIGNIFICANCE_LEVEL / max(int(own.sum()), 1))
    significant = np.abs(at.theta[free]) > limit * np.sqrt(np.diag(covariance))
    if not own.any() or significant[own].any():
        return []
    return [finding_of(FindingKind.NO_SIGNIFICANT_COEFFICIENT)]
