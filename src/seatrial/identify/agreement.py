# SPDX-License-Identifier: MIT
"""Whether recordings agree: thrust, drag or mass of one that is not that of the others.

A battery that falls from drive to drive makes thrust weaker, a payload that is taken in between makes the
boat heavier. One model for all is then that of none, and its errors do not say so. A factor for each
recording on an axis' thrust, on its drag, or on both, is tested by its score at the solution, where all are
1: what blocks of time scatter about is chance. No pass is needed for that.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.frames import AXES, Array
from seatrial.identify.score_test import ScoreTest, score_test
from seatrial.identify.search import Point
from seatrial.structure import Structure

WORTH = 20.0  # fall of -2 log likelihood from which on factors are worth a word
SHARP = 0.05  # standard error of a factor, by the information, above which a recording says nothing of it
LEAST = 0.03  # between factors: less is nothing to speak of
CAUSES = {
    "thrust": "did the battery fall, or trim change?",
    "drag": "did the water change, or what hangs into it?",
    "thrust and drag": "did the payload change?",
}


@dataclass(frozen=True)
class _Factors:
    """Passes as they were if a factor for each of some recordings were free, too."""

    information: Array  # (p + k, p + k)
    scores: Array  # (blocks, p + k)


@dataclass(frozen=True)
class Disagreement:
    """A factor that differs from recording to recording."""

    axis: int
    what: str  # of CAUSES
    low: int  # the recording where it is least
    high: int
    ratio: float  # of these two
    test: ScoreTest


def disagreements(at: Point) -> list[str]:
    """What is to be said where recordings are of different boats; nothing where chance explains it."""
    found = [max(own, key=lambda d: d.test.gain) for axis in range(3) if (own := _of(at, axis))]
    if not found:
        return []
    names = [r.name for r in at.passes.problem.recordings]
    said = [
        _said(what, same, names)
        for what in CAUSES
        if (same := [d for d in found if d.what == what])
    ]
    return [
        f"the recordings do not agree: {' '.join(said)} To see, identify them apart, and take compare"
    ]


def _said(what: str, found: list[Disagreement], names: list[str]) -> str:
    """Of disagreements about one thing in words."""
    where = [
        f"in {AXES[d.axis]} {100.0 * (1.0 - d.ratio):.0f} % less in {names[d.low]} than in {names[d.high]}"
        for d in found
    ]
    return f"{what} {', '.join(where)}: {CAUSES[what]}"


def _of(at: Point, axis: int) -> list[Disagreement]:
    found = (_tested(at, axis, what, weights) for what, weights in _ways(at, axis))
    return [one for one in found if one is not None]


def _ways(at: Point, axis: int) -> Iterator[tuple[str, Array]]:
    """What changes, and how the free parameters (p,) would with a factor on it: as much as they are."""
    problem = at.passes.problem
    thrust, drag = _terms(problem.vehicle.structure, axis)
    free = np.array(problem.free)
    for what, names in (("thrust", thrust), ("drag", drag), ("thrust and drag", thrust | drag)):
        own = np.array([problem.names[i] in names for i in free])
        yield what, np.where(own, at.theta[free], 0.0)


def _terms(structure: Structure, axis: int) -> tuple[set[str], set[str]]:
    """Coefficients of an axis' terms with a force, and of those with velocities only."""
    forces = {force.name for force in structure.forces}
    thrust: set[str] = set()
    drag: set[str] = set()
    for term in structure.terms:
        if term.axis == axis and term.coefficient is not None and term.acceleration is None:
            (thrust if forces & set(term.factors) else drag).add(term.coefficient)
    return thrust, drag


def _tested(at: Point, axis: int, what: str, weights: Array) -> Disagreement | None:
    problem, passes = at.passes.problem, at.passes
    if problem.prior is not None or not weights.any():
        return None
    p, known, columns, scores = len(problem.free), [], [], []
    for i, each in enumerate(passes.each):
        to = problem.places(i)
        own = np.where(to >= 0, weights[to], 0.0)
        across = np.zeros(p)
        across[to[to >= 0]] = (np.asarray(each.information) @ own)[to >= 0]
        if weights @ across > SHARP**-2:
            known.append(i)
            columns.append(across)
        scores.append(np.asarray(each.score) @ own)
    k = len(known)
    if k < 2:
        return None
    wide = np.zeros((p + k, p + k))
    wide[:p, :p] = passes.information
    wide[:p, p:] = np.array(columns).T
    wide[p:, :p] = wide[:p, p:].T
    wide[p:, p:] = np.diag(np.array(columns) @ weights)
    ends = np.cumsum([len(s) for s in scores])
    blocks = np.zeros((ends[-1], k))
    for j, i in enumerate(known):
        blocks[ends[i] - len(scores[i]) : ends[i], j] = scores[i]
    tested = list(range(p + 1, p + k))  # one for all is in the coefficients
    test = score_test(_Factors(wide, np.hstack([passes.scores, blocks])), tested, neutral=[p])
    factors = np.concatenate([[1.0], 1.0 + test.step])
    low, high = int(np.argmin(factors)), int(np.argmax(factors))
    ratio = float(max(factors[low], 0.0) / factors[high])
    if not test.manifest or test.gain < WORTH or ratio > 1.0 - LEAST:
        return None
    return Disagreement(axis, what, known[low], known[high], ratio, test)
