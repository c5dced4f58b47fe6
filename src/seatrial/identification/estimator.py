# SPDX-License-Identifier: MIT
"""Prediction-error estimation of boat and thrusters together, on the raw poses.

An extended Kalman filter with the model predicts every pose from those before it. The likelihood of its
innovations is maximised over coefficients, constants of the actuator chain, pose noise and process noise (Ljung,
System Identification, 2nd ed., section 7.4). Without process noise this is the simulation error of whole
recordings; with much of it, the one-pose prediction error. Pose noise is modelled, so it does not bias the
coefficients as it does with the paper's least squares.
"""

import itertools
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from statistics import NormalDist

import msgspec
import numpy as np

from seatrial import _core
from seatrial.boat.findings import Finding, FindingKind, finding_of, of_kinds
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import earth_fixed
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.diagnostics.external_disturbances import (
    disturbance_findings,
    disturbance_hint,
    disturbed_at,
)
from seatrial.identification.diagnostics.homogeneity import homogeneity_findings
from seatrial.identification.diagnostics.parameter_drift import drift_findings
from seatrial.identification.diagnostics.unmodelled_effects import unmodelled_effect_findings
from seatrial.identification.likelihood.fit_horizon import (
    prediction_findings,
    with_noise_or_horizon,
)
from seatrial.identification.likelihood.noise_structures import refined
from seatrial.identification.likelihood.optimiser import (
    MOST_PASSES,
    Outcome,
    Point,
    at_bounds,
    by_linearisation,
    converged,
    far_from_poses,
    full_pass,
    maximise_likelihood,
    search,
)
from seatrial.identification.likelihood.problem import (
    DELAY_NAMES,
    EFFECT_KINDS,
    LEVER_NAMES,
    START_DELAY,
    Prior,
    Problem,
)
from seatrial.identification.likelihood.start_noise import noise_from_poses
from seatrial.identification.likelihood.whiteness import is_white, without_process_noise
from seatrial.identification.regression.start_lever import lever_from_poses
from seatrial.identification.regression.start_values import start_values
from seatrial.identification.selection.actuator_selection import (
    STAGES_SELECTED,
    problem_with,
    select_stages,
)
from seatrial.identification.selection.actuator_stages import (
    CHAIN_FINDINGS,
    with_estimated_stages,
    with_free_stages,
)
from seatrial.identification.solution import (
    OUTPUT_ERROR,
    Fit,
    OutputErrorSettings,
    StartValues,
)
from seatrial.identification.uncertainty.covariance import (
    SHORTEST_BLOCK,
    sandwich_covariance,
    with_enough_blocks,
)
from seatrial.identification.uncertainty.dead_zone import with_dead_zone_profile
from seatrial.identification.uncertainty.lag import with_lag_by_square
from seatrial.recording.delays import at_one_time
from seatrial.recording.origin import poses_of_origin
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import motion
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array
from seatrial.util.progress import stage
from seatrial.util.statistics import inverse_of

SIGNIFICANCE_LEVEL = 0.05  # that any coefficient differs from zero by chance
FIRST_PASSES = 12  # of the first search, at most
LEAST_LEVER_ARM = 0.02  # [m] a shorter one does not explain why there is no solution
MOST_STEP_TIMES_RATE = 0.3  # step times the fastest eigenvalue: Runge-Kutta is accurate below
LEAST_INTEGRATION_STEP = 1 / 480  # [s] a shorter one costs time and changes nothing
REPORTED_OUTLIERS = 0.03  # share of the poses: false matches are usually rarer
REFUSED_OUTLIERS = 0.3  # share of the poses: then the model is wrong, not the poses


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

    Latency and lag are estimated, and the dead zone where the commands identify it. `start`: a model to start
    from; `prior`: a model whose estimates have the weight of their covariance. Raises IdentificationError where
    the search finds no solution.
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
    for kind in chosen.effects:
        if kind not in EFFECT_KINDS:
            raise IdentificationError(f"no effect '{kind}'; there are {', '.join(EFFECT_KINDS)}")
    fresh = start is None and chosen.select_stages
    known = begin is not None and begin.values.keys() >= set(LEVER_NAMES)
    if known or not (fresh and prior is None and "lever" in chosen.effects):
        return _fit(recordings, vehicle, chosen, start, prior, further=fresh, begin=begin)
    beside = _from_stated_lever(recordings, vehicle, chosen)
    try:
        found = _fit(recordings, vehicle, chosen, None, None, further=True)
    except IdentificationError:
        if beside is None:
            raise
        return beside
    return found if beside is None else min(found, beside, key=_cost)


