# SPDX-License-Identifier: MIT
"""Stepwise selection: forward by score tests, backward by Wald tests, both corrected for many candidates.

Under model mismatch the likelihood overfits short times. There a candidate must improve the prediction of blocks
that were left out as well.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial

import numpy as np

from seatrial.boat.structure import MOST_COEFFICIENTS, MOST_TERMS, Term
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.selection.score_information import (
    ScoreInformation,
    score_information_of,
    score_information_with,
)
from seatrial.identification.selection.significance import Estimate, estimate
from seatrial.identification.selection.terms.block_prediction import BlockPrediction, Gain, trained
from seatrial.identification.selection.terms.candidates import (
    Alias,
    aliases,
    drag_of,
    is_essential,
    with_usual_terms,
)
from seatrial.identification.selection.terms.term_fit import TermFit
from seatrial.util.errors import StructureError
from seatrial.util.frames import Array
from seatrial.util.parallel import farmed
from seatrial.util.progress import stage, step

SIGNIFICANCE_LEVEL = 0.05  # chance that any needless term is added, however many are tried
MOST_SWEEPS = 20  # of adding and removing


@dataclass(frozen=True)
class TermSearch:
    """The candidates, and how far ahead they must predict."""

    vehicle: Vehicle  # as its file has it
    tiers: tuple[tuple[Term, ...], ...]  # candidates; those of a tier come in before later ones
    ahead: float  # [s] of held-out prediction

    @property
    def usual_sweeps(self) -> float:
        """Of a search, for the progress: a vehicle with terms of its own needs few."""
        return 12.0 if self.vehicle.automatic else 4.0

    @property
    def candidates(self) -> tuple[Term, ...]:
        """Of all tiers."""
        return tuple(term for tier in self.tiers for term in tier)

    @cached_property
    def own(self) -> frozenset[str]:
        """Coefficients that need not be distinguishable from zero: the file's; with `structure: auto` free added
        mass as well, which every boat has."""
        known = with_usual_terms(self.vehicle) if self.vehicle.automatic else self.vehicle
        return frozenset(known.structure.coefficients)

    def removable(self, terms: Sequence[Term]) -> list[str]:
        """Coefficients that may be removed: not thrust along its own axis, nor the last drag of an axis."""
        fixed = {t.coefficient for t in terms if is_essential(t, self.vehicle.forces)}
        drags = [drag_of(terms, axis) for axis in range(3)]
        fixed |= {names[0] for names in drags if len(names) == 1}
        return list(dict.fromkeys(str(t.coefficient) for t in terms if t.coefficient not in fixed))

    def aliased(self, terms: Sequence[Term], tried: Sequence[Term]) -> tuple[Alias, ...]:
        """Exact aliases among terms of a model and those that are tried."""
        return aliases(terms, tried, self.vehicle.forces)


def forward_and_back(search: TermSearch, fit: TermFit, refused: Sequence[str]) -> TermFit:
    """Adds terms, the best of every axis at a time, until no candidate is distinguishable from zero.

    An added term is removed again where later ones replace it. `refused` ones are never added. The noise is held
    meanwhile; at the end it is fitted again, and candidates are tested once more.
    """
    refused, latest = list(refused), "candidates"
    for _ in range(MOST_SWEEPS):
        step(search.usual_sweeps, latest)
        with stage("", 0.9):
            added = best_candidates(search, fit, refused)
        if added:
            latest = f"with {', '.join(str(t.coefficient) for t in added)}"
            with stage(""):
                fit = fit.refitted((*fit.terms, *added))
            continue
        before, fit = fit, without_loose_newcomers(search, fit)
        refused += [name for name in before.values if name not in fit.values]
        if fit.settled:
            return fit
        step(search.usual_sweeps, latest := "noise of these terms")
        with stage(""):
            fit = fit.with_noise()
    with stage(""):
        return fit.with_noise()


def best_candidates(search: TermSearch, fit: TermFit, refused: Sequence[str]) -> list[Term]:
    """The best candidate of every axis, of the first tier that has any.

    It passes Holm's test among all candidates, and is the most significant one. Under model mismatch it improves
    the prediction of left-out blocks most and beyond chance; with `structure: auto` its own test is enough there.
    """
    room = room_for(fit.terms)
    out = {*fit.values, *refused}
    tried = [[t for t in tier if t.coefficient not in out] for tier in search.tiers]
    everything = [t for tier in tried for t in tier]
    hidden = {a.coefficient for a in search.aliased(fit.terms, everything)}
    tests = len(everything) - len(hidden)
    blocks = cache(partial(BlockPrediction.of, fit.model(), fit.problem, search.ahead))
    for tier in tried if room else ():
        looked = dict(candidate_information(fit, [t for t in tier if t.coefficient not in hidden]))
        tested = {t: estimate(s, str(t.coefficient)) for t, s in looked.items()}
        passed = significant(tested, tests)
        if fit.horizon and search.vehicle.automatic:  # the prediction of blocks guards instead
            passed = [t for t in looked if tested[t].p < SIGNIFICANCE_LEVEL]
        if fit.horizon:
            gains = predicted(fit, {t: looked[t] for t in passed}, blocks)
            clear = [t for t, (gain, _) in gains.items() if gain.clear]
            passed = sorted(clear, key=lambda t: -gains[t][0].log)
        best: dict[int, Term] = {}
        for term in passed:
            best.setdefault(term.axis, term)
        if best:
            return list(best.values())[:room]
    return []


def significant(tested: Mapping[Term, Estimate], tests: int) -> list[Term]:
    """Terms that pass Holm's test among so many, the most significant one first."""
    passed = []
    for rank, term in enumerate(sorted(tested, key=lambda t: tested[t].p)):
        if tested[term].p > SIGNIFICANCE_LEVEL / (tests - rank):
            break
        passed.append(term)
    return passed


