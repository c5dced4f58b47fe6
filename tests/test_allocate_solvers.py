# SPDX-License-Identifier: MIT
"""Thrust allocation for any geometry, against solvers of others: a QP's, and an LP's."""

import numpy as np
import pytest
from allocation_boats import Thrusts, boats, wrenches
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import seatrial
from seatrial.control.allocation import effectiveness
from seatrial.control.allocation.allocator import IDLE_MARGIN
from seatrial.util.errors import AllocationError


def least_norm(T, F, low, high, weights=None) -> np.ndarray:
    """quadprog's: min y' W y with T y = F and bounds."""
    quadprog = pytest.importorskip("quadprog")
    n = T.shape[1]
    W = np.eye(n) if weights is None else np.diag(weights)
    C = np.hstack([T.T, np.eye(n), -np.eye(n)])
    return quadprog.solve_qp(W, np.zeros(n), C, np.concatenate([F, low, -high]), 3)[0]


def allocated(vehicle, scheme, **options):
    """Its allocator where the scheme is for this boat, T (3, n), and its thrusts."""
    try:
        allocator = seatrial.Allocator(vehicle, scheme, **options)
    except AllocationError:
        assume(False)
    return allocator, effectiveness(vehicle).T, Thrusts(vehicle)


@given(vehicle=boats(), seed=st.integers(0, 10**6), share=st.sampled_from([0.2, 0.6, 0.95]))
@settings(max_examples=60)
def test_least_thrust_is_the_qps(vehicle, seed, share):
    allocator = seatrial.Allocator(vehicle, "moore-penrose")
    T, chain = effectiveness(vehicle).T, Thrusts(vehicle)
    for F in wrenches(seed, T, chain.bounds, share):
        y = chain.of(allocator.allocate(F))
        np.testing.assert_allclose(T @ y, F, atol=1e-10)
        np.testing.assert_allclose(y, least_norm(T, F, *chain.bounds), atol=1e-7)


@given(vehicle=boats(), seed=st.integers(0, 10**6))
@settings(max_examples=60)
def test_the_bias_is_the_qps_with_every_thruster_past_its_idle_command(vehicle, seed):
    """The same weights, bounds on each thruster's own side: the same thrusts."""
    allocator, T, chain = allocated(vehicle, "null-space")
    side, (low, high) = allocator.sides, chain.bounds
    n = len(side)
    idle_at = np.where(side > 0, allocator.edges[0], -allocator.edges[1]) + side * IDLE_MARGIN
    floor = chain.of(idle_at)
    low, high = np.where(side > 0, floor, low), np.where(side > 0, high, floor)
    at_rest = chain.of(allocator.idle)
    full = np.abs(chain.of(side))
    # weights with which the least square at rest is the least power there
    weights = 1.0 / (full**2 * np.sqrt(np.abs(at_rest) / full))
    for F in [np.zeros(3), *0.3 * wrenches(seed, T, (low, high), 1.0)]:
        reach = allocator.reach(F[None, :])[0] if F.any() else 1.0
        F = F * min(1.0, 0.9 * reach)  # noqa: PLW2901
        commands = allocator.allocate(F)
        assert np.all(side * commands >= side * idle_at - 1e-9)
        y = chain.of(commands)
        np.testing.assert_allclose(T @ y, F, atol=1e-10)
        np.testing.assert_allclose(allocator.thrust(commands), y, atol=1e-12)
        np.testing.assert_allclose(allocator.commands(y), commands, atol=1e-12)
        np.testing.assert_allclose(y, least_norm(T, F, low, high, weights), atol=1e-6)
    assert len(allocator.switching) == 0
    assert n == len(commands)


@given(vehicle=boats())
@settings(max_examples=12)
def test_idling_takes_the_least_power_of_all_sides(vehicle):
    """SciPy's minimum of sum |y / full|^(3/2) over the null space, for every way to run."""
    optimize = pytest.importorskip("scipy.optimize")
    assume(len(vehicle.actuators) <= 6)
    allocator, T, chain = allocated(vehicle, "null-space")
    n = T.shape[1]
    low, high = chain.bounds
    found = {}

    def power(y):
        return float(np.sum((np.abs(y) / np.where(y >= 0, high, -low)) ** 1.5))

    for code in range(2**n):
        side = np.array([1 if code >> k & 1 else -1 for k in range(n)])
        floor = chain.of(
            np.where(side > 0, allocator.edges[0], -allocator.edges[1]) + side * IDLE_MARGIN
        )
        ends = np.where(side > 0, floor, low), np.where(side > 0, high, floor)
        authority = depth(T, *ends, np.zeros(3))
        if authority < 0.05:
            continue
        best = optimize.minimize(
            power, optimize.lsq_linear(T, np.zeros(3), ends).x, bounds=list(zip(*ends, strict=True)),
            method="SLSQP", constraints={"type": "eq", "fun": lambda y: T @ y},
            options={"ftol": 1e-14, "maxiter": 300},
        )  # fmt: skip
        assert np.abs(T @ best.x).max() < 1e-8
        found[tuple(side)] = best.fun, authority
    own = allocator.idle_power
    assert own == pytest.approx(power(chain.of(allocator.idle)), rel=1e-9)
    assert own == pytest.approx(found[tuple(allocator.sides)][0], rel=1e-3)
    least = min(p for p, _ in found.values())
    assert own <= 1.051 * least
    most = max(a for p, a in found.values() if p < 1.049 * least)
    assert found[tuple(allocator.sides)][1] > 0.98 * most


