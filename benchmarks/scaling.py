# SPDX-License-Identifier: MIT
"""Gate: the output-error method on its own: time against length, memory, whole processes, refits.

    python -m benchmarks.scaling            # up to 1 hour of driving
    python -m benchmarks.scaling --long     # 10 hours, too; takes minutes
    python -m benchmarks.scaling --refits   # 200 bootstrap refits, on one core and on all

Simulated MallARD, plan hard. Every measurement is a process of its own; "one core" means that it
is kept on one.
"""

# ruff: noqa: PLC0415 what is not measured is not imported either

import contextlib
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.harness import command
from benchmarks.harness.measure import Measured, measure, measured, options

TRIAL = 200.0  # [s]
HOUR = 3600.0  # [s]
TRIALS = ("S1", "S2", "S3")
REPEATS = 3
REFITS = 200


def prepare(folder: Path, kind: str = "csv") -> None:
    """The three trials, and the vehicle."""
    import msgspec

    import seatrial
    from seatrial.io.write import write_setting, write_trial
    from seatrial.simulation.plan import load_plan
    from seatrial.simulation.trials import plant_model, simulate

    plan = load_plan("hard")
    plan = msgspec.structs.replace(plan, trials={name: plan.trials[name] for name in TRIALS})
    vehicle = seatrial.load_vehicle("mallard-mp")
    write_setting(plan, vehicle, plant_model(plan, vehicle), folder)
    for trial in simulate(plan, vehicle):
        write_trial(trial, folder, kind)


def drive(folder: Path, seconds: float) -> None:
    """Recordings of at most an hour, `seconds` in all, surge, sway and yaw in turns."""
    import msgspec

    import seatrial
    from seatrial.io.write import write_setting, write_trial
    from seatrial.simulation.plan import TrialEntry, load_plan
    from seatrial.simulation.trials import plant_model, simulate

    plan = load_plan("hard")
    hours = max(1, round(seconds / HOUR))
    kinds = ("surge", "sway", "yaw")
    trials = {
        f"L{i}{j}": TrialEntry(kind, seconds / hours / 3)
        for i in range(hours)
        for j, kind in enumerate(kinds)
    }
    plan = msgspec.structs.replace(plan, trials=trials)
    vehicle = seatrial.load_vehicle("mallard-mp")
    write_setting(plan, vehicle, plant_model(plan, vehicle), folder)
    for trial in simulate(plan, vehicle):
        write_trial(trial, folder)


def read(folder: Path) -> tuple[object, list[object]]:
    """The vehicle, and all recordings of a folder."""
    import seatrial

    vehicle = seatrial.load_vehicle(folder / "vehicle-MP.yaml")
    return vehicle, [seatrial.read(path, vehicle) for path in sorted(folder.glob("*-MP"))]


def automatic(folder: Path) -> float:
    """All choices made by the estimator [s]."""
    from seatrial.identification.estimator import output_error

    vehicle, recordings = read(folder)
    begin = time.perf_counter()
    output_error(recordings, vehicle)
    return time.perf_counter() - begin


def given(folder: Path) -> float:
    """The coefficients at given settings [s]: thrusters and noise stated, start values its own.

    The problem of estimators.py, whose contenders all start from the paper's method. The checks of
    the vehicle file and of the model are in the figure of the whole process, not in this.
    """
    from dataclasses import replace

    import seatrial
    from benchmarks.estimators import read as problem
    from seatrial.identification.estimator import OutputErrorSettings, output_error
    from seatrial.identification.regression.weak_form import weak_form

    vehicle, recordings = problem(folder)
    stated = seatrial.load(folder / "start.yaml").noise
    begin = time.perf_counter()
    start = replace(weak_form(recordings, vehicle), noise=stated)
    output_error(recordings, vehicle, settings=OutputErrorSettings(hold_noise=True), start=start)
    return time.perf_counter() - begin


def identify(folder: Path) -> float:
    """`seatrial identify` of all that a folder has [s], reading and writing included."""
    from seatrial.commands.cli import main as seatrial_main

    paths = [str(path) for path in sorted(folder.glob("*-MP"))]
    out = ["--vehicle", str(folder / "vehicle-MP.yaml"), "-o", str(folder / "m.yaml")]
    begin = time.perf_counter()
    with contextlib.redirect_stdout(None):
        status = seatrial_main(["identify", "--quiet", *paths, *out])
    if status:
        raise SystemExit(status)
    return time.perf_counter() - begin