def predicted(
    fit: TermFit, looked: Mapping[Term, ScoreInformation], blocks: Callable[[], BlockPrediction]
) -> dict[Term, tuple[Gain, Array]]:
    """Of terms that the model lacks: the gain in predicting left-out blocks, and the ratio (3,) of RMS errors.

    looked: the information about the model and the term alone; blocks: of the model without the terms, made where
    they are needed.
    """
    if not looked:
        return {}
    first = next(iter(looked))
    own = [n for n in looked[first].names if n != first.coefficient]
    models = [trained(fit.model(), looked[first].only(own))]
    models += [trained(fit.model((*fit.terms, term)), looked[term]) for term in looked]
    there = blocks()
    before, *each = farmed(BlockPrediction.squares, there, models)
    with np.errstate(invalid="ignore"):  # no ratio where the model without the term diverges, too
        ratios = [np.sqrt(after.mean(axis=0) / before.mean(axis=0)) for after in each]
    gains = [there.gain(before, after) for after in each]
    return dict(zip(looked, zip(gains, ratios, strict=True), strict=True))


def without_loose_newcomers(search: TermSearch, fit: TermFit) -> TermFit:
    """Without the added terms that are not distinguishable from zero any more; the same if all are."""
    while (name := weakest_newcomer(search, fit)) is not None:
        step(search.usual_sweeps, f"without {name}")
        with stage(""):
            fit = fit.refitted([t for t in fit.terms if t.coefficient != name])
    return fit


def weakest_newcomer(search: TermSearch, fit: TermFit) -> str | None:
    """The added term of the largest p-value, if it is not distinguishable from zero any more; else None."""
    information = score_information_of(fit.at)
    names = [n for n in search.removable(fit.terms) if n not in search.own]
    idle = fit.at_bounds  # 0, and without a gradient
    tested = {name: 1.0 if name in idle else estimate(information, name).p for name in names}
    level = (
        SIGNIFICANCE_LEVEL
        if fit.horizon and search.vehicle.automatic
        else SIGNIFICANCE_LEVEL / max(1, len(search.candidates))
    )
    loose = [name for name in names if tested[name] > level]
    return max(loose, key=lambda name: tested[name], default=None)


def room_for(terms: Sequence[Term]) -> int:
    """How many further terms, each with a coefficient, the core takes."""
    coefficients = len({t.coefficient for t in terms if t.coefficient})
    return min(MOST_TERMS - len(terms), MOST_COEFFICIENTS - coefficients)


def candidate_information(
    fit: TermFit, tried: Sequence[Term]
) -> Iterator[tuple[Term, ScoreInformation]]:
    """Each term that is not in the model, with the information about the model and about it alone."""
    room = room_for(fit.terms)
    if room < 1 and tried:
        raise StructureError(
            f"{len(fit.terms)} terms with {len(fit.values)} coefficients leave no room for a candidate; at most "
            f"{MOST_TERMS - 1} and {MOST_COEFFICIENTS - 1} do"
        )
    batches = [tried[first : first + room] for first in range(0, len(tried), max(1, room))]
    # `replace`: without what the problem has computed from itself, which can't travel to other processes
    common = replace(fit.problem), fit.at.theta, fit.at.noise
    for batch, whole in zip(batches, farmed(score_information_with, common, batches), strict=True):
        there = [n for n in whole.names if n not in {t.coefficient for t in batch}]
        for term in batch:
            yield term, whole.only([*there, str(term.coefficient)])
