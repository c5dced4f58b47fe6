# SPDX-License-Identifier: MIT
"""What an allocator is told: bad settings, boats and wrenches are one clear line each."""

import numpy as np
import pytest
from allocation_boats import MALLARD, SCHEMES, boat

import seatrial
from seatrial.boat.allocation import Scheme
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.control.allocation import AllocatorScheme, compare_schemes
from seatrial.control.allocation.allocator import ranks
from seatrial.util.errors import AllocationError, VehicleError


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"scheme": "best"}, "no scheme 'best'; there are moore-penrose"),
        ({"priority": "yaw, surge"}, "priority 'yaw, surge': name surge, sway and yaw once each"),
        ({"limits": 0.03}, "leave no room below the limit 0.03; raise the limit"),
        ({"limits": {"T_9": 1.0}}, "limits names T_9; the thrusters are F_1"),
        ({"limits": -1.0}, "each must be a number above 0"),
        ({"margin": 1.5}, "leave no room below the limit 1"),
        ({"margin": float("nan")}, "margin nan: must be a number not below 0"),
        ({"hysteresis": -0.1}, "hysteresis -0.1: must be a number not below 0"),
    ],
)
def test_bad_settings_are_one_clear_line(change, says):
    with pytest.raises(AllocationError, match=says) as caught:
        seatrial.Allocator(MALLARD, **change)
    assert "\n" not in str(caught.value)


def test_bad_boats_are_one_clear_line(cse1_vehicle):
    square = [(0.2, 0.2, 135), (0.2, -0.2, -135), (-0.2, 0.2, 45), (-0.2, -0.2, -45)]
    wide = boat(square, [ChainGroup(dead_zone=DeadZone(0.6, 0.1))], limit=0.5)
    with pytest.raises(
        AllocationError, match=r"T_0: dead zone to 0.6 .* limit 0.5; raise the limit"
    ):
        seatrial.Allocator(wide)
    inside = boat(square, [ChainGroup(dead_zone=DeadZone(0.2, 0.1))], F_os=0.15)
    with pytest.raises(AllocationError, match=r"F_os 0.15 lies in the dead zone of T_0"):
        seatrial.Allocator(inside)
    falls = boat(square, [ChainGroup(table=[(-1, -1), (0, 0), (0.5, 1.2), (1, 1)])])
    with pytest.raises(AllocationError, match="can't be inverted"):
        seatrial.Allocator(falls)
    with pytest.raises(VehicleError, match="can't actuate surge, sway and yaw independently"):
        seatrial.Allocator(boat([(x, 0, 0) for x in (-0.2, 0, 0.2)]))
    with pytest.raises(AllocationError, match="give thrusters, or a model"):
        seatrial.Allocator(cse1_vehicle)
    open_ended = boat(square, [ChainGroup(latency="estimate")])
    with pytest.raises(AllocationError, match="leaves latency to be estimated"):
        seatrial.Allocator(open_ended)


def test_a_scheme_that_the_limits_rule_out_is_a_row_and_not_the_end():
    """Limits of 0.02: fewest-crossings finds no sides; auto and the comparison take the others."""
    square = [(0.2, 0.2, 135), (0.2, -0.2, -135), (-0.2, 0.2, 45), (-0.2, -0.2, -45)]
    narrow = boat(square, limit=0.02)
    with pytest.raises(AllocationError, match="limits leave hardly any wrench"):
        seatrial.Allocator(narrow, "fewest-crossings", margin=0.0)
    compared = compare_schemes(narrow, margin=0.0)
    assert compared.allocator.scheme is AllocatorScheme.MP
    rows = {row.name: row for row in compared.rows}
    assert rows["fewest-crossings"].allocator is None
    assert "limits leave hardly any wrench" in rows["fewest-crossings"].why
    # T of a square with thrusters at 45 degrees: two by two they add up in each axis
    reach = 0.02 * np.abs(compared.boat.T).sum(axis=1)
    np.testing.assert_allclose(rows["sign-pattern"].authority, np.column_stack([reach, reach]))


def test_auto_without_inversion_still_needs_curves_to_compare_by():
    square = [(0.2, 0.2, 135), (0.2, -0.2, -135), (-0.2, 0.2, 45), (-0.2, -0.2, -45)]
    falls = boat(square, [ChainGroup(table=[(-1, -1), (0, 0), (0.5, 1.2), (1, 1)])])
    assert seatrial.Allocator(falls, "moore-penrose", invert=False).scheme is AllocatorScheme.MP
    with pytest.raises(AllocationError, match="can't be inverted"):
        seatrial.Allocator(falls, invert=False)


def test_a_wrench_out_of_reach_is_refused_where_that_is_asked_for():
    allocator = seatrial.Allocator(MALLARD, "moore-penrose")
    with pytest.raises(AllocationError, match=r"wrench 4, 0, 0: moore-penrose reaches 0.5 of it"):
        allocator.allocate([4, 0, 0], saturate=False)
    np.testing.assert_allclose(
        allocator.wrench(allocator.allocate([4, 0, 0])), [2, 0, 0], atol=1e-12
    )
    with pytest.raises(AllocationError, match="not a finite number"):
        allocator.allocate([np.nan, 0, 0])
    with pytest.raises(AllocationError, match=r"shape \(2,\); expected \(3,\)"):
        allocator.allocate([1.0, 0.0])


def test_priorities_are_ranks():
    assert ranks("yaw, surge+sway") == [1, 1, 0]
    assert ranks("surge+sway+yaw") == [0, 0, 0]
    assert ranks("sway,yaw,surge") == [2, 0, 1]


def test_schemes_have_the_cores_numbers():
    assert [s.code for s in AllocatorScheme] == [0, 1, 2, 3, 4, 4]
    assert {s.value for s in Scheme} - {"direct"} <= set(SCHEMES)
