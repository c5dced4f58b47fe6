# SPDX-License-Identifier: MIT
"""Actuator-stage selection: further stages of the chain, stepwise by score tests and fits."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from seatrial.boat.actuators import BOUNDS, STARTS
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.noise_parameters import present
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.likelihood.filter_runs import FilterRuns, filter_along
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import Outcome, at_bounds, search
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.whiteness import without_process_noise
from seatrial.identification.problem_setup import problem_with
from seatrial.identification.selection.actuator_stages import stage_candidates, with_slew_stage
from seatrial.identification.selection.held import Held, held_test
from seatrial.identification.selection.score_test import REPORTED_GAIN
from seatrial.identification.solution import OutputErrorSettings
from seatrial.identification.uncertainty.covariance import sandwich_covariance
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Mask

MOST_SELECTED = 5  # stages: the steps end before in practice
LEAST_STAGE_GAIN = 10.0  # fall of -2 log L: less is not worth a parameter
LEAST_DISTANCE = 2.5  # [standard errors] from the neutral value, where the score test has no power
CURVE_STAGES = ("reverse_ratio", "power")


def select_stages(
    at: Point, vehicle: Vehicle, settings: OutputErrorSettings, horizon: float
) -> tuple[Point, list[Finding]]:
    """The solution with further significant stages of the chain, and a finding on each."""
    findings: list[Finding] = []
    limited = with_slew_rate(at, vehicle, settings, horizon)
    if limited is not None:
        findings, at = [slew_finding(at, limited)], limited
    for _ in range(MOST_SELECTED):
        # score tests of all candidates; the simplest significant one is fitted, of equals the one that gains most
        candidates = _candidates(at, vehicle, settings)
        likely = [a for a in candidates if a.test.likely]
        most = max(likely, key=lambda a: (-a.test.freedom, a.test.gain), default=None)
        there = None if most is None else _fitted(at, most.problem, most.theta, settings, horizon)
        # a curve that dead-zone edges hide from its score test is found by a fit
        if there is None:
            there, most = _by_fit(at, candidates, vehicle, settings, horizon)
        if there is None or most is None:
            break
        at = there
        findings += most.findings(at.theta)
    return at, findings


def with_slew_rate(
    at: Point, vehicle: Vehicle, settings: OutputErrorSettings, horizon: float = 0.0
) -> Point | None:
    """The solution with a slew rate of all thrusters; None where it explains no process noise.

    Its neutral value is infinite, where a score test has no power, so it is fitted.
    """
    problem = at.runs.problem
    whole = with_slew_stage(vehicle, problem.vehicle)
    if whole is None or without_process_noise(at):
        return None
    wider = wider_problem(problem, whole, vehicle, settings)
    there = _fitted(at, wider, _with_ramp_for_lag(at, wider), settings, horizon)
    if there is None or at.runs.cost - there.runs.cost < REPORTED_GAIN:
        return None
    return None if at_bounds(there)[_place(there, "slew_rate")] else there


def _with_ramp_for_lag(at: Point, wider: Problem) -> Array:
    """Parameters in which a ramp stands for the lag: that of a full step has the lag as its mean delay."""
    theta = moved_to(at, wider, {})
    rate, lag = (wider.names.index(n) if n in wider.names else None for n in ("slew_rate", "lag"))
    if rate is not None and lag in wider.free:
        least, most = BOUNDS["slew_rate"]
        theta[rate] = np.clip(0.5 / theta[lag], 2.0 * least, 0.5 * most)
        theta[lag] = STARTS["lag"]
    return theta


def slew_finding(at: Point, there: Point) -> Finding:
    """That thrust follows its commands at a limited rate."""
    rate = float(there.theta[there.runs.problem.names.index("slew_rate")])
    gain = at.runs.cost - there.runs.cost
    return finding_of(FindingKind.SLEW_RATE_SELECTED, rate=rate, gain=gain)


def _place(at: Point, name: str) -> int:
    """Where a parameter stands among the free ones."""
    problem = at.runs.problem
    return problem.free.index(problem.names.index(name))


def _candidates(at: Point, vehicle: Vehicle, settings: OutputErrorSettings) -> list[Held]:
    """Stages with an expected gain above `LEAST_STAGE_GAIN`, significant or not."""
    problem = at.runs.problem
    found = []
    runs: dict[int, FilterRuns] = {}  # of probes
    for extra in stage_candidates(vehicle, problem.vehicle):
        if id(extra.probe) not in runs:
            probe = wider_problem(problem, extra.probe, vehicle, settings)
            start = moved_to(at, probe, extra.origin)
            runs[id(extra.probe)] = filter_along(probe, start, at.noise, repeatable=False)
        wider = wider_problem(problem, extra.vehicle, vehicle, settings)
        test = held_test(runs[id(extra.probe)], problem, wider)
        if test.gain > LEAST_STAGE_GAIN:
            begin = moved_to(at, wider, extra.origin)
            found.append(Held(test, wider, begin, partial(_told, (extra.finding,))))
    return found


def _told(findings: tuple[Finding, ...], _: Array) -> tuple[Finding, ...]:
    return findings


def _fitted(
    at: Point, problem: Problem, theta: Array, settings: OutputErrorSettings, horizon: float
) -> Point | None:
    """The solution of a wider problem from parameters `theta`; None where there is none."""
    # no further noise sources: else they count as the stage's gain
    found, outcome = search(
        problem, theta, at.noise, hold=settings.hold_noise,
        least=noise_floor(problem, horizon), free=present(at.noise),
    )  # fmt: skip
    return found if outcome is Outcome.CONVERGED else None


def _by_fit(
    at: Point,
    candidates: Sequence[Held],
    vehicle: Vehicle,
    settings: OutputErrorSettings,
    horizon: float,
) -> tuple[Point | None, Held | None]:
    """Stages of the curve without a significant score test, but with a significant estimate.

    Dead-zone edges that stand for a curve hide it from its scores. So all of its candidates are fitted together,
    then each alone; every new stage must be `LEAST_DISTANCE` standard errors from its neutral value.
    """
    problem = at.runs.problem
    curves = [a for a in candidates if _is_curve(problem, a.problem)]
    tries = [*_whole_curve(at, curves, vehicle, settings), *curves]
    for one in tries:
        there = _fitted(at, one.problem, one.theta, settings, horizon)
        if there is None or not at.runs.cost - there.runs.cost > LEAST_STAGE_GAIN:
            continue
        far = _significant(
            there, [i for i in one.problem.free if one.problem.names[i] not in problem.names]
        )
        if far.all():
            return there, one
    return None, None


def _is_curve(problem: Problem, wider: Problem) -> bool:
    """Whether the further stages of a wider problem are those of the curve that all actuators have."""
    new = [name for name in wider.names if name not in problem.names]
    return all(name in CURVE_STAGES for name in new)


def _whole_curve(
    at: Point, curves: Sequence[Held], vehicle: Vehicle, settings: OutputErrorSettings
) -> list[Held]:
    """All stages of the curve at once, if there are several and one is a candidate."""
    problem = at.runs.problem
    if not curves:
        return []
    of_curve = [e for e in stage_candidates(vehicle, problem.vehicle) if not e.origin]
    wider = wider_problem(problem, of_curve[0].probe, vehicle, settings)
    if len(of_curve) < 2 or len(wider.free) - len(problem.free) != len(of_curve):
        return []
    findings = tuple(e.finding for e in of_curve)
    return [Held(curves[0].test, wider, moved_to(at, wider, {}), partial(_told, findings))]


def _significant(at: Point, new: Sequence[int]) -> Mask:
    """Whether each of some parameters differs from 1 by `LEAST_DISTANCE` sandwich standard errors."""
    free = list(at.runs.problem.free)
    places = [free.index(i) for i in new]
    off = np.abs(at.theta[list(new)] - 1.0)
    far = np.zeros(len(places), dtype=bool)
    # parameters that may be off a bound widen the errors, by filter passes: last
    for inside in (~at_bounds(at), None):
        try:
            errors = np.sqrt(np.diag(sandwich_covariance(at, inside)))[places]
        except IdentificationError:
            return np.zeros(len(places), dtype=bool)
        far = np.asarray((errors > 0.0) & (off > LEAST_DISTANCE * errors))
        if not far.all():
            break
    return far


def wider_problem(
    problem: Problem, whole: Vehicle, vehicle: Vehicle, settings: OutputErrorSettings
) -> Problem:
    """The problem of a vehicle with more stages."""
    return replace(
        problem_with(whole, vehicle, problem.recordings, settings),
        block=problem.block,
        step=problem.step,
        input_errors=problem.input_errors,
        earth_fixed=problem.earth_fixed,
        whole_period=problem.whole_period,
    )


def moved_to(at: Point, wider: Problem, origin: Mapping[str, str]) -> Array:
    """The solution as parameters of a wider problem, further stages at their neutral values."""
    old = dict(zip(at.runs.problem.names, at.theta.tolist(), strict=True))
    neutral = dict(zip(wider.vehicle.constants.names, wider.vehicle.constants.values, strict=True))
    values = [
        old.get(name, old.get(origin.get(name, ""), neutral.get(name, 0.0))) for name in wider.names
    ]
    return np.array(values)
