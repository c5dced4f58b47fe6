# SPDX-License-Identifier: MIT
"""Gate: logs with the faults that real ones have (tests/boats/log_faults.py), and what a gyro gains.

python -m benchmarks.log_faults [--seeds 5]

Three trials of the paper's boat, each with one fault, the vehicle file stating what is known of it. Printed
are the largest error in standard errors, the share of 95 % intervals that hold the truth, and CPU seconds
over those of the clean log; or the message.
"""

import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import seatrial
from benchmarks.fleet.work import in_errors
from benchmarks.harness import command
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.from_poses import make_recording
from seatrial.recording.yaw_rate import with_yaw_rate
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import Trial, plant_model, simulate
from seatrial.util.errors import SeatrialError
from seatrial.util.statistics import NORMAL_95
from tests.boats.log_faults import FAULTS, plain, table, vehicle_for, written
from tests.boats.plans import planned

NAMES = ("S1", "S2", "S3")
PLAN = "paper-like"
GYRO_RATE, GYRO_NOISE, GYRO_BIAS = 50.0, 0.01, 0.02  # [Hz, rad/s, rad/s]
GNSS_NOISE = (0.02, 0.02, 0.017)  # [m, m, rad]
FAST = 150.0  # [Hz] of the truth that a gyro is made of


def clean(poses: np.ndarray, commands: np.ndarray, _: object) -> tuple[str, str]:
    """No fault."""
    return table(("t", "x", "y", "psi"), poses), plain(commands)


def trials_of(boat: Vehicle, seed: int, rate: float | None = None) -> dict[str, Trial]:
    """Trials S1 to S3."""
    plan = planned(PLAN, *NAMES, seed=seed, pose={} if rate is None else {"rate": rate})
    return {t.name[:2]: t for t in simulate(plan, boat)}


def faults(boat: Vehicle, truth: dict[str, float], seeds: int) -> None:
    """The first table."""
    print("| fault | largest error | intervals that hold | CPU over clean | message |")
    print("|---|---|---|---|---|")
    usual = 0.0
    FAULTS["clean"] = clean
    for name in ("clean", *(n for n in FAULTS if n != "clean")):
        found, spent, said = [], 0.0, ""
        for seed in range(seeds):
            tables = {
                k: tuple(
                    np.column_stack([1e-9 * stamps, values])
                    for stamps, values in ((t.pose_stamps, t.pose), (t.command_stamps, t.command))
                )
                for k, t in trials_of(boat, seed).items()
            }  # fmt: skip
            tables = {k: (p[p[:, 0] >= 0], c) for k, (p, c) in tables.items()}
            with tempfile.TemporaryDirectory() as folder:
                paths = written(tables, name, Path(folder))
                vehicle = vehicle_for(boat, name)
                begin = time.process_time()
                try:
                    recordings = [seatrial.read(path, vehicle) for path in paths]
                    model = seatrial.identify(recordings, vehicle)
                    found.append([*in_errors(model, truth).values()])
                except SeatrialError as error:
                    said = str(error).partition(": ")[2]
                spent += time.process_time() - begin
        usual = usual or spent
        if said:
            print(f"| {name} | - | - | {spent / usual:.2f} | {said} |", flush=True)
            continue
        z = np.concatenate(found)
        print(
            f"| {name} | {np.abs(z).max():.1f} | {100 * np.mean(np.abs(z) < NORMAL_95):.0f} % | "
            f"{spent / usual:.2f} | |",
            flush=True,
        )


def gyro(boat: Vehicle, truth: dict[str, float], seeds: int) -> None:
    """The second table."""
    sizes: dict[str, list[float]] = {}
    errors = []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        without, with_gyro = [], []
        for name, trial in trials_of(boat, seed, FAST).items():
            every = slice(0, None, round(FAST / 5.0))
            eta = trial.pose[every] + rng.normal(0, GNSS_NOISE, trial.pose[every].shape)
            stamps = trial.pose_stamps[every]
            own = make_recording(name, stamps, eta, trial.recording.commands)
            t = np.arange(trial.truth_t[0], trial.truth_t[-1], 1 / GYRO_RATE)
            r = np.interp(t, trial.truth_t, trial.truth[:, 5])
            r += GYRO_BIAS + rng.normal(0, GYRO_NOISE, len(t))
            without.append(own)
            with_gyro.append(with_yaw_rate(own, np.rint(1e9 * t).astype(np.int64), r, "gyro"))
        before, after = (seatrial.identify(r, boat) for r in (without, with_gyro))
        errors.append([*in_errors(after, truth).values()])
        for name, error in after.standard_errors.items():
            if error > 0 and before.standard_errors.get(name, 0.0) > 0:
                sizes.setdefault(name, []).append(before.standard_errors[name] / error)
    print("| coefficient | standard error without over with gyro |\n|---|---|")
    for name, ratios in sizes.items():
        print(f"| {name} | {np.median(ratios):.2f} |")
    z = np.concatenate(errors)
    print(
        f"\nWith the gyro {100 * np.mean(np.abs(z) < NORMAL_95):.0f} % of intervals hold the truth; largest error "
        f"{np.abs(z).max():.1f} standard errors."
    )


def main(arguments: Sequence[str]) -> None:
    """Run."""
    parser = command.parser("log_faults", __doc__)
    parser.add_argument("--seeds", type=int, default=5, help="boats' drives (default: 5)")
    options = parser.parse_args(arguments)
    boat = seatrial.load_vehicle("mallard-mp")
    truth = plant_model(load_plan(PLAN), boat).values
    faults(boat, truth, options.seeds)
    print(
        f"\nPoses at 5 Hz ({GNSS_NOISE[0]} m, {GNSS_NOISE[2]} rad), gyro at {GYRO_RATE:.0f} Hz "
        f"({GYRO_NOISE} rad/s):\n"
    )
    gyro(boat, truth, options.seeds)


if __name__ == "__main__":
    main(sys.argv[1:])
