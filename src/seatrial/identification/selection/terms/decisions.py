# SPDX-License-Identifier: MIT
"""The tests of every term, and the decision whether it stays."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np

from seatrial.boat.findings import Finding
from seatrial.boat.model import Model
from seatrial.boat.structure import Term
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.selection.score_information import (
    ScoreInformation,
    score_information_of,
)
from seatrial.identification.selection.significance import (
    Estimate,
    Repeats,
    estimate,
    repeats,
)
from seatrial.identification.selection.terms.held_out import Fold, HeldOut, PredictionChange
from seatrial.identification.selection.terms.stepwise import (
    SIGNIFICANCE_LEVEL,
    TermSearch,
    candidate_information,
)
from seatrial.identification.selection.terms.term_fit import TermFit
from seatrial.util.format import sensible
from seatrial.util.statistics import NORMAL_95

WEAK_MOVE = 1.0  # [%] of a velocity's change over the horizon: a term that moves it by less is weak
NEGLIGIBLE_MOVE = 0.1  # [%] of the same: a new term that moves it by less is not worth its line
# of its own size: larger spread of a coefficient between repeats is too much
UNREPEATABLE_SPREAD = 0.5
HARMFUL_Z = -3.0  # standard errors: held-out prediction is clearly better without a term
DOUBTFUL_Z = -1.0  # the same for a term that is not distinguishable from zero
REPEATABILITY_LEVEL = 0.01  # chance that any kept term counts as unrepeatable although all repeat


class TermVerdict(Enum):
    """Whether a term is in the chosen structure."""

    STAYS = "stays"
    COMES = "comes"  # a candidate that is added
    GOES = "goes"  # one of the vehicle's own, removed
    OUT = "out"  # a candidate that is not added
    ALIASED = "aliased"

    @property
    def kept(self) -> bool:
        """Whether the term is in the chosen structure."""
        return self in (TermVerdict.STAYS, TermVerdict.COMES)


@dataclass(frozen=True)
class TermEvidence:
    """The tests of one coefficient."""

    estimate: Estimate
    repeats: Repeats
    change: PredictionChange  # of held-out prediction, without the term

    idle: bool = False  # at its bound, 0: the tests are of the value without a bound

    @property
    def significant(self) -> bool:
        """Whether it is distinguishable from zero, tested alone."""
        return self.estimate.p < SIGNIFICANCE_LEVEL

    @property
    def reach(self) -> float:
        """The largest RMS change [%] of the prediction by it, at the end of its 95 % interval.

        Quadratic drag at its bound can only be negative.
        """
        value = self.estimate.value
        most = max(0.0, (-value if self.idle else abs(value)) + NORMAL_95 * self.estimate.error)
        return self.change.moves * most / self.change.size if self.change.size > 0 else 0.0

    def repeatable(self, tests: int) -> bool:
        """Whether repeats agree on it to within its own size."""
        apart = self.repeats.p < REPEATABILITY_LEVEL / tests
        return not (apart and self.repeats.between > UNREPEATABLE_SPREAD * abs(self.estimate.value))

    @property
    def harms(self) -> bool:
        """Whether held-out prediction is clearly better without it."""
        return self.change.z < HARMFUL_Z

    @property
    def helps(self) -> bool:
        """Whether held-out prediction is clearly worse without it."""
        return self.change.z > -HARMFUL_Z

    @property
    def weak(self) -> bool:
        """Whether it hardly moves the prediction, or is not distinguishable from zero."""
        return self.change.moves < WEAK_MOVE or not self.significant


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    term: str  # as in a file, forward-left-up
    coefficient: str
    axis: int
    unit: str
    verdict: TermVerdict
    reason: str
    evidence: TermEvidence | None  # None: never removed, or an exact alias

    @property
    def weak(self) -> bool:
        """Whether it is kept although it is weak."""
        found = self.evidence
        return found is not None and self.verdict.kept and (found.idle or found.weak)


@dataclass(frozen=True)
class TermTests:
    """A solution, with the tests of its terms and of candidates."""

    search: TermSearch
    fit: TermFit
    folds: Sequence[Fold]

    @cached_property
    def information(self) -> ScoreInformation:
        """Of the solution's own parameters."""
        return score_information_of(self.fit.at)

    @cached_property
    def held_out(self) -> HeldOut:
        """Prediction of each fold from the others."""
        return HeldOut(
            self.fit.model(), self.information, _places(self.folds),
            self.fit.problem.recordings, self.search.ahead,
        )  # fmt: skip

    @cached_property
    def idle(self) -> list[str]:
        """Removable coefficients at their bound, 0."""
        return [n for n in self.search.removable(self.fit.terms) if n in self.fit.at_bounds]

    @cached_property
    def kept(self) -> dict[str, TermEvidence]:
        """Of every removable coefficient in the model."""
        terms = self.fit.terms
        axes = {str(t.coefficient): t.axis for t in terms}
        tested = [n for n in self.search.removable(terms) if n not in self.idle]
        changes = self.held_out.without({name: axes[name] for name in tested})
        found = {n: self._evidence(self.information, n, change) for n, change in changes.items()}
        idle = self.others([t for t in terms if t.coefficient in self.idle])
        return {**found, **{name: replace(e, idle=True) for name, e in idle.items()}}

    def others(self, terms: Sequence[Term]) -> dict[str, TermEvidence]:
        """Of terms that are not in the model, or at their bound in it, each added alone."""
        there = [t for t in self.fit.terms if t.coefficient not in self.idle]
        fit = self.fit.with_terms(there) if self.idle else self.fit
        tried = {
            str(term.coefficient): (fit.model((*there, term)), information, term.axis)
            for term, information in candidate_information(fit, terms)
        }
        changes = self.held_out.with_each(tried)
        return {n: self._evidence(tried[n][1], n, change) for n, change in changes.items()}

    def _evidence(
        self, information: ScoreInformation, name: str, change: PredictionChange
    ) -> TermEvidence:
        return TermEvidence(
            estimate(information, name), repeats(information, name, _places(self.folds)), change
        )


