# SPDX-License-Identifier: MIT
"""Model predictive control: its model, its optimum, its limits, and its C without CasADi."""

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import in_coarse_steps
from programs import printed

import seatrial
from seatrial import _core
from seatrial.boat.vehicle import load_vehicle
from seatrial.control.mpc import Grid, Nmpc, Weights, by_thrusters
from seatrial.control.mpc.interior_point import minimum
from seatrial.control.mpc.problem import stage
from seatrial.export import export
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.errors import ControlError, ExportError, ModelError

ca = pytest.importorskip("casadi")

PERIOD = 0.1  # [s]
EDGE = 0.08  # of the plant's dead zone
POOL = (2.0, 1.2)  # [m]
ROOT = Path(__file__).parents[1]
SHIP = ROOT / "data" / "cse1" / "pair.yaml"


@pytest.fixture(scope="module")
def truth():
    """The paper's boat with dead zone and lag."""
    return in_coarse_steps(plant_model(load_plan("hard"), load_vehicle("mallard-mp")))


@pytest.fixture(scope="module")
def controller(truth):
    return Nmpc(truth, pool=POOL)


def circle(t, radius=0.4, period=30.0):
    """Pose and velocity (n, 6) of a circle with a heading of its own."""
    t, w = np.asarray(t, dtype=float), 2 * np.pi / period
    psi, r = 0.5 * np.sin(w * t), 0.5 * w * np.cos(w * t)
    x, y = radius * np.cos(w * t), radius * np.sin(w * t)
    vx, vy = -radius * w * np.sin(w * t), radius * w * np.cos(w * t)
    u, v = np.cos(psi) * vx + np.sin(psi) * vy, -np.sin(psi) * vx + np.cos(psi) * vy
    return np.stack([x, y, psi, u, v, r], axis=-1)


def drive(controller, reference, seconds, begin=None, noise=0.0):
    """Commands (n, thrusters) and states (n, 6) of the core's boat under the controller."""
    controller.forget()
    model = controller.model
    plant = _core.Plant(model.boat, model.vehicle.chain, model.constants)
    predictor = seatrial.Predictor(model)
    plant.state = np.array(reference(0.0) if begin is None else begin)
    rng, commands, states = np.random.default_rng(3), [], []
    for k in range(round(seconds / PERIOD)):
        t = k * PERIOD
        plant.advance_to(t)
        predictor.pose(t, plant.state[:3] + noise * rng.normal(size=3))
        found = predictor.at(t + controller.latency)
        ahead = reference(t + controller.latency + controller.grid.times)
        command = controller.command(t, found.pose, found.velocity, ahead, found.disturbance)
        predictor.command(t, command)
        plant.command(t, command)
        commands.append(command)
        states.append(plant.state)
    return np.array(commands), np.array(states)


def test_a_stage_is_the_cores_motion_under_constant_commands(truth):
    model = by_thrusters(truth)
    controller = Nmpc(truth, grid=Grid(2, 0.2, 48))  # the core's own step
    forward = stage(model, controller.thrusters, controller.grid)
    rng = np.random.default_rng(1)
    for _ in range(5):
        thrust = rng.uniform(0.1, 0.9, 4)
        begin = rng.normal(size=6) * [1, 1, 1, 0.2, 0.2, 0.5]
        plant = _core.Plant(model.boat, model.vehicle.chain, model.constants)
        plant.command(0.0, np.ascontiguousarray(controller.thrusters.commands(thrust)))
        plant.state = begin
        plant.advance_to(0.2)
        found = np.array(forward(np.concatenate([begin, np.zeros(4)]), thrust, np.zeros(3))).ravel()
        np.testing.assert_allclose(found[:6], plant.state, atol=2e-7)
        np.testing.assert_allclose(found[6:], thrust * (1 - np.exp(-0.2 / 0.08)), rtol=1e-12)


