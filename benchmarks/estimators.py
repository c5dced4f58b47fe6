# SPDX-License-Identifier: MIT
"""Gate: the estimator and an independent one with SciPy: one problem, one answer; and both times.

    python -m benchmarks.estimators

Simulated MallARD, trials S1 to S3, 200 s each at 15 Hz: the 11 coefficients and the initial state of
every recording, from the poses, weighted with their noise; actuator chain given, no process noise.
Each is a process of its own on one core, and starts from the same values. It fails where
coefficients differ by 0.1 %. "estimation" is from arrays in memory to coefficients. Machines are
noisy: read the ratios. The last row is `seatrial.identify` as a user calls it: noise, process noise
and fit horizon from the poses too, and the checks of the recordings.
"""

# ruff: noqa: PLC0415 what is not measured is not imported either

import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.harness import command
from benchmarks.harness.measure import Measured, measure, measured, options
from benchmarks.scipy_rollout import STEPS, Array, Problem

TRIALS = ("S1", "S2", "S3")
POSE_SPREAD = 3.0  # of the first pose, in standard deviations of one: as the core has it
NONE = 1e-9  # of process noise: its limit
DIGITS = 1e-3  # by which coefficients may differ
NAMES = {
    "seatrial": "seatrial",
    "scipy": "SciPy least_squares, NumPy roll-out",
    "automatic": "seatrial.identify, all automatic",
}
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def prepare(folder: Path, plan_name: str) -> None:
    """Trials as tables for seatrial, and the same as arrays for SciPy."""
    import msgspec

    import seatrial
    from seatrial.boat.schema import NoiseEntry, ProcessEntry
    from seatrial.identification.regression.equation_error import equation_error
    from seatrial.io.trial_files import write_setting, write_trial
    from seatrial.simulation.plan import DropOuts, Jumps, load_plan
    from seatrial.simulation.trials import plant_model, simulate
    from tests.boats.plans import planned

    plan = load_plan(plan_name)
    chain = [msgspec.structs.replace(group, latency=0.0) for group in plan.plant.chain]
    pose = {"drop_outs": DropOuts(per_minute=0.0), "jumps": Jumps(per_minute=0.0)}
    plan = planned(plan, *TRIALS, plant={"chain": chain}, pose=pose, joypad={"clock_offset": 0.0})
    truth = plant_model(plan, seatrial.load_vehicle("mallard-mp"))
    write_setting(plan, truth.vehicle, truth, folder)
    for trial in simulate(plan, truth.vehicle):
        write_trial(trial, folder)
    vehicle, recordings = read(folder)
    start = equation_error(recordings, vehicle)
    noise = NoiseEntry(
        plan.pose.position_noise, plan.pose.heading_noise, ProcessEntry(*[NONE] * 4, 1.0)
    )
    seatrial.save(replace(start, noise=noise), folder / "start.yaml")
    as_arrays(recordings, truth, start.coefficients).save(folder / "problem.npz")


def read(folder: Path) -> tuple[object, list[object]]:
    """The vehicle, chain and all, and its recordings."""
    import seatrial

    vehicle = seatrial.load_vehicle(folder / "vehicle-MP.yaml")
    return vehicle, [seatrial.read(folder / f"{name}-MP", vehicle) for name in TRIALS]


def as_arrays(recordings: list[object], truth: object, theta: Array) -> Problem:
    """Arrays for SciPy; the forces of the thrusters are given."""
    from seatrial.evaluation.filtering import START_VELOCITY_DEVIATION
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
    spread = np.concatenate([POSE_SPREAD * sigma, START_VELOCITY_DEVIATION])
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


def with_seatrial(folder: Path) -> Measured:
    """The output-error method at given settings: noise held, no process noise, chain stated."""
    import seatrial
    from seatrial.identification.estimator import OutputErrorSettings, fit

    vehicle, recordings = read(folder)
    start = seatrial.load(folder / "start.yaml")
    settings = OutputErrorSettings(outlier=np.inf, hold_noise=True)
    begin = time.perf_counter()
    found = fit(recordings, vehicle, settings=settings, start=start)
    seconds = time.perf_counter() - begin
    return {"seconds": seconds, "theta": found.theta[: found.problem.n_coefficients].tolist()}


def with_scipy(folder: Path) -> Measured:
    """SciPy's, after its imports."""
    from benchmarks.scipy_rollout import solve

    problem = Problem.load(folder / "problem.npz")
    begin = time.perf_counter()
    theta, steps = solve(problem)
    seconds = time.perf_counter() - begin
    return {"seconds": seconds, "theta": theta.tolist(), "steps": steps}


def automatic(folder: Path) -> Measured:
    """All that a user's call does."""
    import seatrial

    vehicle, recordings = read(folder)
    begin = time.perf_counter()
    seatrial.identify(recordings, vehicle)
    return {"seconds": time.perf_counter() - begin}


WORK = {"seatrial": with_seatrial, "scipy": with_scipy, "automatic": automatic}


def agree(what: str, theta: Array, base: Array) -> float:
    """The largest relative difference of a coefficient; raises where it is not the same answer."""
    worst = float(np.max(np.abs(theta / base - 1.0)))
    if not worst < DIGITS:
        raise SystemExit(f"{what} found {theta.tolist()}, seatrial {base.tolist()}")
    return worst


def table(folder: Path, repeats: int) -> None:
    """All, beside seatrial at given settings."""
    found = {
        what: measured("estimators", what, folder, repeats=repeats, cores=1, environment=ONE_THREAD)
        for what in WORK
    }
    base = found["seatrial"]
    print("| | process [s] | ratio | estimation [s] | ratio | steps | differs by |")
    print("|---|---|---|---|---|---|---|")
    for what, got in found.items():
        differs = ""
        if "theta" in got:
            differs = f"{agree(what, np.array(got['theta']), np.array(base['theta'])):.0e}"
        print(
            f"| {NAMES[what]} | {got['process']:.2f} | {got['process'] / base['process']:.1f} "
            f"| {got['seconds']:.3f} | {got['seconds'] / base['seconds']:.1f} "
            f"| {got.get('steps', '')} | {differs} |"
        )


def main(arguments: Sequence[str]) -> None:
    """Run."""
    parser = command.parser("estimators", __doc__)
    parser.add_argument("--plan", default="hard", help="for instance paper-like")
    parser.add_argument("--repeats", type=int, default=3)
    options(parser)
    given = parser.parse_args(arguments)
    if measure(given, WORK):
        return
    with tempfile.TemporaryDirectory() as name:
        prepare(Path(name), given.plan)
        print(
            f"trials {', '.join(TRIALS)} of plan {given.plan}, {os.cpu_count()} cores, one used\n"
        )
        table(Path(name), given.repeats)


if __name__ == "__main__":
    main(sys.argv[1:])