def _from_stated_lever(
    recordings: Sequence[Recording], vehicle: Vehicle, chosen: OutputErrorSettings
) -> Fit | None:
    """The solution with a lever arm, started from the one without; None: there is none.

    The likelihood is nearly flat along the lever arm where drag and inertia are free, so that a search from start
    values may end far away.
    """
    without = replace(chosen, effects=tuple(e for e in chosen.effects if e != "lever"))
    with suppress(IdentificationError):
        begin = _fit(recordings, vehicle, without, None, None, further=True).model()
        return _fit(recordings, vehicle, chosen, begin, None, further=True)
    return None


def _cost(found: Fit) -> float:
    """-2 log L at the noise that maximises it, without a fit horizon."""
    noise = found.noise if found.maximum_noise is None else found.maximum_noise
    return found.problem.run_filter(found.theta, noise, repeatable=False).cost


def _fit(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    chosen: OutputErrorSettings,
    start: Model | None,
    prior: Model | None,
    *,
    further: bool,
    begin: StartValues | None = None,
) -> Fit:
    """`fit` from one start; `further`: with stage selection and all diagnostics."""
    # which parameters are free, and the prior on them
    whole, findings = _with_sought_stages(vehicle, recordings, start)
    if further and start is not None:
        findings = [
            *of_kinds(findings, *STAGES_SELECTED),
            *with_estimated_stages(vehicle, recordings)[1],
        ]
    problem = _with_prior(problem_with(whole, vehicle, recordings, chosen), prior)
    if start is not None:
        problem = replace(problem, earth_fixed=earth_fixed(start.noise))
    if prior is None:
        problem = with_enough_blocks(problem)
        if problem.block < chosen.block:
            findings.append(finding_of(FindingKind.SHORT_BLOCKS, length=problem.block))
    # the maximum of the likelihood: the noise structure, or under model mismatch the fit horizon
    values = begin if start is None else StartValues.of_model(start)
    with stage("likelihood", 0.25):
        at = likely = _maximised(problem, recordings, values, hold=chosen.hold_noise)
    horizon = 0.0
    with stage("noise structure", 0.3):
        if not chosen.hold_noise:
            likely, at, horizon = with_noise_or_horizon(at)
    disturbed = likely if disturbed_at(likely) else None
    # further stages of the actuator chain
    with stage("actuator stages", 0.25):
        if further and prior is None:  # a prior has stages of its own
            at, horizon, found = _with_stages(at, horizon, likely.noise, vehicle, chosen)
            findings += found
    # standard errors, and diagnostics at the solution
    with stage("standard errors", 0.1):
        covariance = with_lag_by_square(at, with_dead_zone_profile(at, sandwich_covariance(at)))
    with stage("diagnostics"):
        if further:
            findings += [
                *unmodelled_effect_findings(at, horizon, covariance),
                *homogeneity_findings(at),
                *drift_findings(at),
            ]
        findings += [*_outliers(at), *prediction_findings(at, horizon), *at_bound_findings(at)]
        if horizon:
            findings.append(finding_of(FindingKind.MODEL_MISMATCH, horizon=horizon))
        # what disturbed intervals do to the standard errors
        sought = chosen.select_stages and (further or prior is not None) and not chosen.hold_noise
        if sought and (disturbed is not None or not without_process_noise(at)):
            findings += disturbance_findings(disturbed, at, covariance)
    if _nothing_significant(at, covariance):
        findings.append(finding_of(FindingKind.NO_SIGNIFICANT_COEFFICIENT))
    for point in (at, likely):
        point.runs.drop_linearisation()
    return Fit(
        at.runs.problem,
        at.theta,
        at.noise,
        at.runs,
        covariance,
        chosen,
        tuple(findings),
        horizon,
        likely.noise,
    )


def at_bound_findings(at: Point) -> list[Finding]:
    """A finding on each parameter that ends at a bound."""
    problem, findings = at.runs.problem, []
    for i, low, high in np.column_stack([problem.free, *problem.bounds])[at_bounds(at)]:
        value = at.theta[int(i)]
        end = low if abs(value - low) < abs(value - high) else high
        findings.append(finding_of(FindingKind.AT_BOUND, problem.names[int(i)], bound=float(end)))
    return findings


