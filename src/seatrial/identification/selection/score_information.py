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
from seatrial.identification.likelihood.filter_runs import FilterRuns, filter_along
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.problem import Problem
from seatrial.util.box import box_minimum
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array


@dataclass(frozen=True)
class ScoreInformation:
    """Gradient and Fisher information of the free parameters, recording by recording."""

    names: tuple[str, ...]  # (p,) coefficients, then constants of the chain
    values: Array  # (p,) of the model
    bounds: tuple[Array, Array]  # (p,) each: lowest and highest after a step
    of_recordings: Array  # (g, p, p) information of each recording
    gradient: Array  # (g, p)
    scores: Array  # (blocks, p) of all recordings
    shares: Array  # (blocks, p, p) the information in each block
    recording: NDArray[np.int64]  # (blocks,) the recording of each block

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return len(self.scores)

    @cached_property
    def information(self) -> Array:
        """Of all recordings together (p, p)."""
        return np.asarray(self.of_recordings.sum(axis=0))

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
            of_recordings=self.of_recordings[np.ix_(range(len(self.of_recordings)), at, at)],
            gradient=self.gradient[:, at],
            scores=self.scores[:, at],
            shares=self.shares[np.ix_(range(self.blocks), at, at)],
        )

    def with_courses(self, weights: Array, courses: Array) -> "ScoreInformation":
        """With k further parameters s that are 0: factors 1 + s c on other parameters, c the course over blocks.

        weights: (p,) derivative of the parameters by a factor on them; courses: (blocks, k) c in each block. So
        the blocks' scores and information are those along `weights`, times c: no filter run is needed.
        """
        p, k = len(self.names), courses.shape[1]
        across = self.shares @ weights  # (blocks, p)
        shares = np.zeros((self.blocks, p + k, p + k))
        shares[:, :p, :p] = self.shares
        shares[:, :p, p:] = across[:, :, None] * courses[:, None, :]
        shares[:, p:, :p] = shares[:, :p, p:].swapaxes(1, 2)
        shares[:, p:, p:] = (
            (across @ weights)[:, None, None] * courses[:, :, None] * courses[:, None]
        )
        scores = np.hstack([self.scores, (self.scores @ weights)[:, None] * courses])
        whole, slope = (
            np.zeros((len(self.gradient), p + k, p + k)),
            np.zeros((len(self.gradient), p + k)),
        )
        np.add.at(whole, self.recording, shares)
        np.add.at(slope, self.recording, scores)
        whole[:, :p, :p], slope[:, :p] = self.of_recordings, self.gradient
        open_ends = np.full(k, np.inf)
        low, high = self.bounds
        return ScoreInformation(
            (*self.names, *(f"course {j}" for j in range(k))), np.append(self.values, np.zeros(k)),
            (np.append(low, -open_ends), np.append(high, open_ends)), whole, slope, scores, shares, self.recording,
        )  # fmt: skip


def score_information(problem: Problem, theta: Array, noise: Array) -> ScoreInformation:
    """About the free parameters of a problem, at theta (names,) and noise (12,), from one filter run.

    Raises IdentificationError where the model diverges.
    """
    runs = filter_along(problem, theta, noise, repeatable=False, shares=True)
    if not np.isfinite(runs.cost):
        raise IdentificationError("the boat diverges; look at the recordings with inspect")
    return score_information_in(runs)


def score_information_in(runs: FilterRuns) -> ScoreInformation:
    """About the free parameters of filter runs with `shares`."""
    problem, free, places = runs.problem, list(runs.problem.free), range(len(runs.by_recording))
    owner = [np.full(len(run.score), i) for i, run in enumerate(runs.by_recording)]
    # beyond a step's limits the linearisation does not hold: of a lag near 0 it is that of a latency
    (low, high), most = problem.bounds, problem.step_limits
    own = runs.theta[free]
    bounds = np.maximum(low, own - most), np.minimum(high, own + most)
    return ScoreInformation(
        tuple(problem.names[i] for i in free), own, bounds,
        np.array([runs.information_of(i) for i in places]), np.array([runs.gradient_of(i) for i in places]),
        runs.scores, runs.shares, np.concatenate(owner),
    )  # fmt: skip


def score_information_of(at: Point, extra: Sequence[Term] = ()) -> ScoreInformation:
    """About a solution's free parameters, and about coefficients of further terms, which are 0 in it."""
    return score_information_with((at.runs.problem, at.theta, at.noise), extra)


def score_information_with(
    at: tuple[Problem, Array, Array], extra: Sequence[Term]
) -> ScoreInformation:
    """The same of a solution that can travel to other processes: problem, parameters, noise."""
    problem, theta, noise = at
    whole = problem_with_terms(problem, (*problem.vehicle.structure.terms, *extra))
    return score_information(whole, moved(problem, theta, whole), noise)


def problem_with_terms(problem: Problem, terms: Sequence[Term]) -> Problem:
    """The problem with other terms, all of whose coefficients are free; of the chain the same constants are."""
    n = problem.n_coefficients
    constants = {problem.names[i] for i in problem.free if i >= n}
    wider = replace(problem, vehicle=problem.vehicle.with_terms(terms), free=())
    m = wider.n_coefficients
    free = (i for i, name in enumerate(wider.names) if i < m or name in constants)
    return replace(wider, free=tuple(free))


def moved(problem: Problem, theta: Array, other: Problem) -> Array:
    """Parameters of a problem as those of one with other terms: new coefficients are 0."""
    values = dict(zip(problem.names, theta.tolist(), strict=True))
    return np.array([values.get(name, 0.0) for name in other.names])


def solve_scaled(matrix: Array, right: Array) -> Array:
    """matrix^-1 right of a symmetric matrix, scaled to a unit diagonal, never singular."""
    scale = np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    scaled = matrix / np.outer(scale, scale) + 1e-12 * np.eye(len(matrix))
    inner = right / scale if right.ndim == 1 else right / scale[:, None]
    found = np.linalg.solve(scaled, inner)
    return np.asarray(found / scale if right.ndim == 1 else found / scale[:, None])


def solve_within(
    known: ScoreInformation, matrix: Array, gradient: Array, held: int | None = None
) -> Array:
    """Parameters (p,) a Gauss-Newton step away within their bounds, beyond which the others follow.

    matrix: (p, p) and gradient: (p,) of some blocks; held: the place of one that becomes 0.
    """
    scale = np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    low, high = (np.array(bound - known.values) for bound in known.bounds)
    if held is not None:
        low[held] = high[held] = -known.values[held]
    scaled = matrix / np.outer(scale, scale) + 1e-12 * np.eye(len(matrix))
    move = box_minimum(scaled, gradient / scale, low * scale, high * scale) / scale
    return np.asarray(known.values + move)
