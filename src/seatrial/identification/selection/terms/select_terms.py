# SPDX-License-Identifier: MIT
"""Selection of terms, from first to last.

Exact aliases first, which no data can separate. Then candidates by score tests, forward, and terms by Wald
tests, backward. At last repeats of the experiment against each other, and the prediction of left-out recordings.
"""

from collections.abc import Sequence
from dataclasses import replace

from seatrial.boat.findings import Finding, FindingKind, of_kinds
from seatrial.boat.structure import Term
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.identification.diagnostics.boat_changes import DISAGREEMENTS
from seatrial.identification.diagnostics.unmodelled_effects import EFFECTS_FOUND
from seatrial.identification.estimator import fit, with_free_stages
from seatrial.identification.first_search import first_maximum
from seatrial.identification.recording_checks import check_recordings
from seatrial.identification.selection.actuator_selection import select_stages
from seatrial.identification.selection.significance import (
    TooShortError,
    blocks_of,
    enough_blocks,
    freedom,
)
from seatrial.identification.selection.terms.candidates import (
    candidate_tiers,
    with_usual_terms,
)
from seatrial.identification.selection.terms.decisions import Selection, TermTests, reason_to_go
from seatrial.identification.selection.terms.explain import rows_of
from seatrial.identification.selection.terms.held_out import Fold, folds, whole_name
from seatrial.identification.selection.terms.stepwise import (
    TermSearch,
    forward_and_back,
)
from seatrial.identification.selection.terms.term_fit import TermFit, begun_at, term_fit
from seatrial.identification.solution import OutputErrorSettings
from seatrial.recording.recording import Recording
from seatrial.util.blas import one_blas_thread
from seatrial.util.progress import stage, step

DISTURBANCES = (FindingKind.DISTURBED_INTERVAL, FindingKind.DISTURBANCE_INFLUENCE)
CHANGES = (
    *DISAGREEMENTS,
    FindingKind.CLOCK_DRIFT,
    FindingKind.PARAMETER_DRIFT,
)  # of the boat, between recordings or in one


@one_blas_thread
def select(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    candidates: Sequence[Term] | None = None,
    horizon: float = DEFAULT_HORIZON,
) -> Selection:
    """Keep a term if it is distinguishable from zero, repeats agree on it, and held-out prediction is no worse.

    `candidates` are terms that may come in (default: `candidate_tiers`); the vehicle's own may
    go, but not thrust along its own axis nor known terms. Raises IdentificationError where there is
    too little data, StructureError where a candidate can't be one.
    """
    # enough data, repeats of the experiment, candidates
    check_recordings(recordings, vehicle)
    freedom(blocks_of(recordings), estimated_parameters(vehicle, recordings))
    tiers = candidate_tiers(vehicle) if candidates is None else (tuple(candidates),)
    parts = folds(vehicle, recordings)
    together = tuple(r for part in parts for r in part.recordings)
    search = TermSearch(vehicle, tiers, horizon)
    # the fit with the vehicle's own terms, and the effects that it lacks
    with stage("the vehicle's own terms", 0.6):
        first = fit(together, vehicle)
    begin = term_fit(first)
    asked = of_kinds(first.findings, *EFFECTS_FOUND, *DISTURBANCES)
    # if the boat changed between recordings: further terms may explain that
    there, changed = _with_changes_explained(search, begin, first.findings)
    one_boat = not of_kinds(changed, *DISAGREEMENTS)
    told = tuple(of_files(finding) for finding in (*asked, *changed))
    return _selection(search, there, begin.terms, parts, one_boat=one_boat, asked=told)


