# SPDX-License-Identifier: MIT
"""Actuator-stage selection: further stages of the chain, stepwise by score tests and fits."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from seatrial.boat.findings import Finding
from seatrial.boat.noise_parameters import present
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.optimiser import Outcome, Point, search
from seatrial.identification.likelihood.problem import FilterRuns, Problem
from seatrial.identification.problem_setup import problem_with
from seatrial.identification.selection.actuator_stages import stage_candidates
from seatrial.identification.selection.held import Held, held_test
from seatrial.identification.selection.score_test import manifest
from seatrial.identification.solution import OutputErrorSettings
from seatrial.util.frames import Array

MOST_SELECTED = 5  # stages: the steps end before in practice


def select_stages(
    at: Point, vehicle: Vehicle, settings: OutputErrorSettings, horizon: float
) -> tuple[Point, list[Finding]]:
    """The solution with further significant stages of the chain, and a finding on each."""
    findings: list[Finding] = []
    for _ in range(MOST_SELECTED):
        # score tests of all candidates; the significant one with the largest expected gain is fitted
        candidates = _candidates(at, vehicle, settings)
        passed = manifest([a.test for a in candidates])
        likely = [a for a, good in zip(candidates, passed, strict=True) if good]
        most = max(likely, key=lambda a: a.test.gain, default=None)
        there = None if most is None else _fitted(at, most, settings, horizon)
        if there is None or most is None:
            break
        at = there
        findings += most.findings(at.theta)
    return at, findings


def _candidates(at: Point, vehicle: Vehicle, settings: OutputErrorSettings) -> list[Held]:
    """All further stages that the commands identify, with their tests."""
    problem = at.runs.problem
    found = []
    runs: dict[int, FilterRuns] = {}  # of probes
    for extra in stage_candidates(vehicle, problem.vehicle, problem.recordings):
        if id(extra.probe) not in runs:
            probe = _wider(problem, extra.probe, vehicle, settings)
            start = _moved(at, probe, extra.origin)
            runs[id(extra.probe)] = probe.run_filter(start, at.noise, repeatable=False)
        wider = _wider(problem, extra.vehicle, vehicle, settings)
        test = held_test(runs[id(extra.probe)], problem, wider)
        begin = _moved(at, wider, extra.origin)
        found.append(Held(test, wider, begin, partial(_told, (extra.finding,))))
    return found


def _told(findings: tuple[Finding, ...], _: Array) -> tuple[Finding, ...]:
    return findings


def _fitted(
    at: Point, candidate: Held, settings: OutputErrorSettings, horizon: float
) -> Point | None:
    """The solution with a candidate; None where there is none."""
    # no further noise sources: else they count as the stage's gain
    found, outcome = search(
        candidate.problem, candidate.theta, at.noise, hold=settings.hold_noise,
        least=noise_floor(candidate.problem, horizon), free=present(at.noise),
    )  # fmt: skip
    return found if outcome is Outcome.CONVERGED else None


def _wider(
    problem: Problem, whole: Vehicle, vehicle: Vehicle, settings: OutputErrorSettings
) -> Problem:
    """The problem of a vehicle with more stages."""
    return replace(
        problem_with(whole, vehicle, problem.recordings, settings),
        block=problem.block,
        step=problem.step,
        earth_fixed=problem.earth_fixed,
    )


def _moved(at: Point, wider: Problem, origin: Mapping[str, str]) -> Array:
    """The solution as parameters of a wider problem, further stages at their neutral values."""
    old = dict(zip(at.runs.problem.names, at.theta.tolist(), strict=True))
    neutral = dict(zip(wider.vehicle.constants.names, wider.vehicle.constants.values, strict=True))
    values = [
        old.get(name, old.get(origin.get(name, ""), neutral.get(name, 0.0))) for name in wider.names
    ]
    return np.array(values)