def refits(folder: Path) -> float:
    """200 refits on resampled blocks [s], the first fit not counted."""
    from seatrial.identification.estimator import fit
    from seatrial.identification.uncertainty.bootstrap import bootstrap

    vehicle, recordings = read(folder)
    found = fit(recordings, vehicle)
    begin = time.perf_counter()
    bootstrap(found, REFITS)
    return time.perf_counter() - begin


def timed(work: Callable[[Path], float]) -> Callable[[Path], Measured]:
    """The work with its seconds as a record."""
    return lambda folder: {"seconds": work(folder)}


WORK = {
    "automatic": timed(automatic), "given": timed(given), "command": timed(identify),
    "refits": timed(refits),
}  # fmt: skip


def process() -> None:
    """`seatrial identify` of three bags, start-up, reading and writing included; given settings."""
    from benchmarks.estimators import prepare as prepare_problem

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        prepare(folder, "bag")
        command = [str(Path(sys.executable).parent / "seatrial"), "identify"]
        command += ["--method", "output-error", *(str(folder / f"{t}-MP.bag") for t in TRIALS)]
        command += ["--vehicle", str(folder / "vehicle-MP.yaml"), "-o", str(folder / "m.yaml")]
        usual = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        times = []
        for _ in range(REPEATS + 1):  # the first compiles what Python then keeps
            begin = time.perf_counter()
            subprocess.run(command, stdout=subprocess.DEVNULL, check=True, env=usual)
            times.append(time.perf_counter() - begin)
        at = folder / "given"
        at.mkdir()
        prepare_problem(at, "hard")
        own = measured("scaling", "given", at, cores=1, repeats=REPEATS)["seconds"]
        print(f"at given settings, from arrays to coefficients, on one core: {own:.2f} s")
        print(f"`seatrial identify` of three bags of 200 s, as a process: "
              f"{statistics.median(times[1:]):.2f} s\n")  # fmt: skip


def lengths(*, long: bool) -> None:
    """Time and memory against length."""
    print("| driven [s] | cores | estimation [s] | per 1000 s [s] | peak [MB] |")
    print("|---|---|---|---|---|")
    for seconds in (3 * TRIAL, HOUR, *([10 * HOUR] if long else [])):
        with tempfile.TemporaryDirectory() as name:
            drive(Path(name), seconds)
            for cores in (1, os.cpu_count() or 1):
                repeats = REPEATS if seconds < HOUR else 1
                got = measured("scaling", "automatic", Path(name), cores=cores, repeats=repeats)
                each = 1e3 * got["seconds"] / seconds
                print(
                    f"| {seconds:.0f} | {cores} | {got['seconds']:.2f} | {each:.2f} "
                    f"| {got['peak'] / 1e6:.0f} |",
                    flush=True,
                )
            if seconds > HOUR:
                whole = measured("scaling", "command", Path(name), cores=os.cpu_count() or 1)
                last = f"{whole['seconds']:.0f} s, peak {whole['peak'] / 1e6:.0f} MB"
                print(f"\n`seatrial identify` of {seconds:.0f} s: {last}")


def threads() -> None:
    """The bootstrap on one core and on all."""
    print(f"| {REFITS} refits, cores | [s] |")
    print("|---|---|")
    with tempfile.TemporaryDirectory() as name:
        prepare(Path(name))
        for cores in (1, os.cpu_count() or 1):
            got = measured("scaling", "refits", Path(name), cores=cores)
            print(f"| {cores} | {got['seconds']:.2f} |", flush=True)


def main(arguments: Sequence[str]) -> None:
    """Run."""
    parser = command.parser("scaling", __doc__)
    parser.add_argument("--long", action="store_true", help="10 hours; takes minutes")
    parser.add_argument("--refits", action="store_true", help="the bootstrap")
    options(parser)
    chosen = parser.parse_args(arguments)
    if measure(chosen, WORK):
        return
    if chosen.refits:
        threads()
        return
    process()
    lengths(long=chosen.long)


if __name__ == "__main__":
    main(sys.argv[1:])
