# SPDX-License-Identifier: MIT
"""Gate: speed, as ratios within one run: the core against what one would write without it.

    python -m benchmarks.run

prints medians of several repeats. Machines are noisy: read the ratios, not the milliseconds.
"""

import inspect
import statistics
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp
from threadpoolctl import threadpool_limits

import seatrial
from benchmarks.harness import command
from seatrial import _core
from seatrial.boat.schema import Integration
from seatrial.identification.methods import identify_with_fit
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.parallel import cores
from tests.boats.by_hand import rates
from tests.boats.scenes import driven

REPEATS = 7
STEPS = 15  # one second at 15 Hz


def median(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median wall time [s] after one warm-up."""
    work()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def row(label: str, seconds: float, base: float | None = None) -> None:
    """One line of the table; `base` is what it is compared with."""
    ratio = "" if base is None else f"   {seconds / base:9.1f} x"
    print(f"  {label:<58} {1e3 * seconds:10.2f} ms{ratio}")


def python_euler(model: seatrial.Model, nu: np.ndarray, F: np.ndarray, dt: float) -> np.ndarray:
    """The paper's recursion as a script would have it: one start after the other."""
    c = model.values
    out = np.zeros((len(nu) - STEPS, 3))
    for j in range(len(out)):
        u, v, r = nu[j]
        for k in range(j, j + STEPS):
            du = v * r + (c["X_u"] + c["X_uu"] * abs(u)) * u + c["X_F"] * F[k, 0]
            dv = -u * r + (c["Y_v"] + c["Y_vv"] * abs(v)) * v + c["Y_F"] * F[k, 1]
            dr = c["N_ud"] * du + (c["N_r"] + c["N_rr"] * abs(r)) * r + c["N_uu"] * abs(u) * u
            u, v, r = u + dt * du, v + dt * dv, r + dt * (dr + c["N_F"] * F[k, 2])
        out[j] = u, v, r
    return out


def numpy_euler(model: seatrial.Model, nu: np.ndarray, F: np.ndarray, dt: float) -> np.ndarray:
    """The same, vectorised over the starts by hand."""
    c = model.values
    n = len(nu) - STEPS
    u, v, r = (nu[:n, i].copy() for i in range(3))
    for k in range(STEPS):
        f = F[k : k + n]
        du = v * r + (c["X_u"] + c["X_uu"] * np.abs(u)) * u + c["X_F"] * f[:, 0]
        dv = -u * r + (c["Y_v"] + c["Y_vv"] * np.abs(v)) * v + c["Y_F"] * f[:, 1]
        dr = c["N_ud"] * du + (c["N_r"] + c["N_rr"] * np.abs(r)) * r + c["N_uu"] * np.abs(u) * u
        u, v, r = u + dt * du, v + dt * dv, r + dt * (dr + c["N_F"] * f[:, 2])
    return np.column_stack([u, v, r])


def prediction(truth: seatrial.Model, recording: seatrial.Recording) -> None:
    """15 steps ahead from each of 6000 samples."""
    dt = 1 / 15
    euler = replace(truth, integration=Integration("forward-euler", dt))
    t = np.arange(6000) * dt
    nu = np.random.default_rng(0).normal(0, 0.1, (6000, 3))
    F = euler.trace(recording).forces(t)
    x0 = np.ascontiguousarray(np.column_stack([np.zeros((6000 - STEPS, 3)), nu[: 6000 - STEPS]]))
    start = np.arange(6000 - STEPS, dtype=np.int32)

    def core(model: seatrial.Model, *, tangents: bool = False) -> np.ndarray:
        columns = {"initial": True, "coefficients": range(11)} if tangents else {}
        trace = model.trace(recording, **columns)
        got = _core.predict(
            model.boat, trace, t, start, start + STEPS, x0, threads=1, sensitivities=tangents
        )
        return got[0][:, 3:]

    want = python_euler(euler, nu, F, dt)
    assert np.allclose(core(euler), want, atol=1e-12)
    assert np.allclose(numpy_euler(euler, nu, F, dt), want, atol=1e-12)
    print(f"{STEPS}-step prediction from 6000 samples, one thread")
    base = median(lambda: core(euler))
    row("core, forward Euler (thrusters included)", base)
    row(
        "NumPy, vectorised by hand (forces given, no positions)",
        median(lambda: numpy_euler(euler, nu, F, dt)),
        base,
    )
    row(
        "Python loop (forces given, no positions)",
        median(lambda: python_euler(euler, nu, F, dt), 3),
        base,
    )
    fine = replace(truth, integration=Integration("runge-kutta", 1 / 60))
    row(
        "core, Runge-Kutta at 60 Hz with breaks, dead zone and lag",
        median(lambda: core(fine)),
        base,
    )
    row("the same with 17 tangents", median(lambda: core(fine, tangents=True), 3), base)


def simulation(truth: seatrial.Model, recording: seatrial.Recording) -> None:
    """1600 s of driving, state every 1/15 s."""
    t = np.arange(0, 1600, 1 / 15)
    trace = truth.trace(recording)
    c = truth.values

    def core() -> np.ndarray:
        return _core.simulate(truth.boat, truth.trace(recording), np.zeros(6), t)[0]

    def rate(now: float, x: np.ndarray) -> list[float]:
        return rates(c, x, trace.forces(np.array([now]))[0])

    def scipy() -> np.ndarray:
        return solve_ivp(rate, (0, t[-1]), np.zeros(6), t_eval=t, max_step=0.05, rtol=1e-6).y.T

    print("simulation of 1600 s with thrusters")
    base = median(core)
    row(f"core, Runge-Kutta, {truth.integration.step * 1e3:.1f} ms steps", base)
    row("SciPy solve_ivp, rtol 1e-6 (forces from the core)", median(scipy, 1), base)
    print(f"    largest difference in speed {np.abs(core() - scipy())[:, 3:].max():.1e} m/s, rad/s")


def threads_of_blas(vehicle: seatrial.Vehicle, recording: seatrial.Recording) -> None:
    """CPU time of a whole identification in a program whose BLAS may use all cores."""

    def cpu(work: Callable[..., object]) -> float:
        times = []
        for _ in range(REPEATS):
            begin = time.process_time()
            work([recording], vehicle)
            times.append(time.process_time() - begin)
        return statistics.median(times[1:])

    print("identify with all cores, CPU time")
    with threadpool_limits(cores(), user_api="blas"):
        base = cpu(identify_with_fit)
        row("one thread of BLAS, as identify sets it", base)
        row("as many as BLAS starts by itself", cpu(inspect.unwrap(identify_with_fit)), base)


def main() -> None:
    """Run all."""
    command.parser("run", __doc__).parse_args()
    vehicle = seatrial.load_vehicle("mallard-af")
    plan = load_plan("paper-like")
    truth = plant_model(plan, vehicle)
    recording = driven(plan, vehicle, names=["S7"])["S7"].recording
    prediction(truth, recording)
    simulation(truth, recording)
    threads_of_blas(vehicle, recording)


if __name__ == "__main__":
    main()
