# SPDX-License-Identifier: MIT
"""Gate: the output-error method on its own: whole processes, time against length, memory.

    python -m benchmarks.scaling            # up to 1 hour of driving
    python -m benchmarks.scaling --long     # 10 hours, too; takes minutes

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
from collections.abc import Sequence
from pathlib import Path

from benchmarks.harness import command
from benchmarks.harness.measure import Measured, measure, measured, options

TRIAL = 200.0  # [s]
HOUR = 3600.0  # [s]
REPEATS = 3
KINDS = ("surge", "sway", "yaw")


def drive(folder: Path, seconds: float, kind: str = "csv") -> None:
    """Recordings of at most an hour, `seconds` in all, surge, sway and yaw in turns; the vehicle."""
    import msgspec

    import seatrial
    from seatrial.io.trial_files import write_setting, write_trial
    from seatrial.simulation.plan import TrialEntry, load_plan
    from seatrial.simulation.trials import plant_model, simulate

    plan = load_plan("hard")
    hours = max(1, round(seconds / HOUR))
    each = seconds / hours / len(KINDS)
    trials = {f"L{i}{j}": TrialEntry(k, each) for i in range(hours) for j, k in enumerate(KINDS)}
    plan = msgspec.structs.replace(plan, trials=trials)
    vehicle = seatrial.load_vehicle("mallard-mp")
    write_setting(plan, vehicle, plant_model(plan, vehicle), folder)
    for trial in simulate(plan, vehicle):
        write_trial(trial, folder, kind)


def read(folder: Path) -> tuple[object, list[object]]:
    """The vehicle, and all recordings of a folder."""
    import seatrial

    vehicle = seatrial.load_vehicle(folder / "vehicle-MP.yaml")
    return vehicle, [seatrial.read(path, vehicle) for path in sorted(folder.glob("*-MP"))]


def automatic(folder: Path) -> Measured:
    """All choices made by the estimator."""
    from seatrial.identification.estimator import output_error

    vehicle, recordings = read(folder)
    begin = time.perf_counter()
    output_error(recordings, vehicle)
    return {"seconds": time.perf_counter() - begin}


def identify(folder: Path) -> Measured:
    """`seatrial identify` of all that a folder has, reading and writing included."""
    from seatrial.commands.cli import main as seatrial_main

    paths = [str(path) for path in sorted(folder.glob("*-MP"))]
    out = ["--vehicle", str(folder / "vehicle-MP.yaml"), "-o", str(folder / "m.yaml")]
    begin = time.perf_counter()
    with contextlib.redirect_stdout(None):
        status = seatrial_main(["identify", "--quiet", *paths, *out])
    if status:
        raise SystemExit(status)
    return {"seconds": time.perf_counter() - begin}


WORK = {"automatic": automatic, "command": identify}


def process() -> None:
    """`seatrial identify` of three bags, start-up, reading and writing included."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        drive(folder, len(KINDS) * TRIAL, "bag")
        identify = [str(Path(sys.executable).parent / "seatrial"), "identify", "--vehicle"]
        identify += [str(folder / "vehicle-MP.yaml"), "-o", str(folder / "m.yaml")]
        identify += [str(path) for path in sorted(folder.glob("*-MP.bag"))]
        usual = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        times = []
        for _ in range(REPEATS + 1):  # the first compiles what Python then keeps
            begin = time.perf_counter()
            subprocess.run(identify, stdout=subprocess.DEVNULL, check=True, env=usual)
            times.append(time.perf_counter() - begin)
        print(f"`seatrial identify` of three bags of 200 s, as a process: "
              f"{statistics.median(times[1:]):.2f} s\n")  # fmt: skip


def lengths(*, long: bool) -> None:
    """Time and memory against length."""
    print("| driven [s] | cores | estimation [s] | per 1000 s [s] | peak [MB] |")
    print("|---|---|---|---|---|")
    for seconds in (len(KINDS) * TRIAL, HOUR, *([10 * HOUR] if long else [])):
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


def main(arguments: Sequence[str]) -> None:
    """Run."""
    parser = command.parser("scaling", __doc__)
    parser.add_argument("--long", action="store_true", help="10 hours; takes minutes")
    options(parser)
    chosen = parser.parse_args(arguments)
    if measure(chosen, WORK):
        return
    process()
    lengths(long=chosen.long)


if __name__ == "__main__":
    main(sys.argv[1:])
