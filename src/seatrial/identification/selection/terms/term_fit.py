# SPDX-License-Identifier: MIT
"""The solution that terms are added to and removed from: a point of the likelihood at its fit horizon."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import noise_entry
from seatrial.boat.structure import Term
from seatrial.identification.likelihood.fit_horizon import FIT_HORIZONS, noise_floor
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import (
    Outcome,
    at_bounds,
    converged,
    full_pass,
    search,
)
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.whiteness import is_white, without_process_noise
from seatrial.identification.selection.score_information import moved, problem_with_terms
from seatrial.identification.solution import Fit
from seatrial.util.frames import Array
from seatrial.util.statistics import BLOCK

# full passes from a solution at a fit horizon, after which the innovations of the right terms are white
PASSES_TO_WHITENESS = 3


@dataclass(frozen=True)
class TermFit:
    """A solution with some terms."""

    at: Point
    horizon: float  # [s] fit horizon under model mismatch; 0: none
    likely: Array  # (12,) noise at the likelihood's maximum, of the filter that starts predictions
    settled: bool = True  # whether the noise belongs to these terms

    @property
    def problem(self) -> Problem:
        """Vehicle, recordings and free parameters."""
        return self.at.runs.problem

    @property
    def terms(self) -> tuple[Term, ...]:
        """All terms, forward-left-up."""
        return self.problem.vehicle.structure.terms

    @cached_property
    def values(self) -> dict[str, float]:
        """Coefficients by name."""
        names = self.problem.names[: self.problem.n_coefficients]
        return dict(zip(names, self.at.theta.tolist(), strict=False))

    @cached_property
    def at_bounds(self) -> tuple[str, ...]:
        """Free parameters that ended at a bound."""
        free, held = self.problem.free, at_bounds(self.at)
        return tuple(self.problem.names[i] for i, h in zip(free, held, strict=True) if h)

    def refitted(self, terms: Sequence[Term]) -> "TermFit":
        """With other terms, from here, at the same fit horizon and the same noise."""
        problem = problem_with_terms(self.problem, terms)
        found = search(
            problem, moved(self.problem, self.at.theta, problem), self.at.noise, hold=True
        )
        return replace(self, at=converged(found, or_near=True), settled=False)

    def with_noise(self) -> "TermFit":
        """With the noise that belongs to its terms; without fit horizon where innovations are white then."""
        if self.settled:
            return self
        if self.horizon:
            at, outcome = search(
                self.problem, self.at.theta, self.likely, passes=PASSES_TO_WHITENESS
            )
            if outcome is Outcome.OUT_OF_STEPS and is_white(at):
                at, outcome = search(self.problem, at.theta, at.noise)
            if outcome is Outcome.CONVERGED and is_white(at):
                return TermFit(at, 0.0, at.noise)
        least = noise_floor(self.problem, self.horizon)
        found = search(self.problem, self.at.theta, self.at.noise, least=least)
        at = converged(found, or_near=True)
        return TermFit(at, self.horizon, self.likely if self.horizon else at.noise)

    def with_terms(self, terms: Sequence[Term]) -> "TermFit":
        """With other terms at the same parameters, not refitted."""
        problem = problem_with_terms(self.problem, terms)
        return replace(
            self, at=full_pass(problem, moved(self.problem, self.at.theta, problem), self.at.noise)
        )

    def model(self, terms: Sequence[Term] | None = None) -> Model:
        """The model for predictions, without uncertainty; with other `terms`, new coefficients are 0."""
        problem, theta = self.problem, self.at.theta
        if terms is not None:
            problem = problem_with_terms(self.problem, terms)
            theta = moved(self.problem, self.at.theta, problem)
        return problem.model(theta, noise_entry(self.likely, earth=problem.earth_fixed))


def term_fit(found: Fit) -> TermFit:
    """Where a selection begins: a solution, under model mismatch at the fit horizon."""
    fit = term_fit_of(found)
    return fit if fit.horizon else begun_at(fit.at)


def term_fit_of(found: Fit) -> TermFit:
    """A solution as it is, with one process noise for surge and sway."""
    return TermFit(_with_usual_blocks(found.equal), found.horizon, found.maximum_noise)


def begun_at(at: Point) -> TermFit:
    """A likelihood's maximum, or under model mismatch the solution at the fit horizon."""
    at = _with_usual_blocks(at)
    if without_process_noise(at) or is_white(at):
        return TermFit(at, 0.0, at.noise)
    least = noise_floor(at.runs.problem, FIT_HORIZONS[0])
    there, outcome = search(at.runs.problem, at.theta, at.noise, least=least)
    if outcome is not Outcome.CONVERGED:
        return TermFit(at, 0.0, at.noise)
    return TermFit(there, FIT_HORIZONS[0], at.noise)


def _with_usual_blocks(at: Point) -> Point:
    """The same with blocks of `BLOCK` [s]."""
    problem = at.runs.problem
    if problem.block == BLOCK:
        return at
    return full_pass(replace(problem, block=BLOCK), at.theta, at.noise)
