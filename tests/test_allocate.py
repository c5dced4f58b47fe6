# SPDX-License-Identifier: MIT
"""Schemes of thrust allocation: the paper's, which is chosen for a geometry, which thrusters switch."""

import numpy as np
import pytest
from allocation_boats import MALLARD, Thrusts, boat, wrenches
from hypothesis import given
from hypothesis import strategies as st
from test_allocation import table_one

import seatrial
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.control.allocation import AllocatorScheme, effectiveness
from seatrial.util.errors import AllocationError


@given(wrench=st.tuples(*[st.floats(-0.29, 0.29)] * 3))
def test_always_forward_is_table_one_of_the_paper(wrench):
    allocator = seatrial.Allocator(seatrial.load_vehicle("mallard-af"), "always-forward")
    np.testing.assert_allclose(allocator.allocate(wrench), table_one(wrench, 0.12), atol=1e-15)


@given(wrench=st.tuples(*[st.floats(-0.29, 0.29)] * 3))
def test_the_bias_of_least_power_saves_what_table_one_gives_all_four_alike(wrench):
    """MallARD's null space is [1 1 1 1]: Table I less its smallest, down to F_os."""
    af = table_one(wrench, 0.12)
    allocator = seatrial.Allocator(seatrial.load_vehicle("mallard-af"), "fewest-crossings")
    assert allocator.scheme is AllocatorScheme.NULL_SPACE
    np.testing.assert_allclose(allocator.allocate(wrench), af - af.min() + 0.12, atol=1e-12)


def test_plain_moore_penrose_is_the_papers():
    allocator = seatrial.Allocator(MALLARD, "moore-penrose", invert=False)
    F = np.array([0.3, -0.4, 0.1])
    np.testing.assert_allclose(
        allocator.allocate(F), np.linalg.pinv(effectiveness(MALLARD).T) @ F, atol=1e-12
    )


def test_three_thrusters_switch_and_say_so():
    tri = boat([(np.cos(a), np.sin(a), np.rad2deg(a) + 90) for a in np.arange(3) * 2.0944])
    allocator = seatrial.Allocator(tri, "fewest-crossings")
    assert allocator.scheme is AllocatorScheme.SIGN_PATTERN
    assert allocator.switching == ("T_0", "T_1", "T_2")
    assert "hysteresis" in allocator.why
    with pytest.raises(AllocationError, match=r"null space .* use auto"):
        seatrial.Allocator(tri, "null-space")
    with pytest.raises(
        AllocationError, match="always-forward needs thrusters whose wrenches cancel"
    ):
        seatrial.Allocator(tri, "always-forward")


def test_a_thruster_alone_on_its_axis_switches_and_the_others_idle():
    """Two pairs that push along and turn, and one bow thruster: sway is its alone."""
    places = [(0.5, 0.3, 0), (0.5, -0.3, 0), (-0.5, 0.2, 0), (-0.5, -0.2, 0), (0, 0, 90)]
    vehicle = boat(places, [ChainGroup(dead_zone=DeadZone(0.1, 0.1))])
    allocator = seatrial.Allocator(vehicle, "fewest-crossings")
    assert allocator.switching == ("T_4",)
    assert allocator.scheme is AllocatorScheme.FEWEST
    assert sorted(allocator.sides[:4]) == [-1, -1, 1, 1]  # both directions of run
    np.testing.assert_allclose(allocator.wrench(allocator.idle), 0.0, atol=1e-12)
    assert allocator.idle[4] == pytest.approx(0.1)  # waits at its edge


def test_a_bias_that_the_limits_leave_no_room_for_is_not_taken():
    """The long lever's thruster would have to idle at ten times the short one's."""
    places = [(1.0, 0, 90), (-0.05, 0, 90), (-1.0, 0, 90), (0, 0.01, 0), (0, -0.01, 0)]
    zone = [ChainGroup(dead_zone=DeadZone(0.1, 0.1))]
    easy = seatrial.Allocator(boat(places, zone), "fewest-crossings")
    tight = seatrial.Allocator(boat(places, zone), "fewest-crossings", margin=0.6, limits=0.75)
    assert len(tight.switching) > len(easy.switching)
    np.testing.assert_allclose(tight.wrench(tight.idle), 0.0, atol=1e-12)


def test_a_models_coefficients_weigh_its_forces(cse1_vehicle):
    from conftest import make_model

    values = {name: 0.1 * (i + 1) for i, name in enumerate(cse1_vehicle.structure.coefficients)}
    model = make_model(cse1_vehicle, values)
    found = effectiveness(model)
    by_hand = np.zeros((3, 5))
    own = model.values
    by_hand[0, [0, 2]] = own["X_F"] / 2
    by_hand[1, [1, 3]], by_hand[1, 4] = -own["Y_F"] / 2, -own["Y_b"]
    by_hand[2, [1, 3]], by_hand[2, 4] = -own["N_F"] / 2, -own["N_b"]
    by_hand[2, [0, 2]] = -own["N_d"] / 2, own["N_d"] / 2
    np.testing.assert_allclose(np.abs(found.T * found.scale[:, None]), np.abs(by_hand), atol=1e-12)
    allocator = seatrial.Allocator(model)
    F = np.array([0.1, -0.05, 0.1])
    np.testing.assert_allclose(allocator.wrench(allocator.allocate(F)), F, atol=1e-12)
    # the wrench is what the core's right-hand side gets
    from seatrial import _core

    c = allocator.allocate(F)
    forces = model.vehicle.mix @ c
    moved = _core.accelerations(
        model.structure.compiled, model.coefficients, np.zeros((1, 3)), forces[None, :]
    )[0]
    accelerated = found.scale * F
    accelerated[2] += model.values["N_ud"] * accelerated[0]  # yaw hangs on surge by N_ud u_dot
    np.testing.assert_allclose(moved, accelerated, atol=1e-12)


@pytest.mark.parametrize("size", [0.02, 0.1, 0.25])
def test_auto_has_the_least_wrench_error_then_the_least_power(size):
    """Every scheme by hand over the same wrenches: with the curves inverted, and without."""
    vehicle = boat(
        [(0.2, 0.2, 135), (0.2, -0.2, -135), (-0.2, 0.2, 45), (-0.2, -0.2, -45)],
        [
            ChainGroup(
                name=f"g{k}", actuators=[f"T_{k}"], dead_zone=DeadZone(size, size), reverse_ratio=1.0, power=1.0
            )
            for k in range(4)
        ],
    )  # fmt: skip
    T, chain = effectiveness(vehicle).T, Thrusts(vehicle)
    demands = wrenches(3, T, chain.bounds, 0.3, 60)
    for invert in (True, False):
        scores = {}
        for scheme in ("moore-penrose", "sign-pattern", "fewest-crossings"):
            own = seatrial.Allocator(vehicle, scheme, invert=invert)
            thrust = np.array([chain.of(c) for c in own.allocate(demands)])
            error = np.sqrt(np.mean((thrust @ T.T - demands) ** 2))
            scores[own.scheme] = round(error, 9), np.mean(np.sum(np.abs(thrust) ** 1.5, axis=1))
        chosen = seatrial.Allocator(vehicle, invert=invert, demands=demands)
        assert chosen.scheme is min(scores, key=scores.get), (invert, scores)
        assert chosen.why.startswith("least wrench error, then least power: ")
    assert seatrial.Allocator(vehicle).scheme is AllocatorScheme.MP
