# SPDX-License-Identifier: MIT
"""The core through Python against independent mathematics: SciPy's integrator, differences."""

import itertools
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import TABLE_II, make_model
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import seatrial
from seatrial import _core
from seatrial.boat.schema import ChainGroup, DeadZone
from seatrial.boat.vehicle import vehicle_from
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from tests.boats.by_hand import rates

CHAIN = [
    ChainGroup(latency=0.037, dead_zone=DeadZone(0.08, 0.1), reverse_ratio=0.8, power=1.3, lag=0.09)
]


def pulses(seed: int, seconds: float = 6.0) -> Signal:
    rng = np.random.default_rng(seed)
    t = np.sort(rng.uniform(0, seconds, 25))
    values = rng.uniform(-0.65, 0.65, (25, 3))  # below the limit of allocation
    return Signal(("F_u", "F_v", "F_r"), np.rint(t * 1e9).astype(np.int64), values)


def recording(seed: int = 0, rate: float = 15.0, seconds: float = 6.0):
    t = np.rint(np.arange(0, seconds, 1 / rate) * 1e9).astype(np.int64)
    return make_recording(
        "made", t, np.cumsum(np.full((len(t), 3), 0.01), axis=0), pulses(seed, seconds)
    )


S = np.array([[-1, -1, 1, 1], [1, -1, 1, -1], [1, -1, -1, 1]])  # Table I


def thrust_targets(model, record):
    """When each thruster's target changes, to what, and the lag; the chain in plain NumPy."""
    latency, ahead, behind, ratio, power, lag = model.constants
    f = record.commands.values @ S / 2
    w = np.where(f >= 0, (f - ahead) / (1 - ahead), (-f - behind) / (1 - behind))
    target = np.where(w > 0, np.where(f >= 0, 1, -ratio) * np.abs(w) ** power, 0.0)
    return record.seconds(record.commands.stamps) + latency, target, lag


def reference(model, record, x0, times):
    """The same boat in plain Python: SciPy's integrator between command changes."""
    t_c, target, lag = thrust_targets(model, record)

    def rate(t, state, goal):
        motion = rates(model.values, state[:6], S @ state[6:] / 2)
        return np.concatenate([motion, (goal - state[6:]) / lag])

    edges = np.unique(np.concatenate([times, t_c[(t_c > times[0]) & (t_c < times[-1])]]))
    # thruster states at the start: the history's exponential, from a long time before
    level = target[0].copy()
    past = np.append(t_c[t_c < times[0]], times[0])
    for i in range(len(past) - 1):
        level = target[i] + (level - target[i]) * np.exp(-(past[i + 1] - past[i]) / lag)
    state, out = np.concatenate([x0, level]), {times[0]: x0}
    for a, b in itertools.pairwise(edges):
        goal = target[max(np.searchsorted(t_c, (a + b) / 2) - 1, 0)]
        state = solve_ivp(rate, (a, b), state, args=(goal,), rtol=1e-10, atol=1e-12).y[:, -1]
        out[b] = state[:6]
    return np.array([out[t] for t in times])


@pytest.fixture(scope="module")
def model(mp):
    return make_model(mp.with_chain(CHAIN), TABLE_II["AF"])


def test_simulation_equals_scipys_integrator_with_the_whole_chain(model):
    record = recording()
    x0 = np.array([0.1, -0.2, 0.3, 0.05, -0.1, 0.4])
    times = record.t[20:80]
    got, _ = _core.simulate(model.boat, model.trace(record), x0, times)
    np.testing.assert_allclose(got, reference(model, record, x0, times), atol=2e-7)


def test_forces_along_a_recording_equal_the_closed_form(model):
    record = recording(1)
    t = np.linspace(-1, 7, 500)
    got = model.trace(record).forces(t)
    # by brute force: a fine exact recursion from before the first command
    t_c, target, lag = thrust_targets(model, record)
    for i, now in enumerate(t):
        level = target[0]
        for k, begin in enumerate(t_c):
            if begin > now:
                break
            end = min(now, t_c[k + 1]) if k + 1 < len(t_c) else now
            level = target[k] + (level - target[k]) * np.exp(-(end - begin) / lag)
        np.testing.assert_allclose(got[i], S @ level / 2, atol=1e-12)


