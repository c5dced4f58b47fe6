# SPDX-License-Identifier: MIT
"""Structures: text to terms, units, axis parity, and the right-hand side that they stand for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seatrial import _core
from seatrial.boat import structure
from seatrial.boat.structure import Force, parse
from seatrial.util.errors import StructureError

FORCES = (Force("F_u", 0), Force("F_v", 1), Force("F_r", 2))


def mallard():
    return parse("mallard", structure.named("mallard", "boat.yaml"), FORCES)


def test_mallard_is_the_papers_equation_12():
    s = mallard()
    assert s.coefficients == (
        "X_u", "X_uu", "X_F", "Y_v", "Y_vv", "Y_F", "N_ud", "N_r", "N_rr", "N_uu", "N_F",
    )  # fmt: skip
    rng = np.random.default_rng(0)
    theta = rng.normal(size=11)
    c = dict(zip(s.coefficients, theta, strict=True))
    nu, F = rng.normal(size=(50, 3)), rng.normal(size=(50, 3))
    u, v, r = nu.T
    u_dot = v * r + (c["X_uu"] * abs(u) + c["X_u"]) * u + c["X_F"] * F[:, 0]
    v_dot = -u * r + (c["Y_vv"] * abs(v) + c["Y_v"]) * v + c["Y_F"] * F[:, 1]
    r_dot = (
        c["N_ud"] * u_dot + (c["N_rr"] * abs(r) + c["N_r"]) * r
        + c["N_uu"] * abs(u) * u + c["N_F"] * F[:, 2]
    )  # fmt: skip
    got = _core.accelerations(s.compiled, theta, nu, F)
    np.testing.assert_allclose(got, np.column_stack([u_dot, v_dot, r_dot]), rtol=1e-13, atol=1e-13)


def test_accelerations_on_the_right_are_solved_together_not_in_order():
    s = parse(
        "cyclic",
        {"surge": ["X_F * F_u", "0.5 * r_dot"], "yaw": ["N_F * F_r", "0.4 * u_dot"], "sway": ["Y_v * v"]},
        FORCES,
    )  # fmt: skip
    F = np.array([[1.0, 0.0, 2.0]])
    got = _core.accelerations(s.compiled, np.array([1.0, -1.0, 1.0]), np.zeros((1, 3)), F)[0]
    expected = np.linalg.solve([[1, -0.5], [-0.4, 1]], [1.0, 2.0])
    np.testing.assert_allclose(got[[0, 2]], expected, rtol=1e-14)


def test_a_singular_acceleration_matrix_gives_nan_not_a_number():
    s = parse("bad", {"surge": ["X_u * u", "r_dot"], "yaw": ["N_r * r", "u_dot"]}, FORCES)
    got = _core.accelerations(s.compiled, np.ones(2), np.ones((1, 3)), np.zeros((1, 3)))
    assert np.isnan(got).all()


@pytest.mark.parametrize(
    ("name", "unit"),
    [("X_u", "1/s"), ("X_uu", "1/m"), ("X_F", "m/s^2"), ("N_r", "1/s"), ("N_rr", "1/rad"),
     ("N_F", "rad/s^2"), ("N_ud", "rad/m"), ("N_uu", "rad/m^2")],
)  # fmt: skip
def test_units_follow_from_the_factors(name, unit):
    assert mallard().units[name] == unit


def test_sign_changes_between_axis_systems_follow_the_parity_rule():
    # y, psi, v, r, F_v, F_r change sign: N_ud u_dot and N_uu |u| u do, drag and thrust do not
    assert mallard().flipped_coefficients == {"N_ud", "N_uu"}
    s = parse(
        "more", {"surge": ["X_vr * v * r", "X_r * r"], "sway": ["Y_r * r", "Y_u * u"]}, FORCES
    )
    assert s.flipped_coefficients == {"X_r", "Y_u"}


FACTORS = st.lists(
    st.sampled_from(["u", "v", "r", "|u|", "|v|", "|r|", "F_u", "F_v", "F_r"]), max_size=4
)


@given(
    st.lists(st.tuples(st.integers(0, 2), FACTORS, st.sampled_from([None, 0, 1, 2])), min_size=1, max_size=8),
    st.integers(0, 2**31),
)  # fmt: skip
def test_a_flipped_structure_is_the_same_boat_seen_in_the_other_axes(rows, seed):
    lines = {"surge": [], "sway": [], "yaw": []}
    for i, (axis, factors, acceleration) in enumerate(rows):
        extra = [structure.ACCELERATIONS[acceleration]] if acceleration not in (None, axis) else []
        coefficient = [f"{'XYN'[axis]}_{i}"] if i % 2 == 0 else ["0.7"]
        lines[("surge", "sway", "yaw")[axis]].append(" * ".join([*coefficient, *factors, *extra]))
    s = parse("random", lines, FORCES)
    rng = np.random.default_rng(seed)
    theta = rng.normal(size=len(s.coefficients)) * 0.2
    nu, F = rng.normal(size=(5, 3)) * 0.5, rng.normal(size=(5, 3)) * 0.5
    sign = np.array([1.0, -1.0, -1.0])
    flips = np.array([-1.0 if c in s.flipped_coefficients else 1.0 for c in s.coefficients])
    here = _core.accelerations(s.compiled, theta, nu, F)
    there = _core.accelerations(s.flipped().compiled, theta * flips, nu * sign, F * sign)
    np.testing.assert_allclose(there * sign, here, rtol=1e-9, atol=1e-9)


def test_text_and_terms_are_each_others_inverse():
    s = mallard()
    assert parse("again", s.lines(), FORCES).terms == s.terms
    known = parse("known", {"surge": ["-1.23456789 * u", "1.5e-07 * X_v * v"]}, FORCES)
    assert parse("again", known.lines(), FORCES).terms == known.terms


def test_equations_read_with_names_and_with_numbers():
    s = mallard()
    assert s.equation(0) == "u_dot = v r + X_u u + X_uu |u| u + X_F F_u"
    values = dict.fromkeys(s.coefficients, -0.5)
    assert s.equation(1, values) == "v_dot = -u r - 0.5 v - 0.5 |v| v - 0.5 F_v"


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("X_u * w", "factor 'w'"),
        ("X_u * X_v * u", "two coefficients"),
        ("X_u * u * u * u * u * u", "5 factors"),
        ("X_d * u_dot", "own axis' acceleration"),
        ("X_d * v_dot * r_dot", "two accelerations"),
        ("X_u * F_x", "factor 'F_x'"),
    ],
)
def test_what_is_wrong_with_a_term_is_said(line, words):
    with pytest.raises(StructureError, match=words.replace("'", ".")):
        parse("s", {"surge": [line]}, FORCES)


@pytest.mark.parametrize(
    ("count", "words"), [(40, "41 coefficients; at most 37"), (46, "47 terms")]
)
def test_more_than_the_filter_has_room_for_is_one_line(count, words):
    lines = {"surge": ["X_F * F_u", *(f"X_a{i} * u" for i in range(count))]}
    with pytest.raises(StructureError, match=words):
        parse("many", lines, FORCES)
    parse("full", {"surge": lines["surge"][:37]}, FORCES)


def test_a_coefficient_shared_by_terms_of_different_parity_is_refused():
    with pytest.raises(StructureError, match="give them different names"):
        parse("s", {"surge": ["X_a * u", "X_a * v"]}, FORCES)


def test_unknown_names_list_what_there_is():
    with pytest.raises(StructureError, match=r"boat\.yaml: no structure .*there are mallard"):
        structure.named("malard", "boat.yaml")
    with pytest.raises(StructureError, match="unknown axis 'heave'"):
        parse("s", {"heave": ["X_u * u"]}, FORCES)
    with pytest.raises(StructureError, match="no coefficient"):
        parse("s", {"surge": ["v * r"]}, FORCES)
