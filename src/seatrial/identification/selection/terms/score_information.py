# SPDX-License-Identifier: MIT
"""Scores and Fisher information of the terms of a model, and of terms that it lacks, from one filter run.

A Gauss-Newton step with them is a refit; the part of a lacking term's score that the others do not explain
tests it (Rao's score test). Scores are summed over blocks, within which innovations may be correlated.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.structure import Term
from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.terms.candidates import with_terms
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

SOLVE_RIDGE = 1e-12  # relative ridge: some recordings hold no information about a parameter


@dataclass(frozen=True)
class ScoreInformation:
    """Gradient and Fisher information of the free parameters, recording by recording."""

    names: tuple[str, ...]  # (p,) coefficients, then constants of the chain
    values: Array  # (p,) of the model
    bounds: tuple[Array, Array]  # (p,) each: lowest and highest
    information: Array  # (g, p, p)
    gradient: Array  # (g, p)
    scores: Array  # (blocks, p) of all recordings
    shares: Array  # (blocks, p, p) the information in each block
    recording: NDArray[np.int64]  # (blocks,) the recording of each block

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return len(self.scores)

    @cached_property
    def total(self) -> Array:
        """Information of all recordings (p, p)."""
        return np.asarray(self.information.sum(axis=0))

    def scores_after(self, step: Array) -> Array:
        """Scores (blocks, p) after a step (p,) of the parameters, by each block's own information.

        Before the step, the scores of a term that is plainly missing would count as scatter.
        """
        return np.asarray(self.scores - self.shares @ step)

    def place(self, name: str) -> int:
        """Column of a parameter."""
        return self.names.index(name)

    def only(self, names: Sequence[str]) -> "ScoreInformation":
        """The same for some parameters, the others being held."""
        at = [self.place(name) for name in names]
        return replace(
            self,
            names=tuple(names),
            values=self.values[at],
            bounds=(self.bounds[0][at], self.bounds[1][at]),
            information=self.information[np.ix_(range(len(self.information)), at, at)],
            gradient=self.gradient[:, at],
            scores=self.scores[:, at],
            shares=self.shares[np.ix_(range(self.blocks), at, at)],
        )


def score_information_of(at: Point, extra: Sequence[Term] = ()) -> ScoreInformation:
    """About a solution's free parameters, and about coefficients of further terms, which are 0 in it."""
    problem = at.runs.problem
    whole = problem_with_terms(problem, (*problem.vehicle.structure.terms, *extra))
    theta = moved(at, whole)
    runs = whole.run_filter(theta, at.noise, repeatable=False, shares=True)
    if not np.isfinite(runs.cost):
        raise IdentificationError("the boat diverges; look at the recordings with inspect")
    owner = [np.full(int(b[-1]) + 1, i) for i, b in enumerate(whole.blocks)]
    free = whole.free
    return ScoreInformation(
        tuple(whole.names[i] for i in free),
        theta[list(free)],
        whole.bounds,
        np.array([p.information for p in runs.by_recording]),
        np.array([p.gradient for p in runs.by_recording]),
        runs.scores,
        np.concatenate([p.share.reshape(-1, len(free), len(free)) for p in runs.by_recording]),
        np.concatenate(owner),
    )


def problem_with_terms(problem: Problem, terms: Sequence[Term]) -> Problem:
    """The problem with other terms, all of whose coefficients are free; of the chain the same constants are."""
    n = problem.n_coefficients
    constants = {problem.names[i] for i in problem.free if i >= n}
    wider = replace(problem, vehicle=with_terms(problem.vehicle, terms), free=())
    m = wider.n_coefficients
    free = (i for i, name in enumerate(wider.names) if i < m or name in constants)
    return replace(wider, free=tuple(free))


def moved(at: Point, problem: Problem) -> Array:
    """A solution as parameters of a problem with other terms: new coefficients are 0."""
    values = dict(zip(at.runs.problem.names, at.theta.tolist(), strict=True))
    return np.array([values.get(name, 0.0) for name in problem.names])


def solve_scaled(matrix: Array, right: Array) -> Array:
    """matrix^-1 right of a symmetric matrix, scaled to a unit diagonal, never singular."""
    scale = np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    scaled = matrix / np.outer(scale, scale) + SOLVE_RIDGE * np.eye(len(matrix))
    inner = right / scale if right.ndim == 1 else right / scale[:, None]
    found = np.linalg.solve(scaled, inner)
    return np.asarray(found / scale if right.ndim == 1 else found / scale[:, None])