def test_a_heading_that_passes_pi_changes_no_command(controller):
    """The same poses with the heading as a predictor has it, in (-pi, pi], and continuous; one step each."""
    layout, idle = controller.layout, controller.thrusters.idle

    def follow(wrapped):
        last, plan, found = idle, None, []
        for t in 0.1 * np.arange(12):
            motion = np.array([0.4 * np.cos(t), 0.4 * np.sin(t), 2.7 + 0.8 * t, 0.1, 0.2, 0.8])
            ahead = motion + np.outer(controller.grid.times, [0.0, 0.0, 0.8, 0.0, 0.0, 0.0])
            if wrapped and motion[2] > np.pi:
                motion[2] -= 2.0 * np.pi
                ahead[:, 2] -= 2.0 * np.pi
            z = np.concatenate([motion, idle])
            if plan is None:
                stage_at_rest = np.concatenate([z, idle, [0.0]])
                plan = np.concatenate([np.tile(stage_at_rest, layout.stages), z])
            plan = np.array(controller.function(plan, z, ahead.T, last, np.zeros(3))[0]).ravel()
            last = plan[layout.thrust(0)]
            found.append(last)
        return np.array(found)

    np.testing.assert_allclose(follow(True), follow(False), rtol=0, atol=1e-8)


def test_a_disturbance_pushes_along_the_earths_axes(truth):
    model = by_thrusters(truth)
    controller = Nmpc(truth, grid=Grid(2, 1e-4, 1))
    forward = stage(model, controller.thrusters, controller.grid)
    still = np.concatenate([[0.0, 0.0, np.pi / 2], np.zeros(7)])
    found = np.array(forward(still, np.zeros(4), [0.1, 0.2, 0.3])).ravel()
    np.testing.assert_allclose(found[3:6] / 1e-4, [0.2, -0.1, 0.3], rtol=1e-3)


def test_repeated_steps_end_in_the_optimum_that_ipopt_finds(truth):
    """The same problem written once more, for another solver with second derivatives."""
    grid, weights = Grid(6, 0.2, 1), Weights()
    controller = Nmpc(truth, pool=POOL, grid=grid)
    now = np.concatenate([[0.3, -0.2, 0.1, 0.05, -0.02, 0.1], controller.thrusters.idle])
    wanted = circle(grid.times)
    idle, model = controller.thrusters.idle, controller.model
    forward = stage(model, controller.thrusters, grid)
    z, cost, last, thrusts = ca.DM(now), 0, idle, []
    for k in range(grid.stages):
        g = ca.MX.sym(f"g{k}", 4)
        z = forward(z, g, np.zeros(3))
        scale = np.array(
            [weights.position] * 2 + [weights.heading] + [weights.velocity] * 2 + [weights.yaw_rate]
        )
        cost += ca.sumsqr(scale * (z[:6] - wanted[k])) + ca.sumsqr(weights.thrust * (g - idle))
        cost += ca.sumsqr(weights.change * (g - last))
        last = g
        thrusts.append(g)
    everything = ca.vertcat(*thrusts)
    quiet = {"print_time": False, "ipopt": {"print_level": 0, "tol": 1e-10, "sb": "yes"}}
    solver = ca.nlpsol("same", "ipopt", {"x": everything, "f": 0.5 * cost}, quiet)
    low, high = controller.thrusters.lowest, controller.thrusters.highest
    found = solver(
        x0=np.tile(idle, grid.stages), lbx=np.tile(low, grid.stages), ubx=np.tile(high, grid.stages)
    )
    best = np.array(found["x"]).reshape(grid.stages, 4)

    layout = controller.layout
    w = np.concatenate([np.tile(np.concatenate([now, idle, [0.0]]), grid.stages), now])
    for _ in range(40):
        w = np.array(controller.function(w, now, wanted.T, idle, np.zeros(3))[0]).ravel()
    ours = np.array([w[layout.thrust(k)] for k in range(grid.stages)])
    np.testing.assert_allclose(ours, best, atol=2e-4)


@pytest.mark.system
def test_it_follows_a_circle_from_noisy_poses_without_entering_a_dead_zone(controller):
    commands, states = drive(controller, circle, 30.0, noise=0.004)
    off = states[100:] - circle(PERIOD * np.arange(100, 300))
    assert np.sqrt(np.mean(np.sum(off[:, :2] ** 2, axis=1))) < 0.01  # [m]
    assert np.sqrt(np.mean(off[:, 2] ** 2)) < 0.01  # [rad]
    assert np.abs(commands).min() > EDGE
    assert np.all(np.sign(commands) == np.sign(commands[0]))
    assert np.abs(commands).max() <= 1.0