def _with_stages(
    at: Point, horizon: float, likely: Array, vehicle: Vehicle, chosen: OutputErrorSettings
) -> tuple[Point, float, list[Finding]]:
    """The solution with the selected stages, its fit horizon, and findings on them.

    A missing stage is model mismatch: where the innovations are white with the stages, the maximum of the
    likelihood takes the place of the fit horizon. likely: (11,) the noise at the maximum without the stages.
    """
    at, findings = select_stages(at, vehicle, chosen, horizon)
    if horizon and findings:
        # first on the linearisation: mismatch that stays needs no search
        near = by_linearisation(full_pass(at.runs.problem, at.theta, likely))
        again, outcome = (
            search(at.runs.problem, near.theta, near.noise) if is_white(near) else (at, None)
        )
        if outcome is Outcome.CONVERGED and is_white(again):
            return refined(again), 0.0, findings
    return at, horizon, findings


def _nothing_significant(at: Point, covariance: Array) -> bool:
    """Whether no coefficient differs from zero at the 5 % level, which is shared by all (Bonferroni)."""
    free = np.array(at.runs.problem.free)
    own = free < at.runs.problem.n_coefficients
    limit = NormalDist().inv_cdf(1.0 - 0.5 * SIGNIFICANCE_LEVEL / max(int(own.sum()), 1))
    significant = np.abs(at.theta[free]) > limit * np.sqrt(np.diag(covariance))
    return bool(own.any() and not significant[own].any())


def _maximised(
    problem: Problem, recordings: Sequence[Recording], start: StartValues | None, *, hold: bool
) -> Point:
    """The maximum of the likelihood, or a point near it where the search is slow, as under model mismatch.

    If the search from given start values fails, as the boat has changed, it starts again without one.
    """
    theta, noise = _start(problem, recordings, start)
    own = replace(problem, step=integration_step(problem, theta))
    try:
        at, outcome = search(
            own, theta, noise, hold=hold, passes=MOST_PASSES if hold else FIRST_PASSES
        )
        near = outcome is Outcome.OUT_OF_STEPS and not hold and not far_from_poses(at)
        return at if near else converged((at, outcome))
    except IdentificationError as error:
        if start is not None and not hold:
            return _maximised(problem, recordings, None, hold=False)
        said = disturbance_hint(problem, _from_start_values) or _lever_arm_hint(problem, recordings)
        raise IdentificationError(f"{error}{said}") from error


def first_maximum(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    effects: Sequence[str] = (),
    *,
    start: StartValues | None = None,
    short: bool = False,
) -> Point:
    """The maximum of the likelihood that the search from start values finds; no fit horizon, no further stages.

    short: recordings with fewer blocks than parameters are not refused; their standard errors are those of white
    innovations.
    """
    whole, _ = with_estimated_stages(vehicle, recordings)
    settings = OutputErrorSettings(effects=tuple(effects))
    problem = problem_with(whole, vehicle, recordings, settings)
    problem = replace(problem, block=SHORTEST_BLOCK) if short else with_enough_blocks(problem)
    return _maximised(problem, recordings, start, hold=False)


def _from_start_values(problem: Problem) -> Point:
    """The maximum of the likelihood from start values; no further attempts."""
    theta, noise = _start(problem, problem.recordings, None)
    return maximise_likelihood(
        replace(problem, step=integration_step(problem, theta)), theta, noise
    )


def _lever_arm_hint(problem: Problem, recordings: Sequence[Recording]) -> str:
    """For a refusal: the lever arm with which there is a solution; else nothing."""
    lever = tuple(i for i, name in enumerate(problem.names) if name in LEVER_NAMES)
    if set(lever) & set(problem.free):
        return ""
    wider = replace(problem, free=(*problem.free, *lever))
    theta, noise = _start(wider, recordings, None)
    try:
        found = maximise_likelihood(
            replace(wider, step=integration_step(wider, theta)), theta, noise
        ).theta[list(lever)]
    except IdentificationError:
        return ""
    if np.hypot(*found) < LEAST_LEVER_ARM:
        return ""
    return (
        f". There is a solution with poses of a point about {np.hypot(*found):.2g} m off the origin, a lever arm. "
        "If it is plausible, identify with --effect lever"
    )


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


def integration_step(problem: Problem, theta: Array) -> float:
    """Step [s] of the integration: the chosen one, or less where the boat's fastest eigenvalue requires it."""
    vehicle, n = problem.vehicle, problem.n_coefficients
    nu = np.concatenate([m.nu[m.valid] for m in map(motion, problem.recordings)])
    if not len(nu):
        names = ", ".join(r.name for r in problem.recordings)
        raise IdentificationError(
            f"{names}: nowhere five usable poses in a row at stamps that are at all alike; if they "
            "come from two trackers, take one"
        )
    fast = np.percentile(np.abs(nu), 99, axis=0)
    corners = fast * np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))
    small = 1e-4 * np.eye(3)
    still = np.zeros((len(corners), len(vehicle.forces)))

    def rate(at: Array) -> Array:
        return _core.accelerations(
            vehicle.structure.compiled, np.ascontiguousarray(theta[:n]), at, still
        )

    slopes = np.stack([(rate(corners + d) - rate(corners - d)) / 2e-4 for d in small], axis=2)
    quickest = float(np.abs(np.linalg.eigvals(slopes)).max())
    return float(
        min(problem.step, max(MOST_STEP_TIMES_RATE / max(quickest, 1e-9), LEAST_INTEGRATION_STEP))
    )


