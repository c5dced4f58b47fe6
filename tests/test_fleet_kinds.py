# SPDX-License-Identifier: MIT
"""Boats of a kind are compared, and their figure shows the numbers that the test and the table have."""

import numpy as np
import pytest

from seatrial.fleet.fleet import _together
from seatrial.fleet.kinds import FEWEST_BOATS, centre_of, compare_kind
from seatrial.fleet.page import _picture
from seatrial.fleet.results import BoatResult, Estimate


def made_up(name, value, error=0.01, structure="s"):
    one = {"X_F": Estimate(value, error, "m/s^2")}
    return BoatResult(name, "k", "", None, [], structure, one, {}, [], None)


def test_a_boat_is_drawn_at_its_z(tmp_path):
    """Of few boats the error of the centre counts as well."""
    values, errors = np.array([1.0, 1.02, 0.98, 1.01, 0.99, 1.6]), np.full(6, 0.02)
    boats = [made_up(f"b{i}", *pair) for i, pair in enumerate(zip(values, errors, strict=True))]
    found = _together("fleet", boats, tmp_path)
    (odd,) = found.boats[5].differs
    drawn = {
        name: x
        for trace in _picture(found, "k")["data"]
        for name, x in zip(trace["text"], trace["x"], strict=True)
    }
    assert drawn["b5"] == pytest.approx(odd.z)
    centre = centre_of(values, errors)
    spread = np.sqrt(errors**2 + centre.between**2 + centre.error**2)
    expected = dict(zip(drawn, (values - centre.value) / spread, strict=True))
    assert drawn == pytest.approx(expected)


def test_an_odd_boat_differs_from_its_kind_and_does_not_move_it():
    rng = np.random.default_rng(4)
    values = 1.0 + 0.05 * rng.normal(size=20)
    values[7] = 2.0
    found = compare_kind([made_up(f"b{i}", float(v)) for i, v in enumerate(values)])
    assert list(found.differs) == ["b7"]
    (one,) = found.differs["b7"]
    assert one.centre == pytest.approx(1.0, abs=0.03) and one.z > 10
    assert found.kind.parameters["X_F"].between == pytest.approx(
        np.delete(values, 7).std(), rel=0.3
    )


def test_errors_alone_leave_nothing_between_boats():
    rng = np.random.default_rng(2)
    between = [
        centre_of(1.0 + 0.1 * rng.normal(size=30), np.full(30, 0.1)).between for _ in range(40)
    ]
    assert np.median(between) < 0.04


def test_boats_of_a_kind_are_seldom_called_different():
    rng = np.random.default_rng(1)
    alarms = 0
    for _ in range(200):
        errors = rng.uniform(0.01, 0.1, size=12)
        values = 1.0 + np.hypot(errors, 0.05) * rng.normal(size=12)
        one = [
            made_up(f"b{i}", float(v), float(e))
            for i, (v, e) in enumerate(zip(values, errors, strict=True))
        ]
        alarms += bool(compare_kind(one).differs)
    assert alarms <= 18  # 10 expected at 5 %; binomial 99 %


def test_few_boats_and_another_structure_are_not_compared():
    few = compare_kind([made_up(f"b{i}", 1.0) for i in range(FEWEST_BOATS - 1)])
    assert not few.kind.parameters and all(
        "or more can be compared" in w for w in few.not_compared.values()
    )
    more = [made_up(f"b{i}", 1.0) for i in range(FEWEST_BOATS)]
    odd = compare_kind([*more, made_up("odd", 1.0, structure="other")])
    assert list(odd.not_compared) == ["odd"] and odd.kind.compared == FEWEST_BOATS
