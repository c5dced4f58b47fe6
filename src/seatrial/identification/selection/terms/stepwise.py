# SPDX-License-Identifier: MIT
"""Stepwise selection: forward by score tests, backward by Wald tests, both corrected for many candidates."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.structure import MOST_COEFFICIENTS, MOST_TERMS, Term
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.estimator import output_error
from seatrial.identification.selection.terms.aliasing import Alias, aliases
from seatrial.identification.selection.terms.candidates import drag_of, is_essential, with_terms
from seatrial.identification.selection.terms.score_information import (
    ScoreInformation,
    score_information_of,
)
from seatrial.identification.selection.terms.significance import estimate
from seatrial.recording.recording import Recording
from seatrial.util.errors import StructureError

SIGNIFICANCE_LEVEL = 0.05  # chance that any needless term is added, however many are tried
MOST_SWEEPS = 12  # of adding and removing
Message = Callable[[str], None]


@dataclass(frozen=True)
class TermSearch:
    """The candidates, and the recordings that decide."""

    vehicle: Vehicle  # as its file has it
    candidates: tuple[Term, ...]
    recordings: tuple[Recording, ...]
    say: Message

    def fit(self, terms: Sequence[Term], start: Model | None) -> Model:
        """Output-error with these terms."""
        return output_error(self.recordings, with_terms(self.vehicle, terms), start=start)

    def removable(self, terms: Sequence[Term]) -> list[str]:
        """Coefficients that may be removed: not thrust along its own axis, nor the last drag of an axis."""
        fixed = {t.coefficient for t in terms if is_essential(t, self.vehicle.forces)}
        drags = [drag_of(terms, axis) for axis in range(3)]
        fixed |= {names[0] for names in drags if len(names) == 1}
        return list(dict.fromkeys(str(t.coefficient) for t in terms if t.coefficient not in fixed))

    def aliased(self, terms: Sequence[Term], tried: Sequence[Term]) -> tuple[Alias, ...]:
        """Exact aliases among terms of a model and those that are tried."""
        return aliases(terms, tried, self.vehicle.forces)


def forward_and_back(search: TermSearch, model: Model, refused: Sequence[str]) -> Model:
    """Adds terms, the best of every axis at a time, until no candidate is distinguishable from zero.

    An added term is removed again where later ones replace it. `refused` ones are never added.
    """
    refused = list(refused)
    for _ in range(MOST_SWEEPS):
        added = best_candidates(search, model, refused)
        if added:
            search.say(f"with {', '.join(str(t.coefficient) for t in added)}")
            model = search.fit((*model.structure.terms, *added), model)
            continue
        removed = weakest_newcomer(search, model)
        if removed is None:
            return model
        search.say(f"without {removed}")
        refused.append(removed)
        model = search.fit([t for t in model.structure.terms if t.coefficient != removed], model)
    return model


def best_candidates(search: TermSearch, model: Model, refused: Sequence[str]) -> list[Term]:
    """The most significant candidate of every axis that passes Holm's test among all candidates."""
    tried = [
        t for t in search.candidates
        if t.coefficient not in model.values and t.coefficient not in refused
    ]  # fmt: skip
    hidden = {a.coefficient for a in search.aliased(model.structure.terms, tried)}
    tried = [t for t in tried if t.coefficient not in hidden]
    tested = {
        t.coefficient: estimate(s, str(t.coefficient))
        for t, s in candidate_information(search, model, tried)
    }
    best: dict[int, Term] = {}
    for rank, term in enumerate(sorted(tried, key=lambda t: tested[t.coefficient].p)):
        if tested[term.coefficient].p > SIGNIFICANCE_LEVEL / (len(tried) - rank):
            break
        best.setdefault(term.axis, term)
    return list(best.values())


def weakest_newcomer(search: TermSearch, model: Model) -> str | None:
    """The added term of the largest p-value, if it is not distinguishable from zero any more; else None."""
    information = score_information_of(model, search.recordings)
    own = set(search.vehicle.structure.coefficients)
    names = [n for n in search.removable(model.structure.terms) if n not in own]
    idle = model.at_bounds  # 0, and without a gradient
    tested = {name: 1.0 if name in idle else estimate(information, name).p for name in names}
    loose = [name for name in names if tested[name] > SIGNIFICANCE_LEVEL / len(search.candidates)]
    return max(loose, key=lambda name: tested[name], default=None)


def candidate_information(
    search: TermSearch, model: Model, tried: Sequence[Term]
) -> Iterator[tuple[Term, ScoreInformation]]:
    """Each term that is not in the model, with the information about the model and about it alone."""
    terms, coefficients = len(model.structure.terms), len(model.values)
    room = min(MOST_TERMS - terms, MOST_COEFFICIENTS - coefficients)
    if room < 1 and tried:
        raise StructureError(
            f"{terms} terms with {coefficients} coefficients leave no room for a candidate; at most "
            f"{MOST_TERMS - 1} and {MOST_COEFFICIENTS - 1} do"
        )
    for first in range(0, len(tried), max(1, room)):
        batch = tried[first : first + room]
        whole = score_information_of(model, search.recordings, batch)
        there = [n for n in whole.names if n not in {t.coefficient for t in batch}]
        for term in batch:
            yield term, whole.only([*there, str(term.coefficient)])


def with_zero_term(model: Model, term: Term) -> Model:
    """The model with one more term, whose coefficient is 0."""
    whole = with_terms(model.vehicle, (*model.structure.terms, term))
    values = np.array([model.values.get(name, 0.0) for name in whole.structure.coefficients])
    n = len(values) + len(model.constants)
    return replace(model, vehicle=whole, coefficients=values, covariance=np.zeros((n, n)))


def without_bound_terms(model: Model, names: Sequence[str]) -> Model:
    """The model without terms whose coefficients (`names`) are 0."""
    whole = with_terms(
        model.vehicle, [t for t in model.structure.terms if t.coefficient not in names]
    )
    kept = [i for i, name in enumerate(model.parameters) if name not in names]
    values = [model.values[name] for name in whole.structure.coefficients]
    return replace(
        model,
        vehicle=whole,
        coefficients=np.array(values),
        covariance=model.covariance[np.ix_(kept, kept)],
    )
