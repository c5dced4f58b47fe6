# SPDX-License-Identifier: MIT
"""The problem before the search: which parameters are free, the prior on them, where the search begins."""

import itertools
from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np

from seatrial import _core
from seatrial.boat.actuators import STAGES
from seatrial.boat.findings import Finding, FindingKind
from seatrial.boat.model import Model
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.input_errors import input_errors
from seatrial.identification.likelihood.parameters import DELAY_NAMES, LEVER_NAMES, START_DELAY
from seatrial.identification.likelihood.problem import Prior, Problem
from seatrial.identification.likelihood.start_noise import noise_from_poses
from seatrial.identification.regression.start_values import lever_from_poses, start_values
from seatrial.identification.selection.actuator_stages import (
    CHAIN_FINDINGS,
    STAGES_SELECTED,
    with_estimated_stages,
)
from seatrial.identification.solution import OUTPUT_ERROR, OutputErrorSettings, StartValues
from seatrial.inspection.consistency.check import file_commands
from seatrial.inspection.consistency.gains import read_runs
from seatrial.inspection.consistency.position_delay import position_delay
from seatrial.recording.delays import at_one_time, with_delays
from seatrial.recording.origin import poses_of_origin
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import usual_velocities
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array
from seatrial.util.statistics import inverse_of

MOST_STEP_TIMES_RATE = 0.3  # step times the fastest eigenvalue: Runge-Kutta is accurate below
LEAST_INTEGRATION_STEP = 1 / 480  # [s] a shorter one costs time and changes nothing


def with_sought_stages(
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


def problem_with(
    whole: Vehicle,
    vehicle: Vehicle,
    recordings: Sequence[Recording],
    settings: OutputErrorSettings,
) -> Problem:
    """The problem with free coefficients, constants that the file does not state, and chosen effects."""
    known = set(vehicle.constants.names) - set(whole.estimated)
    problem = Problem(whole, tuple(recordings), (), settings.step, settings.outlier, settings.block)
    n, m = problem.n_coefficients, problem.n_constants
    free = [*range(n), *(n + i for i, c in enumerate(whole.constants.names) if c not in known)]
    sought = {kind for kind in settings.effects if kind != "delay"}
    delays = free_delays(vehicle, settings.effects)
    for i, name in enumerate(problem.names[n + m :], n + m):
        free += [i] if name.partition("_")[0] in sought or name in delays else []
    return replace(problem, free=tuple(free))


def free_delays(vehicle: Vehicle, effects: Sequence[str]) -> tuple[str, ...]:
    """Names of the delays to estimate: those that the vehicle file leaves open; with the effect, the position's.

    Raises IdentificationError where both are open and so is the latency of a thruster: a common delay of position
    and heading is indistinguishable from it.
    """
    position, heading = vehicle.estimated_delays
    if position and heading:
        latency = vehicle.constants.index[:, STAGES.index("latency")]
        names = [vehicle.constants.names[i] for i in latency if i >= 0]
        if (latency < 0).any() or set(names) & set(vehicle.estimated):
            raise IdentificationError(
                "pose: delay: estimate: a delay that position and heading have in common is indistinguishable "
                "from the thrusters' latency. State heading_delay (0 where the heading is not late), and the "
                "position's is estimated; or state the latency of all thrusters in the chain"
            )
    elif "delay" in effects and not heading:
        position = True
    return tuple(n for n, free in zip(DELAY_NAMES, (position, heading), strict=True) if free)


def with_prior(problem: Problem, prior: Model | None) -> Problem:
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


def start_of(
    problem: Problem, recordings: Sequence[Recording], start: StartValues | None
) -> tuple[Array, Array]:
    """Start of the search: parameters and noise."""
    n, m = problem.n_coefficients, problem.n_constants
    theta = np.zeros(len(problem.names))
    delays = [i for i in problem.free if problem.names[i] in DELAY_NAMES]
    recordings = [at_one_time(r) for r in recordings]
    if delays:
        late = _long_delay(problem, recordings)
        of_position = problem.names[delays[0]] == DELAY_NAMES[0]
        theta[delays[0]] = (late if of_position else -late) or START_DELAY
        recordings = [at_one_time(with_delays(r, late, 0.0)) for r in recordings]
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


def _long_delay(problem: Problem, recordings: Sequence[Recording]) -> float:
    """What the motion shows of a long delay [s] of positions against headings, beyond what the file states."""
    return position_delay(
        read_runs(recordings, [file_commands(problem.vehicle, r) for r in recordings])
    )


def with_start(problem: Problem, theta: Array) -> Problem:
    """The problem with what follows from start values: the integration step, the errors of sampled commands."""
    own = theta[: problem.n_coefficients]
    errors = tuple(input_errors(problem.vehicle, own, r) for r in problem.recordings)
    return replace(problem, step=integration_step(problem, theta), input_errors=errors)


def integration_step(problem: Problem, theta: Array) -> float:
    """Step [s] of the integration: the chosen one, or less where the boat's fastest eigenvalue requires it."""
    vehicle, n = problem.vehicle, problem.n_coefficients
    nu = usual_velocities(problem.recordings)
    if not len(nu):
        names = ", ".join(r.name for r in problem.recordings)
        raise IdentificationError(
            f"{names}: no five usable poses in a row at about even intervals; if they come from two "
            "trackers, use one of them"
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