def choose_structure(recordings: Sequence[Recording], vehicle: Vehicle) -> Selection | None:
    """The terms of a vehicle with `structure: auto`; None where the recordings are too short to test any.

    As `select`, from the first maximum of the likelihood: `identify` takes findings and further stages of the
    actuator chain with the chosen terms. The recordings are checked, every axis was driven. Raises
    IdentificationError where no solution is found, DivergenceError where one diverges in its filter.
    """
    if not enough_blocks(recordings, estimated_parameters(vehicle, recordings)):
        return None
    parts = folds(vehicle, recordings)
    together = tuple(r for part in parts for r in part.recordings)
    search = TermSearch(vehicle, candidate_tiers(vehicle), DEFAULT_HORIZON)
    # stages of the chain before terms: a missing curve of the thrusters looks like terms
    usual = with_usual_terms(vehicle)
    with stage("the terms that every boat has", 0.1):
        begin = begun_at(first_maximum(together, usual))
    with stage("actuator stages", 0.2):
        staged, _ = select_stages(begin.at, usual, OutputErrorSettings(), begin.horizon)
    begin = replace(begin, at=staged)
    try:
        own = vehicle.structure.terms
        return _selection(search, begin, own, parts, one_boat=True, asked=())
    except TooShortError:  # candidates and stages are further parameters
        return None


def _selection(
    search: TermSearch,
    there: TermFit,
    own: Sequence[Term],
    parts: tuple[Fold, ...],
    *,
    one_boat: bool,
    asked: tuple[Finding, ...],
) -> Selection:
    """Candidates in and out, until every term stands repeats and held-out prediction; the table of all."""
    aliased = search.aliased(own, search.candidates)
    with stage("", 0.93):
        tests, refused = _supported(search, there, parts, one_boat=one_boat)
    with stage("table of all terms"):
        rows = rows_of(tests, own, aliased, refused)
    vehicle = search.vehicle
    chosen = replace(vehicle.with_terms(tests.fit.terms), source=vehicle.source)
    return Selection(chosen, tests.fit.model(), rows, parts, search.ahead, asked)


def _supported(
    search: TermSearch, there: TermFit, parts: Sequence[Fold], *, one_boat: bool
) -> tuple[TermTests, dict[str, str]]:
    """The tests of a solution whose terms all stand them, and the refused terms with the reason."""
    refused: dict[str, str] = {}
    while True:
        # forward and backward at the present noise; refused terms stay out
        there = forward_and_back(search, there, [*refused])
        # repeats against each other, and held-out prediction without each term
        step(search.usual_sweeps, "repeats and held-out prediction")
        tests = TermTests(search, there, parts)
        reasons = {
            name: reason_to_go(
                found, len(tests.kept), parts, own=name in search.own, one_boat=one_boat
            )
            for name, found in tests.kept.items()
        }
        bad = {n: r for n, r in reasons.items() if r is not None}
        if not bad:
            return tests, refused
        # the worst of each axis goes, the others are tested again without it
        axes = {str(t.coefficient): t.axis for t in there.terms}
        worst: dict[int, str] = {}
        for name in sorted(bad, key=lambda name: tests.kept[name].change.z):
            worst.setdefault(axes[name], name)
        refused |= {name: bad[name] for name in worst.values()}
        with stage("", 0.1):
            there = there.refitted([t for t in there.terms if t.coefficient not in worst.values()])


def estimated_parameters(vehicle: Vehicle, recordings: Sequence[Recording]) -> int:
    """Number of parameters to be estimated: coefficients, and constants of the chain that are not stated."""
    whole = with_free_stages(vehicle, recordings)
    stated = set(vehicle.constants.names) - set(whole.estimated)
    return len(vehicle.structure.coefficients) + len(set(whole.constants.names) - stated)


def _with_changes_explained(
    search: TermSearch, begin: TermFit, findings: Sequence[Finding]
) -> tuple[TermFit, tuple[Finding, ...]]:
    """The solution, and its findings on a boat that changed between or within recordings.

    Missing terms can look like a change: then the terms are selected first, and the findings are taken again.
    """
    changed = of_kinds(findings, *CHANGES)
    if not changed:
        return begin, ()
    with stage("explaining a change", 0.2):
        whole = forward_and_back(search, begin, [])
    if whole.terms == begin.terms:
        return begin, changed
    with stage("agreement between recordings", 0.2):
        found = fit(begin.problem.recordings, search.vehicle.with_terms(whole.terms))
    return term_fit(found), of_kinds(found.findings, *CHANGES)


def of_files(finding: Finding) -> Finding:
    """A disturbed interval of the recording as it was given, not of its part."""
    if finding.kind is not FindingKind.DISTURBED_INTERVAL:
        return finding
    return Finding(finding.kind, (whole_name(finding.part("recording")),), finding.values)