def _places(folds: Sequence[Fold]) -> list[list[int]]:
    """Indices of each fold's recordings among all, fold after fold."""
    ends = np.cumsum([len(fold.recordings) for fold in folds])
    return [
        list(range(int(end) - len(fold.recordings), int(end)))
        for fold, end in zip(folds, ends, strict=True)
    ]


def reason_to_go(
    evidence: TermEvidence, tests: int, folds: Sequence[Fold], *, own: bool, one_boat: bool
) -> str | None:
    """Why a term of the model is removed; None if it stays.

    Terms of the vehicle's file need not be distinguishable from zero. They are removed if repeats or held-out
    prediction reject them, or if they are too small to matter; if the repeats are not of `one_boat`, only then.
    """
    change = evidence.change
    if evidence.idle:
        return _idle(evidence)
    if own and not one_boat:
        return _too_weak(evidence, doubt=-np.inf)
    if not evidence.repeatable(tests) and not evidence.helps:
        return f"not repeatable: {repeats_text(evidence.repeats, folds)}"
    if evidence.harms:
        return f"held-out prediction is {-change.percent:.2g} % better without it"
    if own:
        return _too_weak(evidence)
    small = change.moves < NEGLIGIBLE_MOVE
    return (
        f"distinguishable from zero, but moves the prediction by {change.moves:.1g} % only"
        if small
        else None
    )


def _idle(evidence: TermEvidence) -> str | None:
    """Why a term at its bound is removed; None if it stays."""
    if evidence.reach >= WEAK_MOVE:
        return None
    return f"at its bound, 0: it moves the prediction by {evidence.reach:.1g} % at most"


def _too_weak(evidence: TermEvidence, doubt: float = DOUBTFUL_Z) -> str | None:
    """Why a term of the file that is not distinguishable from zero is removed; None if it stays."""
    if evidence.significant:
        return None
    weak, change = (
        f"weak: not distinguishable from zero (z = {sensible(evidence.estimate.z)})",
        evidence.change,
    )
    if change.z < doubt:
        return f"{weak}, held-out prediction is {-change.percent:.2g} % better without it"
    if evidence.reach < WEAK_MOVE:
        return f"{weak}, and moves the prediction by {evidence.reach:.1g} % at most"
    return None


def repeats_text(repeats: Repeats, folds: Sequence[Fold]) -> str:
    """The estimate of each repeat."""
    return "; ".join(
        f"{fold.name}: {value:.3g} ± {error:.2g}"
        for fold, value, error in zip(folds, repeats.values, repeats.errors, strict=True)
    )


@dataclass(frozen=True)
class Selection:
    """The chosen structure, with the tests behind it."""

    vehicle: Vehicle  # with the chosen terms; otherwise unchanged
    model: Model  # fitted to all recordings together, without uncertainty
    rows: tuple[Row, ...]
    folds: tuple[Fold, ...]
    horizon: float  # [s] of the held-out prediction
    asked: tuple[Finding, ...] = ()  # to be looked at before any term
