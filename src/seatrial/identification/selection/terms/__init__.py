# SPDX-License-Identifier: MIT
"""Which terms a boat's recordings ask for, and which of them repeat.

First what no data can tell (exact aliases), then candidates by score tests and own terms by Wald
tests, repeats against each other, and the prediction of recordings that were left out.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from seatrial.boat.findings import Finding, FindingKind, of_kinds
from seatrial.boat.model import Model
from seatrial.boat.structure import Term
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.identification.diagnostics.homogeneity import DISAGREEMENTS
from seatrial.identification.diagnostics.unmodelled_effects import EFFECTS_FOUND
from seatrial.identification.estimator import output_error, with_free_stages
from seatrial.identification.methods import check_recordings
from seatrial.identification.selection.terms.candidates import (
    default_candidates,
    given_candidates,
    with_terms,
)
from seatrial.identification.selection.terms.console import selection_json, selection_text
from seatrial.identification.selection.terms.cross_validation import HALF_NAMES, folds
from seatrial.identification.selection.terms.decisions import Bench, reason_to_go
from seatrial.identification.selection.terms.explain import rows_of
from seatrial.identification.selection.terms.selection import Selection
from seatrial.identification.selection.terms.significance import freedom
from seatrial.identification.selection.terms.stepwise import Search, forward_and_back
from seatrial.recording.recording import Recording
from seatrial.util.statistics import BLOCK

DISTURBANCES = (FindingKind.DISTURBED_INTERVAL, FindingKind.DISTURBANCE_INFLUENCE)
CHANGES = (*DISAGREEMENTS, FindingKind.PARAMETER_DRIFT)  # of the boat, between recordings or in one

__all__ = [
    "Selection",
    "default_candidates",
    "given_candidates",
    "select",
    "selection_json",
    "selection_text",
]


def select(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    candidates: Sequence[Term] | None = None,
    horizon: float = DEFAULT_HORIZON,
    say: Callable[[str], None] = lambda _: None,
) -> Selection:
    """Keep a term if it is distinguishable from zero, repeats agree on it, and held-out prediction is no worse.

    `candidates` are terms that may come in (default: `default_candidates`); the vehicle's own may
    go, but not thrust along its own axis nor known terms. Raises IdentificationError where there is
    too little data, StructureError where a candidate can't be one.
    """
    check_recordings(recordings)
    blocks = math.ceil(sum(r.duration for r in recordings) / BLOCK)
    freedom(blocks, _sought(vehicle, recordings))
    tried = tuple(default_candidates(vehicle) if candidates is None else candidates)
    parts = folds(vehicle, recordings)
    together = tuple(r for part in parts for r in part.recordings)
    search = Search(vehicle, tried, together, say)
    say("the vehicle's own terms")
    model = output_error(together, vehicle)
    own = model.structure.terms
    first = model.findings_of(*EFFECTS_FOUND, *DISTURBANCES)
    model, changed = _changed(search, model)
    one_boat = not of_kinds(changed, *DISAGREEMENTS)
    named = set(vehicle.structure.coefficients)
    aliased = search.aliased(own, tried)
    refused: dict[str, str] = {}
    while True:
        model = forward_and_back(search, model, [*refused])
        say("repeats and held-out prediction")
        bench = Bench(search, model, parts, horizon)
        reasons = {
            name: reason_to_go(found, len(bench.kept), parts, own=name in named, one_boat=one_boat)
            for name, found in bench.kept.items()
        }
        bad = {n: r for n, r in reasons.items() if r is not None}
        if not bad:
            break
        worst = min(bad, key=lambda name: bench.kept[name].change.z)
        refused[worst] = bad[worst]
        model = search.fit([t for t in model.structure.terms if t.coefficient != worst], model)
    rows = rows_of(bench, own, aliased, refused)
    chosen = with_terms(vehicle, model.structure.terms)
    asked = tuple(of_files(finding) for finding in (*first, *changed))
    return Selection(replace(chosen, source=vehicle.source), model, rows, parts, horizon, asked)


def _sought(vehicle: Vehicle, recordings: Sequence[Recording]) -> int:
    """Parameters that identification will seek: coefficients, and the chain's constants that are not stated."""
    whole = with_free_stages(vehicle, recordings)
    stated = set(vehicle.constants.names) - set(whole.estimated)
    return len(vehicle.structure.coefficients) + len(set(whole.constants.names) - stated)


def _changed(search: Search, model: Model) -> tuple[Model, tuple[Finding, ...]]:
    """Findings on a boat that changed; with newcomers, where their lack might be the reason."""
    changed = model.findings_of(*CHANGES)
    if not changed:
        return model, ()
    whole = forward_and_back(search, model, [])
    if whole.structure.terms == model.structure.terms:
        return model, changed
    search.say("whether the recordings agree, with these")
    whole = search.fit(whole.structure.terms, None)
    return whole, whole.findings_of(*CHANGES)


def of_files(finding: Finding) -> Finding:
    """A disturbed interval of the recording as it was given, not of its half."""
    if finding.kind is not FindingKind.DISTURBED_INTERVAL:
        return finding
    name = finding.part("recording")
    for half in HALF_NAMES:
        name = name.removesuffix(half)
    return Finding(finding.kind, (name,), finding.values)
