# SPDX-License-Identifier: MIT
"""Selection for boats whose file has a term too many or one too few, and for boats that changed."""

from dataclasses import replace

import msgspec
import pytest

import seatrial
from seatrial.boat.findings import FindingKind, finding_text
from seatrial.identification.selection.significance import Estimate, Repeats
from seatrial.identification.selection.terms import (
    default_candidates,
    given_candidates,
    select,
    selection_text,
)
from seatrial.identification.selection.terms.decisions import (
    TermEvidence,
    TermVerdict,
    reason_to_go,
)
from seatrial.identification.selection.terms.held_out import PredictionChange
from seatrial.identification.selection.terms.stepwise import TermSearch
from seatrial.simulation.plan import DisturbanceForce, PlanFile
from seatrial.simulation.trials import plant_model, simulate
from tests.boats.plans import planned

FIRST, SECOND = ("S1", "S2", "S3"), ("S4", "S5", "S6")


def plan_of(preset: str, seed: int, length: float, **coefficients: float) -> PlanFile:
    """Trials of a boat of which some coefficients are others."""
    return planned(preset, *FIRST, *SECOND, seconds=length, seed=seed, coefficients=coefficients)


def pushed(plan: PlanFile) -> PlanFile:
    return planned(plan, plant={"unmodelled": DisturbanceForce(0.04, 2.0)})


def recordings(plan, vehicle, names=(*FIRST, *SECOND)):
    plan = planned(plan, *names)
    return [t.recording for t in simulate(plan, vehicle, plant_model(plan, vehicle))]


def test_a_term_that_ends_at_its_bound_goes(mp):
    """Quadratic drag that the boat has not: half of the time its estimate is held at 0."""
    plan = plan_of("hard", 1, 60.0, Y_vv=0.0, X_uu=0.0, N_rr=0.0)
    found = select(recordings(plan, mp), mp, candidates=())
    rows = {row.coefficient: row for row in found.rows}
    assert any("at its bound, 0: it moves" in rows[n].reason for n in ("X_uu", "Y_vv", "N_rr"))
    for name in ("X_uu", "Y_vv", "N_rr"):
        row = rows[name]
        if "at its bound" in row.reason:
            assert row.verdict in (TermVerdict.GOES, TermVerdict.STAYS)
            assert row.evidence is not None
            assert abs(row.evidence.estimate.value) < 4 * row.evidence.estimate.error
    assert {"X_u", "Y_v", "N_r"} <= set(found.model.values)


@pytest.mark.parametrize(("value", "said"), [(0.04, None), (0.3, "0, it moves"), (-0.3, None)])
def test_what_may_be_large_for_all_its_bound_stays(value, said):
    """Its tests are without the bound: they say how far below 0 it may be."""
    evidence = TermEvidence(
        Estimate(value, 0.1, 0.5), Repeats([0, 0], [1, 1], 0.5, 0.0, 1.0),
        PredictionChange(0.0, 0.0, 10.0, 1.0), idle=True,
    )  # fmt: skip
    found = reason_to_go(evidence, 10, (), own=True, one_boat=True)
    assert found == (
        None if said is None else "at its bound, 0: it moves the prediction by 0 % at most"
    )


def test_the_last_drag_of_an_axis_is_not_up_for_removal(mp):
    search = TermSearch(mp, (), 1.0)
    terms = mp.structure.terms
    assert {"X_u", "X_uu"} <= set(search.removable(terms))
    fewer = search.removable([t for t in terms if t.coefficient != "X_u"])
    assert "X_uu" not in fewer
    assert {"Y_v", "Y_vv", "N_uu"} <= set(fewer)


@pytest.mark.system
def test_a_boat_that_changed_does_not_lose_its_drag_for_it(mp):
    """Three times the drag in surge from S4 on, pushed: the repeats are of two boats, and it is said."""
    before = pushed(plan_of("hard", 61, 120.0))
    more = {n: 3.0 * before.plant.coefficients[n] for n in ("X_u", "X_uu")}
    after = pushed(plan_of("hard", 61, 120.0, **more))
    found = select(
        [*recordings(before, mp, FIRST), *recordings(after, mp, SECOND)], mp, candidates=()
    )
    assert {"X_u", "X_uu"} <= set(found.model.values)
    (finding,) = found.asked
    assert (finding.kind, finding.part("axis")) == (FindingKind.HOMOGENEITY, "surge")
    assert finding.values["quantity"] == "drag"
    assert f"Check first: {finding_text(finding)}" in selection_text(found)


@pytest.mark.system
def test_a_term_that_the_file_lacks_is_no_boat_that_changed(mp):
    """|v| r and u u u are among the usual candidates; without them drag differs from drive to drive."""
    plan = plan_of("hard", 21, 60.0, N_a=-0.8, X_a=-3.0)
    more = given_candidates(mp, ["N_a * |v| * r", "X_a * u * u * u"])
    driven = mp.with_terms((*mp.structure.terms, *more))
    found = select(recordings(plan, driven), mp)
    came = [row.term.partition(" * ")[2] for row in found.rows if row.verdict is TermVerdict.COMES]
    assert came == ["u * u * u", "|v| * r"]
    assert found.asked == ()


def test_drag_of_all_kinds_is_among_the_usual_candidates(mp):
    texts = {t.text().partition(" * ")[2] for t in default_candidates(mp)}
    assert {"u * u * u", "v * v * v", "r * r * r"} <= texts
    lines = {axis: [t for t in own if "|" not in t] for axis, own in mp.structure.lines().items()}
    linear = replace(mp, file=msgspec.structs.replace(mp.file, structure=lines))
    missing = {t.text() for t in default_candidates(linear)} - {
        t.text() for t in default_candidates(mp)
    }
    assert {"X_uu * |u| * u", "Y_vv * |v| * v", "N_rr * |r| * r"} <= missing
    assert {"|v| * u", "|r| * u", "|u| * v", "|r| * v", "|u| * r", "|v| * r"} <= texts
    assert seatrial.load_vehicle("mallard-mp").structure.coefficients == mp.structure.coefficients
