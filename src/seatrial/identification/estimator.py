# SPDX-License-Identifier: MIT
"""Prediction-error estimation of boat and thrusters together, on the raw poses.

An extended Kalman filter, driven by the model, predicts every pose from those before it; what is
maximised is the likelihood of its errors, over coefficients, constants of the actuator chain, and
the noise of poses and process alike (Ljung, System Identification, 2nd ed., section 7.4). Without
process noise this is the simulation error of whole recordings, with much of it every pose is a new
start: the data say how long the model is to be believed. Pose noise is modelled, so that it does
not bias the coefficients as it does the paper's.
"""

import itertools
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import msgspec
import numpy as np

from seatrial import _core
from seatrial.boat.findings import Finding, FindingKind, finding_of, of_kinds
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import earth_fixed, noise_vector
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.diagnostics.external_disturbances import bumps, bumps_said, bumps_tried
from seatrial.identification.diagnostics.homogeneity import disagreements
from seatrial.identification.diagnostics.parameter_drift import wear
from seatrial.identification.diagnostics.unmodelled_effects import hints
from seatrial.identification.likelihood.fit_horizon import prediction_findings, with_fit_horizon
from seatrial.identification.likelihood.noise_structures import multi_start
from seatrial.identification.likelihood.optimiser import Point, far_from_poses, maximise_likelihood
from seatrial.identification.likelihood.problem import EFFECT_KINDS, LEVER_NAMES, Prior, Problem
from seatrial.identification.likelihood.start_noise import noise_from_poses
from seatrial.identification.likelihood.whiteness import without_process_noise
from seatrial.identification.regression.start_lever import lever_from_poses, poses_of_origin
from seatrial.identification.regression.start_values import start_values
from seatrial.identification.selection.actuator_selection import STAGES_SELECTED, freed, problem_of
from seatrial.identification.selection.actuator_stages import (
    CHAIN_FINDINGS,
    staged,
    with_free_stages,
)
from seatrial.identification.solution import OUTPUT_ERROR, Fit, OutputErrorSettings
from seatrial.identification.uncertainty.covariance import (
    at_bounds,
    sandwich_covariance,
    with_enough_blocks,
)
from seatrial.identification.uncertainty.dead_zone import with_dead_zone_profile
from seatrial.identification.uncertainty.lag import with_lag_by_square
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import motion
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array
from seatrial.util.statistics import inverse_of

SHORT = 0.02  # [m] a lever arm that is none
LONGEST = 0.3  # step times rate of the boat's quickest motion
SHORTEST_STEP = 1 / 480  # [s]
MANY, HOPELESS = 0.03, 0.3  # shares of poses beyond the outlier's limit: said, refused


__all__ = ["OUTPUT_ERROR", "Fit", "OutputErrorSettings", "fit", "output_error", "with_free_stages"]


def output_error(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    settings: OutputErrorSettings | None = None,
    start: Model | None = None,
    prior: Model | None = None,
) -> Model:
    """Coefficients and the constants of the chain that the vehicle file does not state.

    Latency and lag are found, and the dead zone where the commands show it. `start`:
    a model to start from; `prior`: a model whose estimates count as far as its covariance says.
    Raises IdentificationError where the search does not get anywhere.
    """
    return fit(recordings, vehicle, settings=settings, start=start, prior=prior).model()


def fit(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    settings: OutputErrorSettings | None = None,
    start: Model | None = None,
    prior: Model | None = None,
) -> Fit:
    """`output_error` with all that the estimates came from."""
    chosen = settings or OutputErrorSettings()
    for kind in chosen.effects:
        if kind not in EFFECT_KINDS:
            raise IdentificationError(f"no effect '{kind}'; there are {', '.join(EFFECT_KINDS)}")
    fresh = start is None and chosen.extras
    if not (fresh and prior is None and "lever" in chosen.effects):
        return _fit(recordings, vehicle, chosen, start, prior, further=fresh)
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
    """The solution with a lever arm that is found from the one without, thrusters and all; None: there is none.

    A boat that is not yet known well may have its lever arm anywhere: where drag and inertia are free to
    move with it, the likelihood is nearly flat along it, and a search may end far off.
    """
    without = replace(chosen, effects=tuple(e for e in chosen.effects if e != "lever"))
    with suppress(IdentificationError):
        begin = _fit(recordings, vehicle, without, None, None, further=True).model()
        return _fit(recordings, vehicle, chosen, begin, None, further=True)
    return None


