# SPDX-License-Identifier: MIT
"""The estimator beside CasADi + IPOPT, SciPy and JAX + optimistix: one problem, one answer.

    python benchmarks/estimators.py                 # all of them, as a table
    python benchmarks/estimators.py --only scipy    # beside seatrial, of course

Simulated MallARD, trials S1 to S3, 200 s each at 15 Hz: the 11 coefficients and the initial state of
every recording, from the poses, weighted with their noise; actuator chain given, no process noise.
Every contender is a process of its own on one core, and starts from the same values. "estimation" is
from arrays in memory to coefficients, with what is compiled or built for it. Machines are noisy:
read the ratios.
"""

# ruff: noqa: PLC0415 what is not measured is not imported either

import argparse
import importlib
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from rivals.problem import STEPS, Array, Problem, Solution

TRIALS = ("S1", "S2", "S3")
POSE_SPREAD = 3.0  # of the first pose, in standard deviations of one: as the core has it
NONE = 1e-9  # of process noise: its limit
DIGITS = 1e-3  # by which coefficients may differ
RIVALS = {
    "CasADi + IPOPT, multiple shooting": "casadi_ipopt",
    "SciPy least_squares, NumPy roll-out": "scipy_rollout",
    "JAX + optimistix": "jax_optimistix",
}
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
}


def prepare(folder: Path, plan_name: str) -> None:
    """Trials as tables for seatrial, and the same as arrays for the others."""
    import msgspec

    import seatrial
    from seatrial.boat.schema import NoiseEntry, ProcessEntry
    from seatrial.identification.regression.equation_error import equation_error
    from seatrial.io.write import write_setting, write_trial
    from seatrial.simulation.plan import DropOuts, Jumps, load_plan
    from seatrial.simulation.trials import plant_model, simulate

    plan = load_plan(plan_name)
    pose = msgspec.structs.replace(
        plan.pose, drop_outs=DropOuts(per_minute=0.0), jumps=Jumps(per_minute=0.0)
    )
    chain = [msgspec.structs.replace(group, latency=0.0) for group in plan.plant.chain]
    plan = msgspec.structs.replace(
        plan,
        plant=msgspec.structs.replace(plan.plant, chain=chain),
        pose=pose,
        joypad=msgspec.structs.replace(plan.joypad, clock_offset=0.0),
        trials={name: plan.trials[name] for name in TRIALS},
    )
    truth = plant_model(plan, seatrial.load_vehicle("mallard-mp"))
    write_setting(plan, truth.vehicle, truth, folder)
    for trial in simulate(plan, truth.vehicle):
        write_trial(trial, folder)
    vehicle, recordings = read(folder)
    start = equation_error(recordings, vehicle)
    noise = NoiseEntry(pose.position_noise, pose.heading_noise, ProcessEntry(*[NONE] * 4, 1.0))
    seatrial.save(replace(start, noise=noise), folder / "start.yaml")
    as_arrays(recordings, truth, start.coefficients).save(folder / "problem.npz")


def read(folder: Path) -> tuple[object, list[object]]:
    """The vehicle, chain and all, and its recordings."""
    import seatrial

    vehicle = seatrial.load_vehicle(folder / "vehicle-MP.yaml")
    return vehicle, [seatrial.read(folder / f"{name}-MP", vehicle) for name in TRIALS]


def as_arrays(recordings: list[object], truth: object, theta: Array) -> Problem:
    """What the rivals get: the thrusters' forces are worked out for them."""
    from seatrial.evaluation.filtering import VELOCITY_SPREAD
    from seatrial.recording.velocity import motion

    noise = truth.noise
    sigma = np.array([noise.position, noise.position, noise.heading])
    moving = [motion(r) for r in recordings]
    rows = [np.flatnonzero(m.valid) for m in moving]
    eta = np.array([r.eta for r in recordings])
    nu = np.array([
        m.nu[i[np.searchsorted(i, np.arange(len(m.t))).clip(max=len(i) - 1)]]
        for m, i in zip(moving, rows, strict=True)
    ])  # fmt: skip
    grid = np.array([
        [steps_between(*ends, changes(r)) for ends in pairwise(r.t.tolist())] for r in recordings
    ])  # fmt: skip
    h = np.diff(grid)
    nodes = grid[..., :-1, None] + h[..., None] * np.array([0.0, 0.5, 1.0])
    force = np.array([
        truth.trace(r).forces(np.ascontiguousarray(at.ravel())).reshape(*at.shape, 3)
        for r, at in zip(recordings, nodes, strict=True)
    ])  # fmt: skip
    initial = np.concatenate([eta[:, 0], nu[:, 0]], axis=1)
    spread = np.concatenate([POSE_SPREAD * sigma, VELOCITY_SPREAD])
    return Problem(h, eta, nu, force, sigma, initial, spread, theta)