def test_a_reference_beyond_the_wall_is_followed_up_to_it(controller):
    def beyond(t):
        return circle(t, radius=0.9, period=60.0)  # 0.3 m out of the pool's width

    _, states = drive(controller, beyond, 30.0)
    assert np.abs(beyond(PERIOD * np.arange(300))[:, 1]).max() > POOL[1] / 2 + 0.25
    assert np.abs(states[:, 1]).max() < POOL[1] / 2 + 0.002
    assert np.abs(states[:, 1]).max() > POOL[1] / 2 - 0.05


@pytest.mark.system
def test_noisy_poses_along_a_wall_leave_no_programme_unsolved(controller):
    def beyond(t):
        return circle(t, radius=0.9, period=60.0)

    _, states = drive(controller, beyond, 40.0, noise=0.004)
    assert controller.unsolved == 0
    assert np.abs(states[:, 1]).max() < POOL[1] / 2 + 0.01


def test_what_no_programme_solves_leaves_thrusters_idle(truth):
    controller = Nmpc(truth, grid=Grid(2))
    good = circle(controller.grid.times)
    controller.command(0.0, good[0, :3], good[0, 3:], good)
    solve = controller._call
    controller._call = lambda *given: (solve(*given)[0], [1.0, 0.0])
    idle = controller.thrusters.commands(controller.thrusters.idle)
    np.testing.assert_array_equal(controller.command(0.1, good[0, :3], good[0, 3:], good), idle)
    assert controller.unsolved == 2
    controller._call = solve
    assert np.abs(controller.command(0.2, good[0, :3] + 0.1, good[0, 3:], good) - idle).max() > 0.01


@pytest.mark.parametrize("seed", range(20))
def test_the_interior_point_method_finds_what_another_solver_finds(seed):
    """Random convex programmes, some with no curvature along a price, as that of the walls."""
    rng = np.random.default_rng(seed)
    n, n_equal, n_below = 12, 4, 20
    root = rng.normal(size=(n, n)) * (rng.random(n) > 0.2)
    hessian = 100 * root.T @ root + 1e-6 * np.eye(n)
    gradient, within = 300 * rng.normal(size=n), rng.normal(size=n)
    equal, below = rng.normal(size=(n_equal, n)), rng.normal(size=(n_below, n))
    below = np.vstack([below, np.eye(n), -np.eye(n)])
    level = below @ within + np.maximum(rng.normal(size=len(below)), 0.0) + 1e-3
    parts = [ca.DM(part) for part in (hessian, gradient, equal, equal @ within, below, level)]
    x, off = minimum(tuple(ca.MX(part) for part in parts), 100.0)
    found, missed = (np.array(value).ravel() for value in ca.Function("f", [], [x, off])().values())
    rows = ca.DM(np.vstack([equal, below])).sparsity()
    quiet = {"highs": {"output_flag": False}}
    other = ca.conic("other", "highs", {"h": parts[0].sparsity(), "a": rows}, quiet)
    best = other(
        h=hessian, g=gradient, a=np.vstack([equal, below]),
        lba=np.concatenate([equal @ within, np.full(len(below), -np.inf)]),
        uba=np.concatenate([equal @ within, level]),
    )  # fmt: skip
    cost = 0.5 * found @ hessian @ found + gradient @ found
    assert missed.max() < 1e-3
    assert cost == pytest.approx(float(best["cost"]), abs=missed[1] + 1e-6 * abs(cost))


def test_full_thrust_is_never_exceeded_when_the_reference_is_out_of_reach(controller):
    commands, states = drive(controller, lambda t: circle(t, 0.4, 6.0), 12.0)
    assert commands.max() == pytest.approx(1.0, abs=1e-3)
    assert np.isfinite(states).all()


@pytest.mark.system
def test_generated_c_runs_without_casadi(truth, tmp_path):
    compiler = shutil.which("gcc")
    assert compiler is not None
    controller = Nmpc(truth, pool=POOL, grid=Grid(4, 0.2, 1))
    source = controller.generate(tmp_path)
    main = tmp_path / "main.c"
    main.write_text(MAIN)
    binary = tmp_path / "step"
    command = [compiler, "-O0", str(main), str(source), "-o", str(binary), "-lm"]
    subprocess.run(command, check=True, cwd=tmp_path)
    grid = controller.grid
    now = np.concatenate([circle(0.0) + 0.01, controller.thrusters.idle])
    part = np.concatenate([now, controller.thrusters.idle, [0.0]])
    given = [
        np.concatenate([np.tile(part, grid.stages), now]),
        now, circle(grid.times).ravel(), controller.thrusters.idle, np.zeros(3),
    ]  # fmt: skip
    text = "\n".join(repr(float(x)) for x in np.concatenate(given))
    said = printed(binary, input=text)
    shaped = [*given[:2], given[2].reshape(-1, 6).T, *given[3:]]
    ours = np.concatenate([np.array(x).ravel() for x in controller.function(*shaped)])
    np.testing.assert_allclose(np.array(said.split(), dtype=float), ours, rtol=1e-9, atol=1e-9)
    assert "casadi.h" not in source.read_text()