def _with_sought_stages(
    vehicle: Vehicle, recordings: Sequence[Recording], start: Model | None
) -> tuple[Vehicle, list[Finding]]:
    """The vehicle with all stages that are estimated: the start model's own, where it has some.

    What the vehicle file states has priority. Of the start model's findings those on its actuator chain are kept:
    the others are on other recordings.
    """
    if start is not None and start.estimator.method == OUTPUT_ERROR:
        known = set(vehicle.constants.names)
        if known <= set(start.vehicle.constants.names):
            kept = list(start.findings_of(*STAGES_SELECTED, *CHAIN_FINDINGS))
            chain = list(start.vehicle.file.chain)
            fresh, _ = with_estimated_stages(vehicle, recordings)
            apart = [g.name for g in fresh.file.chain if _has_two_edges(g)]
            both = [_with_two_edges(g) if g.name in apart else g for g in chain]
            if both != chain:
                kept = [f for f in kept if f.kind is not FindingKind.DEAD_ZONE_ONE_EDGE]
            own = dict(zip(vehicle.constants.names, vehicle.constants.values.tolist(), strict=True))
            stated = {name: own[name] for name in known - set(vehicle.estimated)}
            return vehicle.with_chain(both).with_stated(stated), kept
    return with_estimated_stages(vehicle, recordings)


def _has_two_edges(group: ChainGroup) -> bool:
    return isinstance(group.dead_zone, DeadZone) and not group.dead_zone.symmetric


def _with_two_edges(group: ChainGroup) -> ChainGroup:
    """The group with a separate reverse edge where one stood for both: these recordings identify it."""
    zone = group.dead_zone
    if not isinstance(zone, DeadZone) or not zone.symmetric or isinstance(zone.forward, str):
        return group
    return msgspec.structs.replace(group, dead_zone=DeadZone(zone.forward, zone.forward))


def _with_prior(problem: Problem, prior: Model | None) -> Problem:
    """The problem with a model's estimates, if they have a variance, as prior of the same parameters."""
    if prior is None:
        return problem
    names = dict(zip(prior.parameters, range(len(prior.parameters)), strict=True))
    errors = np.sqrt(np.diag(prior.covariance))
    shared = [
        (i, names[problem.names[i]])
        for i in problem.free
        if problem.names[i] in names and errors[names[problem.names[i]]] > 0
    ]
    if not shared:
        raise IdentificationError(
            "the prior model shares no estimated parameter with this vehicle's structure"
        )
    mine, theirs = [i for i, _ in shared], [j for _, j in shared]
    at = np.zeros(len(problem.names))
    at[mine] = np.concatenate([prior.coefficients, prior.constants])[theirs]
    precision = np.zeros((len(at), len(at)))
    precision[np.ix_(mine, mine)] = inverse_of(prior.covariance[np.ix_(theirs, theirs)])
    return replace(problem, prior=Prior(at, precision))


def _start(
    problem: Problem, recordings: Sequence[Recording], start: StartValues | None
) -> tuple[Array, Array]:
    """Start of the search: parameters and noise."""
    n, m = problem.n_coefficients, problem.n_constants
    theta = np.zeros(len(problem.names))
    delays = [i for i in problem.free if problem.names[i] in DELAY_NAMES]
    theta[delays[:1]] = START_DELAY
    recordings = [at_one_time(r) for r in recordings]
    given = {} if start is None else start.values
    missing = [name for name in problem.names[:n] if name not in given]
    if start is None or len(missing) == n:
        sought = [i - n for i in problem.free if n <= i < n + m]
        lever = [i for i in problem.free if problem.names[i] in LEVER_NAMES]
        if lever:
            theta[lever] = lever_from_poses(recordings, problem.vehicle, sought)
            recordings = [poses_of_origin(r, theta[lever]) for r in recordings]
        theta[:n], theta[n : n + m] = start_values(recordings, problem.vehicle, sought)
    else:
        theta[n : n + m] = problem.vehicle.constants.values
    for i in problem.free:
        theta[i] = given.get(problem.names[i], theta[i])
    noise = None if start is None else start.noise
    return theta, noise_from_poses(recordings) if noise is None else noise
