# SPDX-License-Identifier: MIT
"""Candidates of a selection: which terms are new, in whose axes, and which are never removed."""

from dataclasses import replace

import pytest
from conftest import CSE1
from test_select import named

import seatrial
from seatrial.identification.selection.terms import (
    default_candidates,
    given_candidates,
)
from seatrial.identification.selection.terms.candidates import aliases, is_essential
from seatrial.util.errors import StructureError


def test_n_ud_is_exactly_four_other_terms_and_nothing_less(mp):
    """u_dot = v r + X_u u + X_uu |u| u + X_F F_u (Eq. (12)); |u| u is in the yaw equation already."""
    own = mp.structure.terms
    found = aliases(own, named(mp, "N_u * u", "N_Fu * F_u", "N_vr * v * r"), mp.forces)
    assert [a.coefficient for a in found] == ["N_vr"]
    assert set(found[0].made_by) == {"N_ud", "N_uu", "N_u", "N_Fu"}
    assert aliases(own, named(mp, "N_u * u", "N_vr * v * r"), mp.forces) == ()
    again = named(mp, "Y_a * r")
    twice = aliases((*own, *again), [replace(again[0], coefficient="Y_c", number=2.0)], mp.forces)
    assert [(a.coefficient, a.made_by) for a in twice] == [("Y_c", ("Y_a",))]


def test_the_usual_candidates_are_new_to_the_vehicle_and_keep_its_names(mp):
    found = default_candidates(mp)
    texts = {t.text() for t in found}
    assert {"X_v * v", "Y_r * r", "N_Fu * F_u", "X_Fu3 * F_u * F_u * F_u", "N_0"} <= texts
    assert "N_uu * |u| * u" not in texts  # the file's own
    names = [t.coefficient for t in found]
    assert len(set(names)) == len(names)
    assert not set(names) & set(mp.structure.coefficients)
    ship = seatrial.load_vehicle(str(CSE1 / "coupled.yaml"))  # its X_rr is r r
    assert "X_rrx * |r| * r" in {t.text() for t in default_candidates(ship)}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("N_uu * |u| * u", "is there already: N_uu in yaw"),
        ("N_x * u * |u|", "is there already: N_uu in yaw"),
        ("X_u * v", "the name X_u is taken"),
        ("Y_r * q", "factor 'q'"),
        ("r * r", "no coefficient X_..., Y_... or N_..."),
    ],
)
def test_a_term_that_can_be_no_candidate_is_refused(text, said, mp):
    with pytest.raises(StructureError, match=said.replace("|", r"\|").replace(".", r"\.")):
        given_candidates(mp, [text])


def test_candidates_come_from_files_too(mp, tmp_path):
    (tmp_path / "more.yaml").write_text("surge: [X_v * v]\nyaw:\n  - N_v * v\n")
    found = given_candidates(mp, [str(tmp_path / "more.yaml"), "Y_r * r"])
    assert [t.coefficient for t in found] == ["X_v", "Y_r", "N_v"]
    (tmp_path / "odd.yaml").write_text("surge: X_v * v\n")
    with pytest.raises(StructureError, match="expected a list of terms"):
        given_candidates(mp, [str(tmp_path / "odd.yaml")])


def test_other_terms_stand_in_the_files_own_axes():
    """In forward-right-down axes -u r keeps its sign; what is chosen means the same boat."""
    ship = seatrial.load_vehicle(str(CSE1 / "coupled.yaml"))
    terms = (*ship.structure.terms, *given_candidates(ship, ["X_v * v"]))
    found = ship.with_terms(terms)
    assert sorted(t.text() for t in found.structure.terms) == sorted(t.text() for t in terms)
    assert "X_v * v" in found.file.structure["surge"]


def test_thrust_along_its_own_axis_and_known_terms_are_never_removed(mp):
    fixed = [t.text() for t in mp.structure.terms if is_essential(t, mp.forces)]
    assert fixed == ["v * r", "X_F * F_u", "-1 * u * r", "Y_F * F_v", "N_F * F_r"]