def _cost(found: Fit) -> float:
    """-2 log likelihood, the model believed as closely as it makes likely."""
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
) -> Fit:
    """`fit` from one start; `further`: more stages of the chain are tried, and hints looked for."""
    whole, findings = _whole(vehicle, recordings, start)
    if further and start is not None:
        findings = [*of_kinds(findings, *STAGES_SELECTED), *staged(vehicle, recordings)[1]]
    problem = _with_prior(problem_of(whole, vehicle, recordings, chosen), prior)
    if start is not None:
        problem = replace(problem, earth_fixed=earth_fixed(start.noise))
    if prior is None:
        problem = with_enough_blocks(problem)
        if problem.block < chosen.block:
            findings.append(finding_of(FindingKind.SHORT_BLOCKS, length=problem.block))
    at, theta = _searched(problem, recordings, start, hold=chosen.hold_noise)
    at = at if chosen.hold_noise else multi_start(at, theta)
    bumped = at if bumps(at) else None
    likely, at, share = with_fit_horizon(at, hold=chosen.hold_noise)
    for point in (at, bumped or at):
        point.runs.drop_linearisation()
    if further and prior is None:  # what a prior says, it says of its own stages
        likely, at, share, found = _with_stages((likely, at, share), vehicle, chosen)
        findings += found
    if further:
        findings += [*hints(at, share), *disagreements(at), *wear(at)]
    findings += [*_rejected(at), *prediction_findings(at, share)]
    problem = at.runs.problem
    for i, low, high in np.column_stack([problem.free, *problem.bounds])[at_bounds(at)]:
        value = at.theta[int(i)]
        end = low if abs(value - low) < abs(value - high) else high
        findings.append(finding_of(FindingKind.AT_BOUND, problem.names[int(i)], bound=float(end)))
    if share:
        findings.append(finding_of(FindingKind.MODEL_MISMATCH, share=share))
    covariance = with_lag_by_square(at, with_dead_zone_profile(at, sandwich_covariance(at)))
    sought = chosen.extras and (further or prior is not None) and not chosen.hold_noise
    if sought and (bumped is not None or not without_process_noise(at)):
        findings += bumps_said(bumped, at, covariance, _afresh)
    if _nothing_told(at, covariance):
        findings.append(finding_of(FindingKind.NO_SIGNIFICANT_COEFFICIENT))
    return Fit(
        at.runs.problem,
        at.theta,
        at.noise,
        at.runs,
        covariance,
        chosen,
        tuple(findings),
        share,
        likely,
    )


def _with_stages(
    believed_so: tuple[Array, Point, float], vehicle: Vehicle, chosen: OutputErrorSettings
) -> tuple[Array, Point, float, list[Finding]]:
    """The likelihood's noise, the solution, how closely it is believed, and what was freed.

    What was missing made the model be believed less closely: with it that is asked again.
    """
    likely, at, share = believed_so
    findings: list[Finding] = []
    while True:
        at, found = freed(at, vehicle, chosen, share)
        findings += found
        if not found or share == 0.0:
            return likely, at, share, findings
        try:
            again = maximise_likelihood(at.runs.problem, at.theta, likely, hold=chosen.hold_noise)
        except IdentificationError:
            return likely, at, share, findings
        likely, at, share = with_fit_horizon(again, hold=chosen.hold_noise)
        at.runs.drop_linearisation()


def _nothing_told(at: Point, covariance: Array) -> bool:
    """Whether all coefficients are within two standard errors of nothing."""
    free = np.array(at.runs.problem.free)
    own = free < at.runs.problem.n_coefficients
    told = np.abs(at.theta[free]) > 2.0 * np.sqrt(np.diag(covariance))
    return bool(own.any() and not told[own].any())


def _searched(
    problem: Problem, recordings: Sequence[Recording], start: Model | None, *, hold: bool
) -> tuple[Point, Array]:
    """The solution and the parameters where its search began.

    Where a start model leads nowhere, as the boat is another now, it begins without one.
    """
    theta, noise = _first(problem, recordings, start)
    own = replace(problem, step=_step(problem, theta))
    try:
        return maximise_likelihood(own, theta, noise, hold=hold), theta
    except IdentificationError as error:
        if start is not None and not hold:
            return _searched(problem, recordings, None, hold=False)
        said = bumps_tried(problem, _afresh) or _lever_tried(problem, recordings)
        raise IdentificationError(f"{error}{said}") from error


def _afresh(problem: Problem) -> Point:
    """The solution from start values, without what is tried where there is none."""
    theta, noise = _first(problem, problem.recordings, None)
    return maximise_likelihood(replace(problem, step=_step(problem, theta)), theta, noise)


