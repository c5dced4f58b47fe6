# SPDX-License-Identifier: MIT
"""Which parameters are free, and further stages of the chain that the data ask for."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.optimiser import Point, maximise_likelihood
from seatrial.identification.likelihood.problem import FilterRuns, Problem
from seatrial.identification.selection.actuator_stages import extras
from seatrial.identification.selection.score_test import ScoreTest, score_test
from seatrial.identification.solution import OutputErrorSettings
from seatrial.identification.uncertainty.covariance import sandwich_covariance
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Mask

MOST_EXTRAS = 5
WORTH = 10.0  # fall of -2 log likelihood from which on a further stage is worth having
SURELY = 2.5  # standard errors away from its neutral value, where the score test does not tell
CURVE = ("reverse_ratio", "power")
STAGES_SELECTED = (FindingKind.CURVE_STAGE_SELECTED, FindingKind.GROUP_STAGES_SELECTED)


def problem_of(
    whole: Vehicle,
    vehicle: Vehicle,
    recordings: Sequence[Recording],
    settings: OutputErrorSettings,
) -> Problem:
    """Free are the coefficients, the constants that the file does not state, chosen effects."""
    known = set(vehicle.constants.names) - set(whole.estimated)
    problem = Problem(whole, tuple(recordings), (), settings.step, settings.outlier, settings.block)
    n, m = problem.n_coefficients, problem.n_constants
    free = [*range(n), *(n + i for i, c in enumerate(whole.constants.names) if c not in known)]
    for i, name in enumerate(problem.names[n + m :], n + m):
        free += [i] if name.partition("_")[0] in settings.effects else []
    return Problem(
        whole, tuple(recordings), tuple(free), settings.step, settings.outlier, settings.block
    )


def freed(
    at: Point, vehicle: Vehicle, settings: OutputErrorSettings, share: float
) -> tuple[Point, list[Finding]]:
    """The solution with those further stages of the chain that the data ask for."""
    findings: list[Finding] = []
    for _ in range(MOST_EXTRAS):
        asked = _asked(at, vehicle, settings)
        likely = [a for a in asked if a.test.likely]
        most = max(likely, key=lambda a: a.test.gain, default=None)
        there = None if most is None else _found(at, most, settings, share)
        if there is None:
            there, most = _tried(at, asked, vehicle, settings, share)
        if there is None or most is None:
            break
        at = there
        findings += most.findings
    return at, findings


@dataclass(frozen=True)
class _Asked:
    """A stage that promises enough, and the problem with it."""

    findings: tuple[Finding, ...]  # that say so
    wider: Problem
    theta: Array  # where its search begins
    test: ScoreTest


def _asked(at: Point, vehicle: Vehicle, settings: OutputErrorSettings) -> list[_Asked]:
    """Stages that promise a fall that is worth having, be it by chance or not."""
    problem = at.runs.problem
    found = []
    runs: dict[int, FilterRuns] = {}  # of probes
    for extra in extras(vehicle, problem.vehicle, problem.recordings):
        if id(extra.probe) not in runs:
            probe = _wider(problem, extra.probe, vehicle, settings)
            start = _moved(at, probe, extra.origin)
            runs[id(extra.probe)] = probe.run_filter(start, at.noise, repeatable=False)
        wider = _wider(problem, extra.vehicle, vehicle, settings)
        test = _tested(problem, wider, runs[id(extra.probe)])
        if test.gain > WORTH:
            found.append(_Asked((extra.finding,), wider, _moved(at, wider, extra.origin), test))
    return found


def _found(at: Point, asked: _Asked, settings: OutputErrorSettings, share: float) -> Point | None:
    """The solution with it; None where there is none."""
    least = noise_floor(asked.wider, share)
    with suppress(IdentificationError):
        return maximise_likelihood(
            asked.wider, asked.theta, at.noise, hold=settings.hold_noise, least=least
        )
    return None


def _tried(
    at: Point,
    asked: Sequence[_Asked],
    vehicle: Vehicle,
    settings: OutputErrorSettings,
    share: float,
) -> tuple[Point | None, _Asked | None]:
    """A curve's stages that the score test does not tell from chance, but the fit with them does.

    Dead-zone edges that stand for a curve hide it from its scores: where several promise something, all are tried
    at once, and what is not far from its neutral value by its errors is left out.
    """
    problem = at.runs.problem
    curves = [a for a in asked if _curve(problem, a.wider)]
    tries = [*_together(at, curves, vehicle, settings), *curves]
    for one in tries:
        there = _found(at, one, settings, share)
        if there is None or not at.runs.cost - there.runs.cost > WORTH:
            continue
        far = _far(there, [i for i in one.wider.free if one.wider.names[i] not in problem.names])
        if far.all():
            return there, one
    return None, None


def _curve(problem: Problem, wider: Problem) -> bool:
    """Whether what a wider problem has more is the one curve of all actuators."""
    new = [name for name in wider.names if name not in problem.names]
    return all(name in CURVE for name in new)


def _together(
    at: Point, curves: Sequence[_Asked], vehicle: Vehicle, settings: OutputErrorSettings
) -> list[_Asked]:
    """All stages of the curve at once, if one of them promises something and there are several."""
    problem = at.runs.problem
    if not curves:
        return []
    of_curve = [e for e in extras(vehicle, problem.vehicle, problem.recordings) if not e.origin]
    wider = _wider(problem, of_curve[0].probe, vehicle, settings)
    if len(of_curve) < 2 or len(wider.free) - len(problem.free) != len(of_curve):
        return []
    findings = tuple(e.finding for e in of_curve)
    return [_Asked(findings, wider, _moved(at, wider, {}), curves[0].test)]


def _far(at: Point, new: Sequence[int]) -> Mask:
    """Whether each of some parameters is beyond chance away from 1, by errors that hold for blocks."""
    free = list(at.runs.problem.free)
    places = [free.index(i) for i in new]
    try:
        errors = np.sqrt(np.diag(sandwich_covariance(at)))[places]
    except IdentificationError:
        return np.zeros(len(places), dtype=bool)
    off = np.abs(at.theta[list(new)] - 1.0)
    return np.asarray((errors > 0.0) & (off > SURELY * errors))


def _wider(
    problem: Problem, whole: Vehicle, vehicle: Vehicle, settings: OutputErrorSettings
) -> Problem:
    """The problem of a vehicle with more stages."""
    return replace(
        problem_of(whole, vehicle, problem.recordings, settings),
        block=problem.block,
        step=problem.step,
        earth_fixed=problem.earth_fixed,
    )


def _tested(problem: Problem, wider: Problem, runs: FilterRuns) -> ScoreTest:
    """Whether what a wider problem has more deserves it, by filter runs of one that may be wider still."""
    names = [runs.problem.names[i] for i in runs.problem.free]
    known = {wider.names[i] for i in wider.free}
    neutral = [k for k, name in enumerate(names) if name not in known]
    new = [k for k, name in enumerate(names) if name in known and name not in problem.names]
    split = [k for k in new if "." in names[k]]
    return score_test(runs, [k for k in new if k not in split[:1]], split, neutral)


def _moved(at: Point, wider: Problem, origin: Mapping[str, str]) -> Array:
    """The parameters of a wider problem where they are those of the solution."""
    old = dict(zip(at.runs.problem.names, at.theta.tolist(), strict=True))
    neutral = dict(zip(wider.vehicle.constants.names, wider.vehicle.constants.values, strict=True))
    values = [
        old.get(name, old.get(origin.get(name, ""), neutral.get(name, 0.0))) for name in wider.names
    ]
    return np.array(values)
