# SPDX-License-Identifier: MIT
"""Selection of terms, from first to last.

Exact aliases first, which no data can separate. Then candidates by score tests, forward, and terms by Wald
tests, backward. At last repeats of the experiment against each other, and the prediction of left-out recordings.
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
    with_terms,
)
from seatrial.identification.selection.terms.cross_validation import HALF_NAMES, Fold, folds
from seatrial.identification.selection.terms.decisions import TermTests, reason_to_go
from seatrial.identification.selection.terms.explain import rows_of
from seatrial.identification.selection.terms.selection import Selection
from seatrial.identification.selection.terms.significance import freedom
from seatrial.identification.selection.terms.stepwise import TermSearch, forward_and_back
from seatrial.recording.recording import Recording
from seatrial.util.statistics import BLOCK

DISTURBANCES = (FindingKind.DISTURBED_INTERVAL, FindingKind.DISTURBANCE_INFLUENCE)
CHANGES = (*DISAGREEMENTS, FindingKind.PARAMETER_DRIFT)  # of the boat, between recordings or in one


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
    # enough data, repeats of the experiment, candidates
    check_recordings(recordings)
    blocks = math.ceil(sum(r.duration for r in recordings) / BLOCK)
    freedom(blocks, _estimated(vehicle, recordings))
    tried = tuple(default_candidates(vehicle) if candidates is None else candidates)
    parts = folds(vehicle, recordings)
    together = tuple(r for part in parts for r in part.recordings)
    search = TermSearch(vehicle, tried, together, say)
    # the fit with the vehicle's own terms, and the effects that it lacks
    say("the vehicle's own terms")
    model = output_error(together, vehicle)
    own = model.structure.terms
    first = model.findings_of(*EFFECTS_FOUND, *DISTURBANCES)
    aliased = search.aliased(own, tried)
    # if the boat changed between recordings: further terms may explain that
    model, changed = _with_changes_explained(search, model)
    one_boat = not of_kinds(changed, *DISAGREEMENTS)
    # candidates in and out, until every term stands repeats and held-out prediction
    tests, refused = _supported(search, model, parts, horizon, one_boat=one_boat)
    # the table, and the vehicle with the chosen terms
    rows = rows_of(tests, own, aliased, refused)
    chosen = replace(with_terms(vehicle, tests.model.structure.terms), source=vehicle.source)
    asked = tuple(of_files(finding) for finding in (*first, *changed))
    return Selection(chosen, tests.model, rows, parts, horizon, asked)


def _supported(
    search: TermSearch, model: Model, parts: Sequence[Fold], horizon: float, *, one_boat: bool
) -> tuple[TermTests, dict[str, str]]:
    """The tests of a model whose terms all stand them, and the refused terms with the reason."""
    named = set(search.vehicle.structure.coefficients)
    refused: dict[str, str] = {}
    while True:
        # forward and backward at the present noise; refused terms stay out
        model = forward_and_back(search, model, [*refused])
        # repeats against each other, and held-out prediction without each term
        search.say("repeats and held-out prediction")
        tests = TermTests(search, model, parts, horizon)
        reasons = {
            name: reason_to_go(found, len(tests.kept), parts, own=name in named, one_boat=one_boat)
            for name, found in tests.kept.items()
        }
        bad = {n: r for n, r in reasons.items() if r is not None}
        if not bad:
            return tests, refused
        # the worst goes, the others are tested again without it
        worst = min(bad, key=lambda name: tests.kept[name].change.z)
        refused[worst] = bad[worst]
        model = search.fit([t for t in model.structure.terms if t.coefficient != worst], model)


def _estimated(vehicle: Vehicle, recordings: Sequence[Recording]) -> int:
    """Number of parameters to be estimated: coefficients, and constants of the chain that are not stated."""
    whole = with_free_stages(vehicle, recordings)
    stated = set(vehicle.constants.names) - set(whole.estimated)
    return len(vehicle.structure.coefficients) + len(set(whole.constants.names) - stated)


def _with_changes_explained(search: TermSearch, model: Model) -> tuple[Model, tuple[Finding, ...]]:
    """The model, and its findings on a boat that changed between or within recordings.

    Missing terms can look like a change: then the terms are selected first, and the findings are taken again.
    """
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
