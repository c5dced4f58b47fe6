# SPDX-License-Identifier: MIT
"""Thrust allocation of a boat without sway thrust: two thrusters, surge and yaw."""

import numpy as np
import pytest

import seatrial
from seatrial.control.allocation import AllocatorScheme
from seatrial.util.errors import AllocationError


@pytest.fixture(scope="module")
def twin():
    """Two thrusters astern, unequal dead zones, weaker astern; the file states both forces."""
    from survey_boat import boat as survey

    chain = [{"dead_zone": {"forward": 0.08, "reverse": 0.12}, "reverse_ratio": 0.6, "power": 1.5}]
    return survey(chain)


@pytest.mark.parametrize("scheme", ["moore-penrose", "sign-pattern", "fewest-crossings", "auto"])
def test_a_boat_without_sway_thrust_is_allocated_in_surge_and_yaw(twin, scheme):
    """Two thrusters, two axes: the commands are the only ones that give the wrench."""
    allocator = seatrial.Allocator(twin, scheme)
    assert allocator.boat.driven == (0, 2)
    rng = np.random.default_rng(4)
    low, high = allocator.thrust([-1.0, -1.0]), allocator.thrust([1.0, 1.0])
    np.testing.assert_allclose(low, -0.6, atol=1e-12)
    T = allocator.boat.T[[0, 2]]
    for y in rng.uniform(low, high, (40, 2)):
        F = T @ y
        commands, shares, held = allocator.allot(np.array([[F[0], 0.0, F[1]]]))
        given = allocator.wrench(commands[0])
        np.testing.assert_allclose(
            given, [F[0], 0.0, F[1]], atol=1e-9 + allocator.hysteresis * held[0]
        )
        np.testing.assert_array_equal(shares, 1.0)


def test_differential_limits_are_the_linear_programmes(twin):
    """Yaw beside surge: SciPy's largest, for every surge."""
    from seatrial.control.allocation.schemes import authority, yaw_beside_surge

    optimize = pytest.importorskip("scipy.optimize")
    allocator = seatrial.Allocator(twin)
    T = allocator.boat.T
    bounds = [(-0.6, 1.0)] * 2
    for surge, right, left in yaw_beside_surge(allocator):
        for sign, found in ((-1.0, right), (1.0, left)):
            best = optimize.linprog(-sign * T[2], A_eq=T[:1], b_eq=[surge], bounds=bounds)
            assert found == pytest.approx(-best.fun, abs=1e-6)
    most = authority(allocator)
    np.testing.assert_array_equal(most[1], 0.0)
    assert most[0] == pytest.approx([2 / np.sqrt(2), 1.2 / np.sqrt(2)])
    assert most[2] == pytest.approx([1.2 / np.sqrt(2)] * 2)  # one ahead as far as the other astern


def test_at_the_limits_yaw_keeps_its_share_and_sway_gets_none(twin):
    allocator = seatrial.Allocator(twin)
    commands, shares, _ = allocator.allot(np.array([[1.4, 0.0, 0.8], [0.1, 0.3, 0.1]]))
    assert shares[0, 2] == 1.0 and 0.0 < shares[0, 0] < 1.0
    given = allocator.wrench(commands)
    assert given[0, 2] == pytest.approx(0.8)
    assert given[0, 0] == pytest.approx(shares[0, 0] * 1.4)
    assert shares[1].tolist() == [1.0, 0.0, 1.0]
    np.testing.assert_allclose(given[1], [0.1, 0.0, 0.1], atol=1e-12)
    with pytest.raises(AllocationError, match=r"wrench 0, 0.1, 0: .* reaches 0 of it"):
        allocator.allocate([0.0, 0.1, 0.0], saturate=False)


def test_two_thrusters_have_no_bias(twin):
    with pytest.raises(
        AllocationError, match=r"no bias within the limits that keeps all of left, right"
    ):
        seatrial.Allocator(twin, "null-space")
    with pytest.raises(AllocationError, match="always-forward needs thrusters"):
        seatrial.Allocator(twin, "always-forward")
    assert seatrial.Allocator(twin, "fewest-crossings").scheme is AllocatorScheme.SIGN_PATTERN