MAIN = """
#include <stdio.h>
#include <stdlib.h>
#include "seatrial_nmpc.h"
int main(void) {
  casadi_int n_arg, n_res, n_iw, n_w;
  seatrial_nmpc_work(&n_arg, &n_res, &n_iw, &n_w);
  const double** arg = calloc(n_arg, sizeof *arg);
  double** res = calloc(n_res, sizeof *res);
  casadi_int* iw = calloc(n_iw + 1, sizeof *iw);
  double* w = calloc(n_w + 1, sizeof *w);
  for (casadi_int i = 0; i < seatrial_nmpc_n_in(); ++i) {
    const casadi_int* s = seatrial_nmpc_sparsity_in(i);
    double* x = calloc(s[0] * s[1], sizeof *x);
    for (casadi_int j = 0; j < s[0] * s[1]; ++j) if (scanf("%lf", x + j) != 1) return 2;
    arg[i] = x;
  }
  for (casadi_int i = 0; i < seatrial_nmpc_n_out(); ++i) {
    const casadi_int* s = seatrial_nmpc_sparsity_out(i);
    res[i] = calloc(s[0] * s[1], sizeof **res);
  }
  if (seatrial_nmpc(arg, res, iw, w, 0)) return 3;
  for (casadi_int i = 0; i < seatrial_nmpc_n_out(); ++i) {
    const casadi_int* s = seatrial_nmpc_sparsity_out(i);
    for (casadi_int j = 0; j < s[0] * s[1]; ++j) printf("%.17g\\n", res[i][j]);
  }
  return 0;
}
"""


def test_wrong_input_gets_one_line(controller, truth):
    controller.forget()
    good = circle(controller.grid.times)
    with pytest.raises(ControlError, match=r"expected \(6,\), \(12, 6\) and \(3,\)"):
        controller.command(0.0, np.zeros(3), np.zeros(3), good[:3])
    with pytest.raises(ControlError, match="not a number"):
        controller.command(0.0, np.full(3, np.nan), np.zeros(3), good)
    controller.command(1.0, np.zeros(3), np.zeros(3), good)
    with pytest.raises(ControlError, match="times must increase"):
        controller.command(1.0, np.zeros(3), np.zeros(3), good)
    with pytest.raises(ControlError, match="length and width"):
        Nmpc(truth, pool=(1.0, -1.0))
    with pytest.raises(ControlError, match="twice the clearance"):
        Nmpc(truth, pool=(1.0, 1.0), clearance=0.5)
    with pytest.raises(ControlError, match="two stages"):
        Grid(1)


def test_a_model_that_runs_away_is_refused_in_the_words_of_export(truth, tmp_path):
    values = truth.values | {"X_u": 0.5, "X_uu": 0.0}
    wild = replace(truth, coefficients=np.array([values[n] for n in truth.structure.coefficients]))
    with pytest.raises(ModelError, match=r"the model is unstable: .*surge passes 10 m/s") as ours:
        Nmpc(wild)
    with pytest.raises(ModelError) as theirs:
        export(wild, "casadi", tmp_path / "wild.casadi")
    assert str(ours.value) == str(theirs.value)


def of_another(truth, vehicle):
    """A model of another vehicle, all coefficients 0."""
    n = len(vehicle.structure.coefficients)
    return replace(
        truth, vehicle=vehicle, coefficients=np.zeros(n), covariance=np.zeros((n, n)),
        constants=vehicle.constants.values,
    )  # fmt: skip


def test_without_casadi_it_says_what_to_install(truth, monkeypatch):
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(ExportError, match=r"pip install 'seatrial\[mpc\]'"):
        Nmpc(truth)


@pytest.mark.system
def test_the_example_follows_its_course():
    script = ROOT / "examples" / "nmpc.py"
    assert float(printed(sys.executable, script).split()[-5]) < 5.0  # [mm]
