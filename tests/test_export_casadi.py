# SPDX-License-Identifier: MIT
"""CasADi functions: the core's accelerations, steps and derivatives; a file that needs nothing but CasADi."""

import sys

import numpy as np
import pytest
from export_tools import BOATS, STATE_SIGNS, boat, core_states, drive, run

from seatrial import _core
from seatrial.boat.physics import direct_chain
from seatrial.export import casadi as own
from seatrial.export import export
from seatrial.util.errors import ExportError
from seatrial.util.frames import Axes

ca = pytest.importorskip("casadi")


def random_states(model, n=50):
    """States and forces as small boats have them, and some at rest."""
    rng = np.random.default_rng(3)
    x = rng.normal(size=(n, 6)) * [3.0, 3.0, 2.0, 0.5, 0.4, 1.0]
    x[:5, 3:] = 0.0
    return x, rng.uniform(-1.0, 1.0, (n, len(model.structure.forces)))


@pytest.mark.parametrize("name", BOATS)
def test_accelerations_are_the_cores(name):
    model = boat(name)
    x, force = random_states(model)
    rate = own.casadi_dynamics(model)
    found = np.array([rate(a, b).full().ravel() for a, b in zip(x, force, strict=True)])
    nu = np.ascontiguousarray(x[:, 3:])
    expected = _core.accelerations(model.structure.compiled, model.coefficients, nu, force)
    np.testing.assert_allclose(found[:, 3:], expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        found[:, :3], _core.rotate(x[:, 2].copy(), nu, False), rtol=0, atol=1e-12
    )


def one_core_step(model, x, force, dt):
    n = len(force)
    trace = _core.ThrustTrace(
        direct_chain(n), np.zeros(0), np.zeros(1), force[None], np.zeros(0), np.zeros((0, 0)), True
    )
    code_of_runge_kutta = 0
    long = _core.Boat(model.structure.compiled, model.coefficients, code_of_runge_kutta, 1.0)
    states, slopes = _core.simulate(long, trace, x, np.array([0.0, dt]), True)
    return states[1], slopes[1]