def test_prediction_from_every_start_equals_simulations_one_by_one(model):
    record = recording(2)
    rng = np.random.default_rng(3)
    start = np.arange(0, 70, dtype=np.int32)
    x0 = rng.normal(0, 0.2, (70, 6))
    got, _ = _core.predict(model.boat, model.trace(record), record.t, start, start + 15, x0)
    for j in (0, 13, 69):
        one, _ = _core.simulate(model.boat, model.trace(record), x0[j], record.t[j : j + 16])
        np.testing.assert_allclose(got[j], one[-1], atol=1e-13)


def test_the_number_of_threads_does_not_change_a_bit(model):
    record = recording(2, rate=150.0)
    start = np.arange(0, 800, dtype=np.int32)
    x0 = np.random.default_rng(3).normal(0, 0.2, (800, 6))
    runs = [
        _core.predict(model.boat, model.trace(record), record.t, start, start + 15, x0, threads=n)[
            0
        ]
        for n in (1, 2, 5)
    ]
    assert np.array_equal(runs[0], runs[1])
    assert np.array_equal(runs[0], runs[2])


@pytest.mark.parametrize("scheme", ["runge-kutta", "forward-euler"])
def test_sensitivities_equal_finite_differences(mp, scheme):
    vehicle = mp.with_chain(CHAIN)
    values = np.array([TABLE_II["AF"][n] for n in vehicle.structure.coefficients])
    q = vehicle.constants.values
    record = recording(4)
    x0 = np.array([0.1, -0.2, 0.3, 0.15, -0.1, 0.4])
    code = {"runge-kutta": 0, "forward-euler": 1}[scheme]

    def run(p, tangents=False):
        from seatrial.boat.model import thrust_trace

        boat = _core.Boat(vehicle.structure.compiled, p[6:17], code, 1 / 60)
        trace = thrust_trace(
            vehicle, p[17:], record, initial=True, coefficients=range(11), tangents=range(len(q))
        )
        return _core.simulate(boat, trace, p[:6], record.t[10:60], sensitivities=tangents)

    p = np.concatenate([x0, values, q])
    states, slopes = run(p, tangents=True)
    np.testing.assert_allclose(states, run(p)[0], atol=1e-12)
    for i in range(len(p)):
        if scheme == "forward-euler" and i == 17:
            continue  # latency: the force at a step's start is not differentiable at a command
        step = 1e-6 * max(1.0, abs(p[i]))
        up, down = p.copy(), p.copy()
        up[i] += step
        down[i] -= step
        numeric = (run(up)[0] - run(down)[0]) / (2 * step)
        np.testing.assert_allclose(slopes[:, :, i], numeric, atol=2e-6, err_msg=f"column {i}")


def test_forward_euler_is_the_papers_recursion(mp):
    model = make_model(mp, TABLE_II["MP"], "forward-euler", 1 / 15)
    record = recording(5)
    got, _ = _core.simulate(model.boat, model.trace(record), np.zeros(6), record.t)
    x = np.zeros(6)
    F = model.trace(record).forces(record.t)
    for k in range(len(record.t) - 1):
        dt = record.t[k + 1] - record.t[k]
        rate = _core.accelerations(
            model.structure.compiled, model.coefficients, x[None, 3:], F[k : k + 1]
        )[0]
        c, s = np.cos(x[2]), np.sin(x[2])
        x = x + dt * np.array([c * x[3] - s * x[4], s * x[3] + c * x[4], x[5], *rate])
        np.testing.assert_allclose(got[k + 1], x, atol=1e-13)