def changes(recording: object) -> Array:
    """Times [s] at which a command changes."""
    commands = recording.commands
    moved = np.any(np.diff(commands.values, axis=0) != 0.0, axis=1)
    return recording.seconds(commands.stamps[1:][moved])


def steps_between(begin: float, end: float, breaks: Array) -> Array:
    """The ends (STEPS + 1,) of the steps between two poses; one falls on every break."""
    fixed = [begin, *breaks[(breaks > begin) & (breaks < end)].tolist(), end]
    while len(fixed) <= STEPS:  # halve the longest
        i = int(np.argmax(np.diff(fixed)))
        fixed.insert(i + 1, (fixed[i] + fixed[i + 1]) / 2.0)
    return np.array(fixed)


def with_seatrial(folder: Path) -> tuple[Solution, float]:
    """The output-error method at given settings: noise held, no process noise, chain stated."""
    import seatrial
    from seatrial.identification.estimator import OutputErrorSettings, fit

    vehicle, recordings = read(folder)
    start = seatrial.load(folder / "start.yaml")
    settings = OutputErrorSettings(outlier=np.inf, hold_noise=True)
    begin = time.perf_counter()
    found = fit(recordings, vehicle, settings=settings, start=start)
    took = time.perf_counter() - begin
    return Solution(found.theta[: found.problem.n_coefficients], 0), took


def with_rival(module: str, folder: Path) -> tuple[Solution, float]:
    """One of the others, after its imports."""
    solve = importlib.import_module(f"rivals.{module}").solve
    problem = Problem.load(folder / "problem.npz")
    begin = time.perf_counter()
    return solve(problem), time.perf_counter() - begin


def measure(what: str, folder: Path) -> None:
    """In a process of its own, on one core."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    found, took = with_seatrial(folder) if what == "seatrial" else with_rival(what, folder)
    print(
        json.dumps({
            "theta": found.theta.tolist(), "iterations": found.iterations,
            "compiling": found.compiling, "estimation": took,
        })
    )  # fmt: skip


def measured(what: str, folder: Path, repeats: int) -> dict[str, float | list[float]]:
    """Medians over processes of their own."""
    command = [sys.executable, __file__, "--measure", what, str(folder)]
    found = []
    for _ in range(repeats):
        begin = time.perf_counter()
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, env={**os.environ, **ONE_THREAD}
        )
        if done.returncode:
            raise SystemExit(f"{what}: {done.stderr}")
        found.append({**json.loads(done.stdout), "process": time.perf_counter() - begin})
    times = ("process", "estimation", "compiling")
    return {**found[0], **{key: statistics.median(f[key] for f in found) for key in times}}


def agree(what: str, theta: Array, base: Array) -> float:
    """The largest relative difference of a coefficient; raises where it is not the same answer."""
    worst = float(np.max(np.abs(theta / base - 1.0)))
    if not worst < DIGITS:
        raise SystemExit(f"{what} found {theta.tolist()}, seatrial {base.tolist()}")
    return worst


def table(folder: Path, rivals: dict[str, str], repeats: int) -> None:
    """All of them."""
    base = measured("seatrial", folder, repeats)
    print(
        "| | process [s] | ratio | estimation [s] | ratio | of it compiling [s] | steps | differs by |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for label, what in {"seatrial": "seatrial", **rivals}.items():
        got = base if what == "seatrial" else measured(what, folder, repeats)
        differs = agree(label, np.array(got["theta"]), np.array(base["theta"]))
        print(
            f"| {label} | {got['process']:.2f} | {got['process'] / base['process']:.1f} "
            f"| {got['estimation']:.3f} | {got['estimation'] / base['estimation']:.1f} "
            f"| {got['compiling']:.2f} | {got['iterations'] or ''} | {differs:.0e} |",
            flush=True,
        )


def main() -> None:
    """Run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plan", default="hard", help="for instance paper-like")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", nargs="+", help="of casadi, scipy, jax")
    parser.add_argument("--measure", nargs=2, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        measure(args.measure[0], Path(args.measure[1]))
        return
    rivals = {
        label: module
        for label, module in RIVALS.items()
        if args.only is None or module.partition("_")[0] in args.only
    }
    with tempfile.TemporaryDirectory() as name:
        prepare(Path(name), args.plan)
        print(f"trials {', '.join(TRIALS)} of plan {args.plan}, {os.cpu_count()} cores, one used\n")
        table(Path(name), rivals, args.repeats)


if __name__ == "__main__":
    main()
