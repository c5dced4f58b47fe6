# SPDX-License-Identifier: MIT
"""Unmodelled effects: score tests of lever arm, delay, current, trim, wind, thruster gains and heading offset."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from seatrial import _core
from seatrial.boat.finding_kinds import UNMODELLED_EFFECTS
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.noise_parameters import COLOUR, DISTURBANCES, PROCESS, noise_units
from seatrial.identification.diagnostics.heading_drift import (
    HeadingDrift,
    drift_findings,
    likelier_drift,
)
from seatrial.identification.diagnostics.heading_jump import likelier_jump
from seatrial.identification.diagnostics.heading_offset import (
    heading_findings,
    likelier_deviation,
    likelier_heading,
)
from seatrial.identification.diagnostics.thruster_gains import with_gains
from seatrial.identification.diagnostics.uneven_current import uneven_current
from seatrial.identification.likelihood.filter_runs import FilterRuns, filter_along
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.linearised import Point, linearised_optimum, noise_box
from seatrial.identification.likelihood.optimiser import Outcome, has_correlated_poses, search
from seatrial.identification.likelihood.parameters import EFFECT_KINDS
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.whiteness import without_process_noise
from seatrial.identification.selection.held import Held, held_test
from seatrial.identification.selection.score_test import (
    LARGE_GAIN,
    REPORTED_GAIN,
    ScoreTest,
    beyond_chance,
)
from seatrial.identification.uncertainty.covariance import sandwich_covariance
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

EFFECTS_FOUND = (
    *UNMODELLED_EFFECTS.values(),
    FindingKind.UNEVEN_CURRENT,
    FindingKind.COMPASS_DEVIATION,
    FindingKind.HEADING_DRIFT,
    FindingKind.HEADING_JUMP,
    FindingKind.UNEQUAL_THRUSTER_GAINS,
)
MOST_NOISE_LEFT = 0.5  # of the process noise: an effect that leaves more may stand for another
LEAST_DELAY = 0.03  # [s] of position against heading: a shorter one is of no account
MOVED_ERRORS = 0.5  # standard errors by which an effect that matters moves a coefficient
NEGLIGIBLE_NOISE = 0.1  # of the unit of a disturbance force: less does not matter
EFFECT_SIZES: dict[str, Callable[[Array], float]] = {  # of the effects that have one
    "lever": lambda s: float(np.hypot(*s)),  # [m]
    "current": lambda s: float(np.hypot(*s.reshape(-1, 2).T).max()),  # [m/s] the largest
    "delay": lambda s: float(np.abs(s).max()),  # [s]
}


@dataclass(frozen=True)
class Unmodelled:
    """What the model lacks, and the solution with it."""

    findings: tuple[Finding, ...]
    kind: str = ""  # of `EFFECT_KINDS`; empty: no effect of that kind
    at: Point | None = None  # the likelihood's maximum with the effect


def unmodelled_effect(at: Point, horizon: float, covariance: Array) -> Unmodelled:
    """The effect with the largest expected gain, if it removes most of the process noise or moves a coefficient.

    horizon: [s] of the fit under model mismatch; covariance: (p, p) of the free parameters.
    """
    # without process noise nothing is missing; but pose noise or a mismatch may hide a delay or a jump
    jump = likelier_jump(at, mismatch=horizon > 0.0)
    if without_process_noise(at) and jump is None:
        hidden = has_correlated_poses(at.noise) or horizon > 0.0
        delayed = _with_effects(at, ["delay"]) if hidden else None
        candidates = [] if delayed is None else _effects(at, delayed, ["delay"])
        return _best_fitted(at, candidates, horizon, covariance)
    # a score test for each effect; the heading's offset has a parabola of its own
    runs = _with_effects(at, EFFECT_KINDS)
    candidates, off = [*_effects(at, runs, EFFECT_KINDS), *_unequal_gains(at)], likelier_heading(at)
    most = max((a.test.gain for a in candidates), default=0.0)  # errors have bounds of their own
    # errors that vary with place, heading or time are no effect to be estimated
    errors = (uneven_current(runs), likelier_deviation(at), likelier_drift(at), jump)
    varying = [one for one in errors if one is not None]
    largest = max(varying, key=lambda one: one.gain, default=None)
    if largest is not None and largest.gain > max(most, 0.0 if off is None else off.gain):
        if isinstance(largest, HeadingDrift):
            floor = noise_floor(at.runs.problem, horizon)
            return Unmodelled(tuple(drift_findings(at, largest, floor)))
        return Unmodelled(tuple(largest.findings))
    if off is not None and off.gain > max(LARGE_GAIN, most):
        return Unmodelled(tuple(heading_findings(at, off, noise_floor(off.problem, horizon))))
    return _best_fitted(at, candidates, horizon, covariance)


def _best_fitted(
    at: Point, candidates: Sequence[Held], horizon: float, covariance: Array
) -> Unmodelled:
    """Fits the best candidate; a finding if it reduces the process noise or moves a coefficient by enough."""
    if not candidates:
        return Unmodelled(())
    # the best is estimated if it matters by its pass' linearisation
    most = max(candidates, key=lambda a: a.test.gain)
    least = noise_floor(at.runs.problem, horizon)
    assert most.runs is not None  # all of these have a pass
    begin = Point(most.theta, at.noise, most.runs)
    promise = linearised_optimum(begin, noise_box(most.problem, at.noise, least))
    matters = _removes_process_noise(at, promise.noise) or (
        most.kind == "delay" and (_removes_correlation(at.noise, promise.noise) or horizon > 0.0)
    )
    moves = horizon == 0.0 and _moves_a_coefficient(at, covariance, promise.move)
    if not (matters or moves):
        return Unmodelled(())
    theta = most.theta + promise.move
    there, outcome = search(most.problem, theta, promise.noise, least=least)
    if outcome is not Outcome.CONVERGED:
        return Unmodelled(())
    own = [i for i in effect_places(there.runs.problem, most.kind) if i in there.runs.problem.free]
    if most.kind and not differs_from_zero(there, own):
        return Unmodelled(())
    return Unmodelled(tuple(most.findings(there.theta)), most.kind, there)


def _with_effects(at: Point, kinds: Sequence[str]) -> FilterRuns:
    """A pass at the solution with effects of some kinds among the free parameters."""
    problem = at.runs.problem
    every = [i for kind in kinds for i in effect_places(problem, kind)]
    new = [i for i in every if i not in problem.free]
    wider = replace(problem, free=(*problem.free, *new))
    return filter_along(wider, at.theta, at.noise, shares=True)


def _effects(at: Point, runs: FilterRuns, kinds: Sequence[str]) -> list[Held]:
    """Effects of some kinds that are not estimated, but have a significant score test; `runs` are with them."""
    problem = at.runs.problem
    places = [(kind, own) for kind in kinds for own in _tested_places(problem, kind)]
    new = [(kind, own) for kind, own in places if not set(own) & set(problem.free)]
    candidates = []
    for kind, own in new:
        with_it = replace(problem, free=(*problem.free, *own))
        test = held_test(runs, problem, with_it, after_step=True)
        if not _significant(test):
            continue
        if kind == "delay" and np.abs(test.step).max() < LEAST_DELAY:
            continue
        there = FilterRuns(with_it, at.theta, runs.by_recording)
        found = partial(_effect_found, kind, list(own))
        candidates.append(Held(test, with_it, at.theta, found, there, kind))
    return candidates


def _tested_places(problem: Problem, kind: str) -> Iterator[tuple[int, ...]]:
    """Parameters of an effect that are tested together; of wind also the force alone: fewer show less wind."""
    yield (every := effect_places(problem, kind))
    if kind == "wind":
        yield tuple(i for i in every if problem.names[i].startswith(("wind_x", "wind_y")))


def _effect_found(kind: str, places: list[int], theta: Array) -> list[Finding]:
    sizes = {"size": EFFECT_SIZES[kind](theta[places])} if kind in EFFECT_SIZES else {}
    return [finding_of(UNMODELLED_EFFECTS[kind], **sizes)]


def _unequal_gains(at: Point) -> list[Held]:
    """Unequal thruster gains, if their score test is significant."""
    wider = with_gains(at.runs.problem, at.theta)
    if wider is None:
        return []
    runs = filter_along(wider.problem, wider.theta, at.noise, shares=True)
    test = held_test(runs, at.runs.problem, wider.problem, after_step=True)
    if not _significant(test):
        return []
    return [Held(test, wider.problem, wider.theta, wider.findings, runs)]


def _significant(test: ScoreTest) -> bool:
    return test.gain > REPORTED_GAIN and beyond_chance(test.statistic, test.freedom)


def differs_from_zero(at: Point, parameters: Sequence[int]) -> bool:
    """Whether estimated effects (indices among all parameters) differ from zero beyond chance, by a Wald test.

    The score test uses the noise of the model without the effect, which may contain other effects.
    """
    own = [at.runs.problem.free.index(i) for i in parameters]
    value = at.theta[list(parameters)]
    try:
        covariance = sandwich_covariance(at)[np.ix_(own, own)]
    except IdentificationError:
        return False
    statistic = float(value @ np.linalg.pinv(covariance, hermitian=True) @ value)
    return beyond_chance(statistic, len(own))


def _removes_process_noise(at: Point, after: Array) -> bool:
    """Whether the process noise of the linear or the angular motion falls below `MOST_NOISE_LEFT`."""
    old, new = (np.hypot(n[PROCESS][:2], n[DISTURBANCES]) for n in (at.noise, after))
    there = old > NEGLIGIBLE_NOISE * noise_units(at.noise, at.runs.problem.period)[DISTURBANCES]
    return bool((new < MOST_NOISE_LEFT * old)[there].any())


def _removes_correlation(before: Array, after: Array) -> bool:
    """Whether the correlated noise of positions or headings falls below `MOST_NOISE_LEFT`."""
    there = before[COLOUR] > _core.NO_COLOUR
    return bool((after[COLOUR] < MOST_NOISE_LEFT * before[COLOUR])[there].any())


def _moves_a_coefficient(at: Point, covariance: Array, move: Array) -> bool:
    """Whether a step (names,) moves a coefficient by `MOVED_ERRORS` of its standard errors."""
    free = np.array(at.runs.problem.free)
    errors = np.sqrt(np.diag(covariance))
    own = (free < at.runs.problem.n_coefficients) & (errors > 0.0)
    return bool((np.abs(move[free]) > MOVED_ERRORS * errors)[own].any())


def effect_places(problem: Problem, kind: str) -> tuple[int, ...]:
    """Where effects of a kind stand among all parameters; the heading's delay is held for the position's."""
    first = problem.n_coefficients + problem.n_constants
    return tuple(
        i
        for i, n in enumerate(problem.names)
        if i >= first and n.partition("_")[0] == kind and n != "delay_heading"
    )