def depth(T, low, high, F) -> float:
    """How far F is inside the attainable set: an LP in every direction that a face may have."""
    least = np.inf
    n = T.shape[1]
    for i in range(n):
        for j in range(i + 1, n):
            normal = np.cross(T[:, i], T[:, j])
            if np.linalg.norm(normal) < 1e-9:
                continue
            for direction in (normal, -normal):
                d = direction / np.linalg.norm(direction)
                least = min(least, np.maximum(d @ T * low, d @ T * high).sum() - d @ F)
    return least


@given(vehicle=boats(), seed=st.integers(0, 10**6), scheme=st.sampled_from(["moore-penrose", "null-space"]))  # fmt: skip
@settings(max_examples=25)
def test_saturation_takes_as_much_as_the_lp_says_yaw_first(vehicle, seed, scheme):
    """HiGHS: the largest share of yaw, then with that the largest of surge and sway together."""
    optimize = pytest.importorskip("scipy.optimize")
    allocator, T, chain = allocated(vehicle, scheme)
    low, high = chain.bounds
    side = allocator.sides
    floor = chain.of(
        np.where(side > 0, allocator.edges[0], -allocator.edges[1]) + side * IDLE_MARGIN
    )
    low, high = np.where(side > 0, floor, low), np.where(side < 0, floor, high)

    def most(first, yaw, rest):
        """max a, or with no less than a given a the max b, with T y = a yaw + b rest, 0 <= a, b <= 1."""
        cost = np.append(np.zeros(len(low)), [-1.0, 0.0] if first is None else [0.0, -1.0])
        ends = (0 if first is None else first, 1)
        found = optimize.linprog(
            cost, A_eq=np.column_stack([T, -yaw, -rest]), b_eq=np.zeros(3),
            bounds=[*zip(low, high, strict=True), ends, (0, 1)],
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )  # fmt: skip
        assert found.status == 0
        return found.x[-2 if first is None else -1]

    for F in wrenches(seed, T, chain.bounds, 2.5, 3):
        yaw, rest = np.array([0, 0, F[2]]), np.array([F[0], F[1], 0])
        commands, shares, _ = allocator.allot(F[None, :])
        first = most(None, yaw, rest)
        second = most(shares[0, 2], yaw, rest)
        np.testing.assert_allclose(shares[0], [second, second, first], atol=1e-6)
        np.testing.assert_allclose(allocator.wrench(commands[0]), shares[0] * F, atol=1e-9)
        np.testing.assert_allclose(T @ chain.of(commands[0]), shares[0] * F, atol=1e-9)


@given(vehicle=boats(), seed=st.integers(0, 10**6))
@settings(max_examples=30)
def test_reach_is_the_lps(vehicle, seed):
    optimize = pytest.importorskip("scipy.optimize")
    allocator = seatrial.Allocator(vehicle, "moore-penrose")
    T, (low, high) = effectiveness(vehicle).T, Thrusts(vehicle).bounds
    for F in wrenches(seed, T, (low, high), 1.0, 3):
        found = optimize.linprog(
            np.append(np.zeros(len(low)), -1.0), A_eq=np.column_stack([T, -F]), b_eq=np.zeros(3),
            bounds=[*zip(low, high, strict=True), (0, None)],
        )  # fmt: skip
        assert allocator.reach(F[None, :])[0] == pytest.approx(found.x[-1], rel=1e-7)


@given(vehicle=boats(least=3), seed=st.integers(0, 10**6), scheme=st.sampled_from(["sign-pattern", "fewest-crossings"]))  # fmt: skip
@settings(max_examples=15)
def test_sides_change_only_for_more_than_the_hysteresis(vehicle, seed, scheme):
    """Held wrenches are the nearest that SciPy finds without a change of side, and near enough."""
    optimize = pytest.importorskip("scipy.optimize")
    allocator, T, chain = allocated(vehicle, scheme, hysteresis=0.05)
    walk = np.cumsum(0.05 * np.random.default_rng(seed).normal(size=(40, 3)), axis=0)
    before = np.where(allocator.sides == 0, 1.0, allocator.sides)
    for F in walk:
        commands, shares, held = (x[0] for x in allocator.allot(F[None, :]))
        edges = np.where(commands > 0, allocator.edges[0], allocator.edges[1])
        assert np.all(np.abs(commands) >= edges - 1e-12)
        now = np.sign(commands)
        off = np.linalg.norm(T @ chain.of(commands) - shares * F, ord=np.inf)
        assert off <= (0.05 if held else 1e-9) + 1e-12
        nearest = optimize.lsq_linear(T, shares * F, kept(allocator, chain, before)).cost
        if np.any(now != before):
            assert np.sqrt(2 * nearest) > 1e-9  # no change without need
        elif held:
            assert off <= np.sqrt(2 * nearest) + 1e-6
        before = now


def kept(allocator, chain, side):
    """Bounds of thrust on the sides of now."""
    low, high = chain.bounds
    switches = allocator.sides == 0
    at = (
        np.where(side > 0, allocator.edges[0], -allocator.edges[1]) + side * IDLE_MARGIN * ~switches
    )
    floor = np.where(switches, 0.0, chain.of(at))
    low, high = np.where(side > 0, floor, low), np.where(side > 0, high, floor)
    return low - 1e-9, high + 1e-9
