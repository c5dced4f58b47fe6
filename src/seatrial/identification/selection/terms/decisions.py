# SPDX-License-Identifier: MIT
"""What is known of every term, and why it stays or goes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.structure import Term
from seatrial.identification.selection.terms.cross_validation import Fold
from seatrial.identification.selection.terms.held_out import Change, HeldOut
from seatrial.identification.selection.terms.score_information import Slopes, slopes
from seatrial.identification.selection.terms.significance import (
    Estimate,
    Repeats,
    estimate,
    repeats,
)
from seatrial.identification.selection.terms.stepwise import (
    CHANCE,
    Search,
    looks,
    with_zero,
    without_idle,
)
from seatrial.util.statistics import NORMAL_95

WEAK = 1.0  # [%] of a velocity's change over the horizon: a term that moves it by less is weak
NOTHING = 0.1  # [%] of the same: a newcomer that moves it by less is not worth a line
UNREPEATABLE = 0.5  # of its own size: how far a coefficient may spread between repeats
HARM = -3.0  # [standard errors] held-out prediction must not be better without a term by as much
DOUBT = -1.0  # [standard errors] the same for a term that is not distinguishable from zero
SPREAD_CHANCE = 0.01  # that one of the kept terms is called unrepeatable when all are


class Verdict(Enum):
    """Whether a term is in the chosen structure."""

    STAYS = "stays"
    COMES = "comes"  # a candidate that was not there before
    GOES = "goes"  # was there before
    OUT = "out"  # a candidate that does not come
    ALIASED = "aliased"

    @property
    def kept(self) -> bool:
        """Whether the term is in the chosen structure."""
        return self in (Verdict.STAYS, Verdict.COMES)


@dataclass(frozen=True)
class Evidence:
    """The tests of one coefficient."""

    estimate: Estimate
    repeats: Repeats
    change: Change  # of held-out prediction, without the term

    idle: bool = False  # at its bound, 0: the tests say what it would be without a bound

    @property
    def told(self) -> bool:
        """Whether it is distinguishable from zero, looked at alone."""
        return self.estimate.p < CHANCE

    @property
    def reach(self) -> float:
        """How far the prediction may move by it [%], at the end of its 95 % interval.

        Quadratic drag at its bound can only be negative.
        """
        value = self.estimate.value
        most = max(0.0, (-value if self.idle else abs(value)) + NORMAL_95 * self.estimate.error)
        return self.change.moves * most / self.change.size if self.change.size > 0 else 0.0

    def repeatable(self, tests: int) -> bool:
        """Whether repeats agree on it to within its own size."""
        apart = self.repeats.p < SPREAD_CHANCE / tests
        return not (apart and self.repeats.between > UNREPEATABLE * abs(self.estimate.value))

    @property
    def harms(self) -> bool:
        """Whether held-out prediction is clearly better without it."""
        return self.change.z < HARM

    @property
    def helps(self) -> bool:
        """Whether held-out prediction is clearly worse without it."""
        return self.change.z > -HARM

    @property
    def weak(self) -> bool:
        """Whether it hardly moves the prediction, or is not distinguishable from zero."""
        return self.change.moves < WEAK or not self.told


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    term: str  # as in a file, forward-left-up
    coefficient: str
    axis: int
    unit: str
    verdict: Verdict
    reason: str
    evidence: Evidence | None  # None: not up for removal, or an exact alias

    @property
    def weak(self) -> bool:
        """Whether it is not distinguishable from zero, or hardly moves the prediction."""
        found = self.evidence
        return found is not None and (found.idle or not found.told or found.weak)


@dataclass(frozen=True)
class Bench:
    """A fitted model with all that its terms, and others, are tested by."""

    search: Search
    model: Model
    folds: Sequence[Fold]
    horizon: float  # [s]

    @cached_property
    def slopes(self) -> Slopes:
        """Of the model's own parameters."""
        return slopes(self.model, self.search.recordings)

    @cached_property
    def held_out(self) -> HeldOut:
        """Prediction of each fold from the others."""
        return HeldOut(
            self.model, self.slopes, _places(self.folds), self.search.recordings, self.horizon
        )

    @cached_property
    def idle(self) -> list[str]:
        """Coefficients that may go and are at their bound: 0."""
        terms = self.model.structure.terms
        return [n for n in self.search.removable(terms) if n in self.model.at_bounds]

    @cached_property
    def kept(self) -> dict[str, Evidence]:
        """Of every coefficient in the model that may go."""
        terms = self.model.structure.terms
        axes = {str(t.coefficient): t.axis for t in terms}
        found = {
            name: self._evidence(self.slopes, name, self.held_out.without(name, axes[name]))
            for name in self.search.removable(terms)
            if name not in self.idle
        }
        idle = self.others([t for t in terms if t.coefficient in self.idle])
        return {**found, **{name: replace(e, idle=True) for name, e in idle.items()}}

    def others(self, terms: Sequence[Term]) -> dict[str, Evidence]:
        """Of terms that are not in the model, or idle in it, each as if it alone came in."""
        found = {}
        model = without_idle(self.model, self.idle)
        for term, look in looks(self.search, model, terms):
            name = str(term.coefficient)
            change = self.held_out.with_it(with_zero(model, term), look, name, term.axis)
            found[name] = self._evidence(look, name, change)
        return found

    def _evidence(self, look: Slopes, name: str, change: Change) -> Evidence:
        return Evidence(estimate(look, name), repeats(look, name, _places(self.folds)), change)


