# SPDX-License-Identifier: MIT
"""Which parameters are free, and further stages of the chain that the data ask for."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from seatrial.frames import Array
from seatrial.identify.belief import least_noise
from seatrial.identify.problem import Passes, Problem
from seatrial.identify.score_test import ScoreTest, score_test
from seatrial.identify.search import Point, search
from seatrial.identify.solution import OutputErrorSettings
from seatrial.identify.stages import extras
from seatrial.recording import Recording
from seatrial.vehicle import Vehicle

MOST_EXTRAS = 5
WORTH = 20.0  # fall of -2 log likelihood from which on a further stage is worth having


def problem_of(
    whole: Vehicle,
    vehicle: Vehicle,
    recordings: Sequence[Recording],
    settings: OutputErrorSettings,
) -> Problem:
    """Free are the coefficients, the constants that the file does not state, chosen effects."""
    known = set(vehicle.constants.names) - set(whole.estimated)
    problem = Problem(whole, tuple(recordings), (), settings.step, settings.outlier, settings.block)
    n, m = problem.size, problem.constants
    free = [*range(n), *(n + i for i, c in enumerate(whole.constants.names) if c not in known)]
    for i, name in enumerate(problem.names[n + m :], n + m):
        free += [i] if name.partition("_")[0] in settings.effects else []
    return Problem(
        whole, tuple(recordings), tuple(free), settings.step, settings.outlier, settings.block
    )


def freed(
    at: Point, vehicle: Vehicle, settings: OutputErrorSettings, share: float
) -> tuple[Point, list[str]]:
    """The solution with those further stages of the chain that the data ask for; said in words."""
    notes: list[str] = []
    for _ in range(MOST_EXTRAS):
        problem = at.passes.problem
        found = []
        passes: dict[int, Passes] = {}  # of probes
        for extra in extras(vehicle, problem.vehicle, problem.recordings):
            if id(extra.probe) not in passes:
                probe = _wider(problem, extra.probe, vehicle, settings)
                start = _moved(at, probe, extra.origin)
                passes[id(extra.probe)] = probe.passes(start, at.noise, repeatable=False)
            wider = _wider(problem, extra.vehicle, vehicle, settings)
            test = _tested(problem, wider, passes[id(extra.probe)])
            if test.likely and test.gain > WORTH:
                found.append((test.gain, extra.words, wider, _moved(at, wider, extra.origin)))
        if not found:
            break
        _, words, wider, theta = max(found, key=lambda f: f[0])
        least = least_noise(wider, share)
        at = search(wider, theta, at.noise, hold=settings.hold_noise, least=least)
        notes.append(f"{words}: estimated, as the data ask for it")
    return at, notes


def _wider(
    problem: Problem, whole: Vehicle, vehicle: Vehicle, settings: OutputErrorSettings
) -> Problem:
    """The problem of a vehicle with more stages."""
    return replace(
        problem_of(whole, vehicle, problem.recordings, settings),
        block=problem.block,
        step=problem.step,
    )


def _tested(problem: Problem, wider: Problem, passes: Passes) -> ScoreTest:
    """Whether what a wider problem has more deserves it, by passes of one that may be wider still."""
    names = [passes.problem.names[i] for i in passes.problem.free]
    known = {wider.names[i] for i in wider.free}
    neutral = [k for k, name in enumerate(names) if name not in known]
    new = [k for k, name in enumerate(names) if name in known and name not in problem.names]
    split = [k for k in new if "." in names[k]]
    return score_test(passes, [k for k in new if k not in split[:1]], split, neutral)


def _moved(at: Point, wider: Problem, origin: Mapping[str, str]) -> Array:
    """The parameters of a wider problem where they are those of the solution."""
    old = dict(zip(at.passes.problem.names, at.theta.tolist(), strict=True))
    neutral = dict(zip(wider.vehicle.constants.names, wider.vehicle.constants.values, strict=True))
    values = [
        old.get(name, old.get(origin.get(name, ""), neutral.get(name, 0.0))) for name in wider.names
    ]
    return np.array(values)
