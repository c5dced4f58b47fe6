# SPDX-License-Identifier: MIT
"""Effects that nobody asked for but the data do: a score test of each kind, and of what is like them."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from seatrial.boat.finding_kinds import UNMODELLED_EFFECTS
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.noise_parameters import DISTURBANCES, PROCESS, RAISED
from seatrial.identification.diagnostics.heading_offset import askew, askew_said
from seatrial.identification.diagnostics.thruster_gains import with_gains
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.optimiser import Point, maximise_likelihood
from seatrial.identification.likelihood.problem import EFFECT_KINDS, Problem
from seatrial.identification.likelihood.whiteness import without_process_noise
from seatrial.identification.selection.score_test import LARGE_GAIN, ScoreTest, score_test
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

EFFECTS_FOUND = (*UNMODELLED_EFFECTS.values(), FindingKind.UNEQUAL_THRUSTER_GAINS)
WORTH = 20.0  # fall of -2 log likelihood from which on an effect is worth a word
GONE = 0.5  # of what pushes the boat must be left at most
LEAST_GAIN = 0.2  # where a search begins
CLEAR = 5.0  # standard deviations of chi-square, then
SIZES: dict[str, Callable[[Array], float]] = {  # of the effects that have one
    "lever": lambda s: float(np.hypot(*s)),  # [m]
    "current": lambda s: float(np.hypot(*s.reshape(-1, 2).T).max()),  # [m/s] the largest
}


@dataclass(frozen=True)
class _Asked:
    """What a score test asks for: the problem with it, where its search begins, and its findings."""

    gain: float  # fall of -2 log likelihood that it promises
    problem: Problem
    theta: Array
    findings: Callable[[Array], list[Finding]]  # of the parameters that are found


def hints(at: Point, share: float) -> list[Finding]:
    """The effect that the data ask for most, among those that are not sought.

    It is looked for only where something acts that the model does not say, and tried. `share`: how
    closely the model is believed.
    """
    if without_process_noise(at):
        return []
    asked, off = [*_effects(at), *_unlike(at)], askew(at)
    if off is not None and off.gain > max([LARGE_GAIN, *(a.gain for a in asked)]):
        return askew_said(at, off, noise_floor(off.problem, share))
    if not asked:
        return []
    most = max(asked, key=lambda a: a.gain)
    least = noise_floor(most.problem, share)
    try:
        there = maximise_likelihood(most.problem, most.theta, at.noise, least=least)
    except IdentificationError:
        return []
    if not _quieter(at.noise, there.noise):
        return []
    return most.findings(there.theta)


def _effects(at: Point) -> list[_Asked]:
    """Effects that nobody seeks but the data ask for."""
    problem = at.runs.problem
    places = {kind: _places(problem, kind) for kind in EFFECT_KINDS}
    new = {kind: own for kind, own in places.items() if not set(own) & set(problem.free)}
    if not new:
        return []
    wider = replace(problem, free=(*problem.free, *sum(new.values(), ())))
    runs = wider.run_filter(at.theta, at.noise, repeatable=False)
    asked = []
    for kind, own in new.items():
        tested = [wider.free.index(i) for i in own]
        others = set(range(len(problem.free), len(wider.free))) - set(tested)
        test = score_test(runs, tested, neutral=sorted(others))
        if not _asked_for(test):
            continue
        theta = at.theta.copy()
        theta[list(own)] = test.step
        with_it = replace(problem, free=(*problem.free, *own))
        asked.append(_Asked(test.gain, with_it, theta, partial(_effect_found, kind, list(own))))
    return asked


def _effect_found(kind: str, places: list[int], theta: Array) -> list[Finding]:
    sizes = {"size": SIZES[kind](theta[places])} if kind in SIZES else {}
    return [finding_of(UNMODELLED_EFFECTS[kind], **sizes)]


def _unlike(at: Point) -> list[_Asked]:
    """Thrusters that do not thrust alike, if the data ask for that."""
    wider = with_gains(at.runs.problem, at.theta)
    if wider is None:
        return []
    runs = wider.problem.run_filter(wider.theta, at.noise, repeatable=False)
    test = score_test(runs, [wider.problem.free.index(i) for i in wider.places])
    if not _asked_for(test):
        return []
    theta = wider.theta.copy()
    theta[list(wider.places)] = np.maximum(1.0 + test.step, LEAST_GAIN)
    return [_Asked(test.gain, wider.problem, theta, wider.findings)]


def _asked_for(test: ScoreTest) -> bool:
    likely = test.statistic > test.freedom + CLEAR * np.sqrt(2.0 * test.freedom)
    return bool(likely and test.gain > WORTH)


def _quieter(before: Array, after: Array) -> bool:
    """Whether what pushes the boat, of the linear or the angular motion, is half gone: an effect that
    explains less may stand for another."""
    old, new = (np.hypot(n[PROCESS][:2], n[DISTURBANCES]) for n in (before, after))
    there = old > RAISED[DISTURBANCES]
    return bool((new < GONE * old)[there].any())


def _places(problem: Problem, kind: str) -> tuple[int, ...]:
    """Where effects of a kind stand among all parameters."""
    first = problem.n_coefficients + problem.n_constants
    return tuple(
        i for i, n in enumerate(problem.names) if i >= first and n.partition("_")[0] == kind
    )