def _places(folds: Sequence[Fold]) -> list[list[int]]:
    """Indices of each fold's recordings among all, fold after fold."""
    ends = np.cumsum([len(fold.recordings) for fold in folds])
    return [
        list(range(int(end) - len(fold.recordings), int(end)))
        for fold, end in zip(folds, ends, strict=True)
    ]


def reason_to_go(
    evidence: Evidence, tests: int, folds: Sequence[Fold], *, own: bool, one_boat: bool
) -> str | None:
    """Why a term of the model can't stay; None if it can.

    The file's own need not be distinguishable from zero: they go where repeats or prediction speak against
    them, or where they are too small to matter. Unless the repeats are of `one_boat` neither does.
    """
    change = evidence.change
    if evidence.idle:
        return _idle(evidence)
    if own and not one_boat:
        return _too_weak(evidence, doubt=-np.inf)
    if not evidence.repeatable(tests) and not evidence.helps:
        return f"not repeatable: {said_by(evidence.repeats, folds)}"
    if evidence.harms:
        return f"held-out prediction is {-change.percent:.2g} % better without it"
    if own:
        return _too_weak(evidence)
    small = change.moves < NOTHING
    return (
        f"distinguishable from zero, but moves the prediction by {change.moves:.1g} % only"
        if small
        else None
    )


def _idle(evidence: Evidence) -> str | None:
    """Why a term at its bound can't stay."""
    if evidence.reach >= WEAK:
        return None
    return f"at its bound, 0: it moves the prediction by {evidence.reach:.1g} % at most"


def _too_weak(evidence: Evidence, doubt: float = DOUBT) -> str | None:
    """Why a term of the file's own that is not distinguishable from zero can't stay."""
    if evidence.told:
        return None
    told, change = (
        f"weak: not distinguishable from zero (z = {evidence.estimate.z:.1f})",
        evidence.change,
    )
    if change.z < doubt:
        return f"{told}, held-out prediction is {-change.percent:.2g} % better without it"
    if evidence.reach < WEAK:
        return f"{told}, and moves the prediction by {evidence.reach:.1g} % at most"
    return None


def said_by(repeats: Repeats, folds: Sequence[Fold]) -> str:
    """What each repeat says, in words."""
    return "; ".join(
        f"{fold.name}: {value:.3g} ± {error:.2g}"
        for fold, value, error in zip(folds, repeats.values, repeats.errors, strict=True)
    )
