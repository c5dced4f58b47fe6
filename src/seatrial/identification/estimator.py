# SPDX-License-Identifier: MIT
"""Prediction-error estimation of boat and thrusters together, on the raw poses.

An extended Kalman filter with the model predicts every pose from those before it. The likelihood of its
innovations is maximised over coefficients, constants of the actuator chain, pose noise and process noise (Ljung,
System Identification, 2nd ed., section 7.4). Without process noise this is the simulation error of whole
recordings; with much of it, the one-pose prediction error. Pose noise is modelled, so it does not bias the
coefficients as it does with the paper's least squares.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import earth_fixed
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.diagnostics.boat_changes import change_findings
from seatrial.identification.diagnostics.external_disturbances import (
    disturbance_findings,
    disturbed_at,
)
from seatrial.identification.diagnostics.solution_checks import solution_findings
from seatrial.identification.diagnostics.unmodelled_effects import unmodelled_effect
from seatrial.identification.first_search import maximised
from seatrial.identification.likelihood.fit_horizon import with_noise_or_horizon
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.noise_structures import with_equal_axes, with_unequal_axes
from seatrial.identification.likelihood.parameters import EFFECT_KINDS
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.whiteness import without_process_noise
from seatrial.identification.pose_rate import (
    near_with_all_poses,
    with_all_poses,
    with_fewer_poses,
)
from seatrial.identification.problem_setup import problem_with, with_prior, with_sought_stages
from seatrial.identification.selection.actuator_selection import select_stages
from seatrial.identification.selection.actuator_stages import (
    with_free_stages,
)
from seatrial.identification.solution import OUTPUT_ERROR, Fit, OutputErrorSettings, StartValues
from seatrial.identification.uncertainty.covariance import with_enough_blocks
from seatrial.identification.uncertainty.estimation_errors import estimation_covariance
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array
from seatrial.util.parallel import spread
from seatrial.util.progress import stage

__all__ = ["OUTPUT_ERROR", "Fit", "OutputErrorSettings", "fit", "output_error", "with_free_stages"]


def output_error(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    settings: OutputErrorSettings | None = None,
    start: Model | None = None,
    prior: Model | None = None,
) -> Model:
    """Coefficients, and the constants of the actuator chain that the vehicle file does not state.

    Latency and lag are estimated, and the dead zone where the commands identify it. Every recording counts for all
    axes. `settings`: defaults and ranges stand at `OutputErrorSettings`. `start`: a model to start from, without
    selection of stages; `prior`: a model whose estimates have the weight of their covariance. Raises
    IdentificationError where the search finds no solution.
    """
    return fit(recordings, vehicle, settings=settings, start=start, prior=prior).model()


def fit(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    settings: OutputErrorSettings | None = None,
    start: Model | None = None,
    prior: Model | None = None,
    begin: StartValues | None = None,
) -> Fit:
    """`output_error` with the solution: parameters, noise, filter runs, covariance.

    `begin`: start values for the search, which is complete all the same.
    """
    chosen = settings or OutputErrorSettings()
    further = start is None and chosen.select_stages  # with stage selection and all diagnostics
    problem, findings = _problem(recordings, vehicle, chosen, start, prior)
    # the maximum of the likelihood: the noise structure, or under model mismatch the fit horizon
    values = begin if start is None else StartValues.of_model(start)
    with stage("likelihood", 0.25):
        few = with_fewer_poses(problem)
        at = likely = maximised(few, recordings, values, hold=chosen.hold_noise)
    horizon = 0.0
    with stage("noise structure", 0.3):
        if not chosen.hold_noise:
            likely, at, horizon = with_noise_or_horizon(at)
    disturbed = likely if disturbed_at(likely) else None
    # further stages of the actuator chain
    with stage("actuator stages", 0.25):
        at = with_equal_axes(at)
        if further and prior is None:  # a prior has stages of its own
            at, selected = select_stages(at, vehicle, chosen, horizon)
            findings += selected
    # the same solutions with all poses, the noise of surge and sway each for itself
    with stage("all poses", 0.1):
        equal = with_all_poses(at, problem, horizon, hold=chosen.hold_noise)
        at = equal if chosen.hold_noise or horizon else with_unequal_axes(equal)
        if disturbed is not None:
            disturbed = near_with_all_poses(disturbed, problem)
    # standard errors, and diagnostics at the solution
    with stage("standard errors", 0.1):
        covariance = estimation_covariance(at)
    with stage("diagnostics"):
        findings += _diagnosed(
            at, horizon, covariance, chosen, disturbed, equal=equal, further=further,
            with_prior=prior is not None,
        )  # fmt: skip
    return Fit.of(at, covariance, chosen, findings, horizon=horizon, maximum=likely, equal=equal)


def _check_effects(effects: Sequence[str]) -> None:
    """Raise IdentificationError for an effect that there is not."""
    for kind in effects:
        if kind not in EFFECT_KINDS:
            raise IdentificationError(f"no effect '{kind}'; there are {', '.join(EFFECT_KINDS)}")


def _diagnosed(
    at: Point,
    horizon: float,
    covariance: Array,
    settings: OutputErrorSettings,
    disturbed: Point | None,
    *,
    equal: Point,
    further: bool,
    with_prior: bool,
) -> list[Finding]:
    """Findings at the solution, what it lacks by that of `equal` noise; `further`: with stage selection.

    `disturbed`: a solution with disturbances.
    """
    diagnostics: list[Callable[[], Sequence[Finding]]] = []
    if further:
        diagnostics += [
            lambda: unmodelled_effect(equal, horizon, covariance).findings,
            lambda: change_findings(equal),
        ]
    diagnostics.append(lambda: solution_findings(at, horizon, covariance))
    # what disturbed intervals do to the standard errors
    sought = settings.select_stages and (further or with_prior) and not settings.hold_noise
    if sought and (disturbed is not None or not without_process_noise(at)):
        diagnostics.append(lambda: disturbance_findings(disturbed, at, covariance))
    # none needs another
    return [finding for found in spread(lambda own: own(), diagnostics) for finding in found]


def _problem(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    chosen: OutputErrorSettings,
    start: Model | None,
    prior: Model | None,
) -> tuple[Problem, list[Finding]]:
    """Which parameters are free, the prior on them, and blocks that are enough for them; findings on these."""
    _check_effects(chosen.effects)
    whole, findings = with_sought_stages(vehicle, recordings, start)
    problem = with_prior(problem_with(whole, vehicle, recordings, chosen), prior)
    if start is not None:
        problem = replace(problem, earth_fixed=earth_fixed(start.noise))
    if prior is None:
        problem = with_enough_blocks(problem)
        if problem.block < chosen.block:
            findings.append(finding_of(FindingKind.SHORT_BLOCKS, length=problem.block))
    return problem, findings