@pytest.mark.parametrize("name", BOATS)
def test_a_step_and_its_derivatives_are_the_cores(name):
    """CasADi differentiates by itself what the core does by hand."""
    model = boat(name)
    step = own.casadi_step(model)
    x, force, dt = ca.SX.sym("x", 6), ca.SX.sym("F", len(model.structure.forces)), ca.SX.sym("dt")
    slope = ca.Function("slope", [x, force, dt], [ca.jacobian(step(x, force, dt), x)])
    for a, b in zip(*random_states(model, 20), strict=True):
        state, slopes = one_core_step(model, a, b, 0.05)
        np.testing.assert_allclose(step(a, b, 0.05).full().ravel(), state, rtol=0, atol=1e-12)
        np.testing.assert_allclose(slope(a, b, 0.05).full(), slopes[:, :6], rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", BOATS)
def test_allocation_and_curves_are_the_cores(name):
    model = boat(name)
    commands = np.random.default_rng(4).uniform(-1.2, 1.2, (60, len(model.vehicle.inputs)))
    commands[:10] *= 0.1  # into the dead zones
    thrusters, _ = _core.allocate(model.vehicle.chain, commands)
    expected = np.column_stack([
        _core.curve(model.vehicle.chain, model.constants, k, thrusters)
        for k in range(len(model.vehicle.actuators))
    ])  # fmt: skip
    targets = own.casadi_targets(model)
    found = np.array([targets(c).full().ravel() for c in commands])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    mix = own.casadi_mix(model)
    known = np.array([1.1 * s.reference for s in model.vehicle.file.scales.values()])
    for command, level in zip(commands[:20], expected, strict=False):
        settled = _core.ThrustTrace(
            model.vehicle.chain, model.constants, np.zeros(1), command[None],
            np.zeros(1), known[None],
        )  # fmt: skip
        force = np.asarray(settled.forces(np.array([100.0])))[0]
        np.testing.assert_allclose(mix(level, known).full().ravel(), force, rtol=0, atol=1e-12)


def test_smooth_moves_drag_little_and_has_the_slope_at_rest_that_it_must():
    model = boat("bare")  # has |v| r
    x, force = random_states(model)
    sharp, smooth = own.casadi_dynamics(model), own.casadi_dynamics(model, smooth=1e-3)
    gap = max(float(ca.norm_inf(sharp(a, b) - smooth(a, b))) for a, b in zip(x, force, strict=True))
    assert 1e-9 < gap < 1e-3 * 3.0
    state, push = ca.SX.sym("x", 6), ca.SX.sym("F", 3)
    slope = ca.Function("slope", [state, push], [ca.jacobian(smooth(state, push)[3], state[3])])
    c = model.values
    assert float(slope(np.zeros(6), np.zeros(3))) == pytest.approx(
        c["X_u"] + 1e-3 * c["X_uu"], rel=1e-12
    )
    with pytest.raises(ExportError, match=r"smooth -1: expected a speed >= 0"):
        own.casadi_dynamics(model, smooth=-1.0)


SCRIPT = """
import sys, casadi as ca, numpy as np
assert "seatrial" not in sys.modules
given = np.load("given.npz")
t, commands, scales, latency, longest = (given[k] for k in ("t", "commands", "scales", "latency", "longest"))
file = ca.FileDeserializer("boat.casadi")
rate, step, targets, mix, drive = (file.unpack() for _ in range(5))
assert ca.Function.load("boat.casadi").name() == rate.name() == "rate"
due = sorted((s + l, i, k) for k, l in enumerate(latency) for i, s in enumerate(t) if s + l <= t[-1])
target = targets(np.zeros(commands.shape[1])).full().ravel()
x, level, now, states = np.zeros(6), target.copy(), 0.0, np.zeros((len(t), 6))
tendency = [targets(c).full().ravel() for c in commands]
def until(end):
    global x, level, now
    n = max(1, int(np.ceil((end - now) / longest - 1e-9)))
    for _ in range(n if end > now else 0):
        x, level = drive(x, level, target, scale, (end - now) / n)
    now = end
at, scale = 0, scales[0]
for j, stamp in enumerate(t):
    while at < len(due) and due[at][0] < stamp:
        until(due[at][0])
        target[due[at][2]] = tendency[due[at][1]][due[at][2]]
        at += 1
    until(stamp)
    states[j] = np.asarray(x).ravel()
    scale = scales[j]
    while at < len(due) and due[at][0] <= stamp:
        target[due[at][2]] = tendency[due[at][1]][due[at][2]]
        at += 1
np.save("states.npy", states)
"""


@pytest.mark.parametrize("name", BOATS)
def test_the_file_moves_the_boat_along_s7_with_casadi_alone(tmp_path, name):
    model, run_of = boat(name), drive(name).every(3).first(40.0)
    export(model, "casadi", tmp_path / "boat.casadi")
    index = model.vehicle.constants.index[:, 0]
    latency = [model.constants[i] if i >= 0 else 0.0 for i in index]
    np.savez(
        tmp_path / "given.npz", t=run_of.t, commands=run_of.commands, scales=run_of.scales,
        latency=latency, longest=model.integration.step,
    )  # fmt: skip
    (tmp_path / "script.py").write_text(SCRIPT)
    run(
        sys.executable, "-S", "-c", f"import sys; sys.path += {sys.path!r}; exec(open('script.py').read())",
        cwd=tmp_path,
    )  # fmt: skip
    found, expected = np.load(tmp_path / "states.npy"), core_states(model, run_of)
    assert np.abs(expected[:, 3:]).max(axis=0).min() > 0.01
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_in_the_library_all_is_forward_left_up_and_a_file_is_in_the_vehicles_axes(tmp_path):
    model = boat("right_down")
    assert model.vehicle.axes is Axes.FRD
    export(model, "casadi", tmp_path / "boat.casadi")
    turned, inside = ca.Function.load(str(tmp_path / "boat.casadi")), own.casadi_dynamics(model)
    x, force = (a[-1] for a in random_states(model))
    sides = np.array([1.0, -1.0, -1.0])  # F_u, F_v, F_r
    np.testing.assert_allclose(
        turned(x * STATE_SIGNS, force * sides).full().ravel(), inside(x, force).full().ravel() * STATE_SIGNS,
        rtol=0, atol=1e-12,
    )  # fmt: skip


def test_without_casadi_it_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(
        ExportError, match=r"CasADi is not installed: pip install 'seatrial\[mpc\]'"
    ):
        export(boat("bare"), "casadi", tmp_path / "boat.casadi")
    assert not list(tmp_path.iterdir())
