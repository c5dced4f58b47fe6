# SPDX-License-Identifier: MIT
"""Thrust allocation for any geometry, against solvers of others: a QP's, and an LP's."""

from dataclasses import dataclass

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from test_allocation import table_one

import seatrial
from seatrial.boat.schema import AllocationEntry, ChainGroup, DeadZone, ThrusterEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.control.allocation import AllocatorScheme, effectiveness
from seatrial.control.allocation.allocator import IDLE_MARGIN
from seatrial.util.errors import AllocationError, VehicleError

SCHEMES = [s.value for s in AllocatorScheme]
MALLARD = seatrial.load_vehicle("mallard-mp")


def boat(
    places: list[tuple[float, float, float]],
    chain: list[ChainGroup] | None = None,
    limit: float = 1.0,
    F_os: float = 0.0,
) -> Vehicle:
    """MallARD's file with other thrusters: x, y [m], angle [deg]."""
    return Vehicle(
        msgspec.structs.replace(
            MALLARD.file,
            thrusters={f"T_{i}": ThrusterEntry(*place) for i, place in enumerate(places)},
            chain=[] if chain is None else chain,
            allocation=AllocationEntry("moore-penrose", F_os, limit),
        ),
        "boat",
    )


@st.composite
def boats(draw, least: int = 4) -> Vehicle:
    """Three to eight thrusters anywhere; unequal, unsymmetric, with a curve of their own each."""
    n = draw(st.integers(least, 8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    angles = rng.uniform(-180, 180, n)
    if draw(st.booleans()):  # thrusters in line, as on real boats
        angles = 45.0 * np.round(angles / 45.0)
    places = list(zip(rng.uniform(-1, 1, n), rng.uniform(-0.5, 0.5, n), angles, strict=True))
    gains = rng.uniform(0.7, 1.3, n)
    gains /= gains.mean() if n <= 6 else gains  # the chain has room for 32 constants
    chain = [
        ChainGroup(
            name=f"g{k}",
            actuators=[f"T_{k}"],
            dead_zone=DeadZone(*rng.uniform(0.02, 0.15, 2)),
            reverse_ratio=rng.uniform(0.6, 1.0),
            power=rng.choice([1.0, 1.5, 2.0]),
            gains=None,
        )
        for k in range(n)
    ]
    if n <= 6:
        chain.append(ChainGroup(gains={f"T_{k}": g for k, g in enumerate(gains)}))
    try:
        found = boat(places, chain)
        T = effectiveness(found).T
    except VehicleError:
        assume(False)
        raise
    assume(np.linalg.svd(T, compute_uv=False)[2] > 0.05)
    return found


@dataclass(frozen=True)
class Thrusts:
    """Bounds of thrusts (n,), and the function from commands to them, out of the vehicle file."""

    vehicle: Vehicle

    def of(self, commands: np.ndarray) -> np.ndarray:
        """Thrusts of commands (n,): the chain's formula, written again."""
        found = np.zeros(len(commands))
        groups = self.vehicle.file.chain
        for k, c in enumerate(commands):
            g = groups[k]
            edge = g.dead_zone.forward if c >= 0 else g.dead_zone.reverse
            past = max(0.0, (abs(c) - edge) / (1 - edge))
            full = 1.0 if c >= 0 else -g.reverse_ratio
            gain = (groups[-1].gains or {}).get(f"T_{k}", 1.0)
            found[k] = gain * full * past**g.power
        return found

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        n = len(self.vehicle.actuators)
        return self.of(-np.ones(n)), self.of(np.ones(n))


def wrenches(seed: int, T: np.ndarray, bounds, share: float, m: int = 5) -> np.ndarray:
    """Wrenches (m, 3) of random thrusts: within reach for share <= 1."""
    rng = np.random.default_rng(seed)
    low, high = bounds
    thrusts = share * rng.uniform(low, high, (m, len(low)))
    return thrusts @ T.T


def least_norm(T, F, low, high, weights=None) -> np.ndarray:
    """quadprog's: min y' W y with T y = F and bounds."""
    quadprog = pytest.importorskip("quadprog")
    n = T.shape[1]
    W = np.eye(n) if weights is None else np.diag(weights)
    C = np.hstack([T.T, np.eye(n), -np.eye(n)])
    return quadprog.solve_qp(W, np.zeros(n), C, np.concatenate([F, low, -high]), 3)[0]


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
    try:
        allocator = seatrial.Allocator(vehicle, "null-space")
    except AllocationError:
        assume(False)
    T, chain = effectiveness(vehicle).T, Thrusts(vehicle)
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
    try:
        allocator = seatrial.Allocator(vehicle, "null-space")
    except AllocationError:
        assume(False)
    T, chain = effectiveness(vehicle).T, Thrusts(vehicle)
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
    try:
        allocator = seatrial.Allocator(vehicle, scheme)
    except AllocationError:
        assume(False)
    T, chain = effectiveness(vehicle).T, Thrusts(vehicle)
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
    try:
        allocator = seatrial.Allocator(vehicle, scheme, hysteresis=0.05)
    except AllocationError:
        assume(False)
    T, chain = effectiveness(vehicle).T, Thrusts(vehicle)
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