def _lever_tried(problem: Problem, recordings: Sequence[Recording]) -> str:
    """What is to be said where there is no solution, but one with a lever arm."""
    lever = tuple(i for i, name in enumerate(problem.names) if name in LEVER_NAMES)
    if set(lever) & set(problem.free):
        return ""
    wider = replace(problem, free=(*problem.free, *lever))
    theta, noise = _first(wider, recordings, None)
    try:
        found = maximise_likelihood(replace(wider, step=_step(wider, theta)), theta, noise).theta[
            list(lever)
        ]
    except IdentificationError:
        return ""
    if np.hypot(*found) < SHORT:
        return ""
    return (
        f". With poses of a point about {np.hypot(*found):.2g} m off the origin, a lever arm, there is a "
        "solution: if that may be, identify with --effect lever"
    )


def _rejected(at: Point) -> list[Finding]:
    """How many poses count less, being far off; refused where they are so many as to mean nothing."""
    weights = np.concatenate([np.asarray(p.weight) for p in at.runs.by_recording])
    used = weights > 0.0
    share = float(np.mean(weights[used] < 1.0))
    if share > HOPELESS or far_from_poses(at):
        rejected = f"{100 * share:.0f} % of the poses are rejected as outliers"
        raise IdentificationError(
            f"{rejected if share else 'the poses are nowhere near'}: no model of this structure "
            "goes with them; look at the recordings with inspect, and at the vehicle file's signs"
        )
    if share > MANY:
        return [finding_of(FindingKind.OUTLIERS, share=share)]
    return []


def _step(problem: Problem, theta: Array) -> float:
    """As long as asked for, but short beside the boat's quickest motion at the speeds that occur."""
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
    return float(min(problem.step, max(LONGEST / max(quickest, 1e-9), SHORTEST_STEP)))


def _whole(
    vehicle: Vehicle, recordings: Sequence[Recording], start: Model | None
) -> tuple[Vehicle, list[Finding]]:
    """The vehicle with all stages that are sought: the start model's own, where it has some.

    What the vehicle file states goes before what the start model found. Of that model's findings only those of its
    chain stay: the others are of other recordings.
    """
    if start is not None and start.estimator.method == OUTPUT_ERROR:
        known = set(vehicle.constants.names)
        if known <= set(start.vehicle.constants.names):
            kept = list(start.findings_of(*STAGES_SELECTED, *CHAIN_FINDINGS))
            chain = list(start.vehicle.file.chain)
            fresh, _ = staged(vehicle, recordings)
            apart = [g.name for g in fresh.file.chain if _two_edges(g)]
            both = [_parted(g) if g.name in apart else g for g in chain]
            if both != chain:
                kept = [f for f in kept if f.kind is not FindingKind.DEAD_ZONE_ONE_EDGE]
            own = dict(zip(vehicle.constants.names, vehicle.constants.values.tolist(), strict=True))
            stated = {name: own[name] for name in known - set(vehicle.estimated)}
            return vehicle.with_chain(both).with_stated(stated), kept
    return staged(vehicle, recordings)


def _two_edges(group: ChainGroup) -> bool:
    return isinstance(group.dead_zone, DeadZone) and not group.dead_zone.symmetric


def _parted(group: ChainGroup) -> ChainGroup:
    """The group with an edge of its own for reverse, where one stands for both: now data show it."""
    zone = group.dead_zone
    if not isinstance(zone, DeadZone) or not zone.symmetric or isinstance(zone.forward, str):
        return group
    return msgspec.structs.replace(group, dead_zone=DeadZone(zone.forward, zone.forward))


def _with_prior(problem: Problem, prior: Model | None) -> Problem:
    """The problem with what a model says of parameters of the same name.

    Of those without a variance it says nothing.
    """
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


def _first(
    problem: Problem, recordings: Sequence[Recording], start: Model | None
) -> tuple[Array, Array]:
    """Where the search starts: parameters and noise."""
    n, m = problem.n_coefficients, problem.n_constants
    theta = np.zeros(len(problem.names))
    given: dict[str, float] = {}
    if start is not None:
        values = np.concatenate([start.coefficients, start.constants]).tolist()
        given = dict(zip(start.parameters, values, strict=True))
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
    for i in (i for i in problem.free if i < n + m):
        theta[i] = given.get(problem.names[i], theta[i])
    noise = None if start is None else noise_vector(start.noise)
    return theta, noise_from_poses(recordings) if noise is None else noise