def test_linear_drag_decays_as_the_matrix_exponential(mp):
    content = mp.to_mapping()
    content["structure"] = {
        "surge": ["X_u * u", "X_F * F_u"], "sway": ["Y_v * v", "Y_F * F_v"],
        "yaw": ["N_ud * u_dot", "N_r * r", "N_F * F_r"],
    }  # fmt: skip
    vehicle = vehicle_from(content, "linear")
    values = {"X_u": -0.4, "X_F": 1, "Y_v": -0.9, "Y_F": 1, "N_ud": 0.5, "N_r": -1.3, "N_F": 1}
    model = make_model(vehicle, values, step=1 / 60)
    still = Signal(("F_u", "F_v", "F_r"), np.array([0]), np.zeros((1, 3)))
    record = make_recording("still", np.array([0, 10**9, 2 * 10**9]), np.zeros((3, 3)), still)
    start = np.array([0.3, -0.1, 0.2])
    got, _ = _core.simulate(
        model.boat, model.trace(record), np.append(np.zeros(3), start), record.t
    )
    A = np.array([[-0.4, 0, 0], [0, -0.9, 0], [0.5 * -0.4, 0, -1.3]])  # u, v, r
    np.testing.assert_allclose(got[-1, 3:], expm(A * 2.0) @ start, atol=1e-9)


def test_a_boat_that_runs_away_gives_nan_and_returns(mp):
    values = TABLE_II["AF"] | {"X_uu": 5.0}
    model = make_model(mp, values, step=1 / 60)
    record = recording(6, seconds=200.0)
    got, _ = _core.simulate(
        model.boat, model.trace(record), np.array([0, 0, 0, 1.0, 0, 0]), record.t
    )
    assert np.isnan(got[-1]).all()
    assert np.isfinite(got[0]).all()


def test_a_plant_driven_live_equals_the_simulation_of_its_log(model):
    record = recording(7)
    plant = _core.Plant(model.boat, model.vehicle.chain, model.constants)
    t_c = record.seconds(record.commands.stamps)
    events = sorted(
        [(t, 0, i) for i, t in enumerate(t_c)] + [(t, 1, i) for i, t in enumerate(record.t)]
    )
    got = np.zeros((len(record.t), 6))
    for t, kind, i in events:
        plant.advance_to(t)
        if kind == 0:
            assert plant.command(t, record.commands.values[i])
        else:
            got[i] = plant.state
    # the log's first command is taken to have held for ever; the plant began at rest without one
    first = np.vstack([np.zeros((1, 3)), record.commands.values])
    stamps = np.concatenate([[-(10**12)], record.commands.stamps])
    log = make_recording(
        "log", record.stamps, record.eta, Signal(("F_u", "F_v", "F_r"), stamps, first)
    )
    want, _ = _core.simulate(model.boat, model.trace(log), np.zeros(6), log.t)
    np.testing.assert_allclose(got, want, atol=1e-9)


def test_the_type_stub_is_that_of_the_compiled_core(tmp_path):
    stub = Path(seatrial.__file__).parent / "_core.pyi"
    command = [
        sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "seatrial._core", "-o", tmp_path / "_core.pyi",
    ]  # fmt: skip
    subprocess.run(command, check=True)
    assert stub.read_text() == (tmp_path / "_core.pyi").read_text(), "run: make stub"


def test_a_plant_refuses_commands_from_the_past(model):
    plant = _core.Plant(model.boat, model.vehicle.chain, model.constants)
    plant.advance_to(1.0)
    assert not plant.command(0.5, np.zeros(3))
    assert plant.time == 1.0


@pytest.mark.parametrize(
    "call",
    [
        lambda m, r: _core.simulate(m.boat, m.trace(r), np.zeros(5), r.t),
        lambda m, r: _core.predict(
            m.boat,
            m.trace(r),
            r.t,
            np.array([80], np.int32),
            np.array([95], np.int32),
            np.zeros((1, 6)),
        ),
        lambda m, r: _core.predict(
            m.boat,
            m.trace(r),
            r.t,
            np.array([-1], np.int32),
            np.array([0], np.int32),
            np.zeros((1, 6)),
        ),
        lambda m, r: _core.regressors(
            m.structure.compiled, np.zeros((2, 3)), np.zeros((3, 3)), np.zeros((2, 3))
        ),
        lambda m, r: _core.ThrustTrace(
            m.vehicle.chain, np.zeros(1), r.t, np.zeros((len(r.t), 3)), r.t, np.zeros((0, 0))
        ),
        lambda m, r: _core.curve(m.vehicle.chain, m.constants, 9, np.zeros(1)),
    ],
)
def test_wrong_shapes_are_refused_before_anything_is_read(model, call):
    with pytest.raises((ValueError, TypeError)):
        call(model, recording(0))
