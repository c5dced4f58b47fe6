# SPDX-License-Identifier: MIT
"""Gate: `seatrial fleet` on 1 and 2 local workers: speed-up, overhead of Dask, a worker that is killed.

    python -m benchmarks.fleet_scaling              # 20 boats
    python -m benchmarks.fleet_scaling --boats 200

Simulated MallARD, plan clean, three recordings of 40 s a boat, one seed a boat. Every tenth boat has 1.2 times the
mass. The speed-up is that of the time of the boats. The start of the workers is left out, and printed by itself.
On a computer that others use at the same time it is a lower bound. Beside it is the CPU time that the workers have
used.
"""

import argparse
import os
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import psutil

from seatrial.boat.vehicle import load_vehicle
from seatrial.fleet.dask_cluster import cluster
from seatrial.fleet.fleet import fleet
from seatrial.fleet.fleet_file import Fleet, load_fleet
from seatrial.fleet.results import FleetResult
from seatrial.io.trial_files import write_setting, write_trial
from seatrial.simulation.plan import TrialEntry, load_plan, with_seed
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.parallel import farmed, working_on

SECONDS, KINDS = 40.0, ("surge", "sway", "yaw")  # of each recording
HEAVY_EVERY, HEAVIER = 10, 1.2  # boats, times the mass
EMPTY_ITEMS = 200  # that do nothing: the overhead
LARGE_FLEET = 10_000  # boats


def make_boats(root: Path, count: int) -> None:
    """A folder a boat."""
    vehicle = load_vehicle("mallard-mp")
    for seed in range(count):
        plan = with_seed(load_plan("clean"), seed)
        trials = {f"S{i}": TrialEntry(kind, SECONDS) for i, kind in enumerate(KINDS, 1)}
        plan = msgspec.structs.replace(plan, trials=trials)
        truth = plant_model(plan, vehicle)
        if seed % HEAVY_EVERY == HEAVY_EVERY - 1:
            truth = replace(truth, coefficients=truth.coefficients / HEAVIER)
        folder = root / f"boat-{seed:04d}"
        write_setting(plan, vehicle, truth, folder)
        for trial in simulate(plan, vehicle, truth):
            write_trial(trial, folder)


@dataclass(frozen=True)
class Ran:
    """One run of the fleet."""

    start: float  # [s] until the workers answer
    boats: float  # [s] of the boats
    cpu: float  # [s] of the workers, for the boats
    result: FleetResult


def nothing(_: None, item: int) -> int:
    """An item of no work."""
    return item


def prepared(_: None, item: int) -> int:
    """Import what a boat needs, so that it is not timed."""
    import seatrial.fleet.boat_work  # noqa: F401, PLC0415

    return item


def workers() -> list[psutil.Process]:
    """Dask's workers of this process."""
    found = psutil.Process().children(recursive=True)
    return [one for one in found if any("spawn_main" in word for word in one.cmdline())]


def cpu_seconds() -> float:
    """Of the workers."""
    return sum(sum(one.cpu_times()[:2]) for one in workers())


def run(boats: Fleet, out: Path, count: int, *, kill: bool = False) -> Ran:
    """The fleet on some workers; with `kill` one of them dies when a quarter of the boats is done."""
    begun = time.perf_counter()
    with cluster(workers=count) as farm:
        with working_on(farm):
            farmed(prepared, None, range(4 * count))
        ready, used = time.perf_counter(), cpu_seconds()
        if kill:
            threading.Thread(
                target=kill_one, args=(out, len(boats.boats) // 4), daemon=True
            ).start()
        result = fleet(boats, out, farm).result
        ended = time.perf_counter()
        return Ran(ready - begun, ended - ready, cpu_seconds() - used, result)


def kill_one(out: Path, done: int) -> None:
    """kill -9 of a worker as soon as so many boats are done."""
    while len(list(out.glob("boats/*/boat.json"))) < done:
        time.sleep(0.02)
    os.kill(workers()[0].pid, signal.SIGKILL)


def overhead(count: int) -> float:
    """[s] for each item that does nothing, one after the other's answer included."""
    with cluster(workers=count) as farm, working_on(farm):
        farmed(nothing, None, range(EMPTY_ITEMS))
        begun = time.perf_counter()
        farmed(nothing, None, range(EMPTY_ITEMS))
        return (time.perf_counter() - begun) / EMPTY_ITEMS


def main(arguments: Sequence[str]) -> None:
    """Run, and print the lines of docs/fleet.md."""
    parser = argparse.ArgumentParser("fleet_scaling", description=__doc__.splitlines()[0])
    parser.add_argument("--boats", type=int, default=20)
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        make_boats(root / "boats", given.boats)
        boats = load_fleet(root / "boats")
        one, two = (run(boats, root / f"out{count}", count) for count in (1, 2))
        for count, ran in ((1, one), (2, two)):
            print(
                f"{given.boats} boats x {len(KINDS)} recordings of {SECONDS:.0f} s, {count} workers: "
                f"{ran.boats:.1f} s ({ran.cpu / given.boats:.2f} CPU s a boat), start {ran.start:.1f} s",
                flush=True,
            )
        print(f"speed-up of 2 workers: {one.boats / two.boats:.2f}")
        differ = {f"boat-{i:04d}" for i in range(HEAVY_EVERY - 1, given.boats, HEAVY_EVERY)}
        print(f"heavy boats found: {len(differ & {*two.result.differing})} of {len(differ)}; "
              f"others named: {len({*two.result.differing} - differ)}")  # fmt: skip
        killed = run(boats, root / "killed", 2, kill=True)
        same = killed.result == two.result == one.result
        print(
            f"a worker killed at a quarter: {killed.boats:.1f} s, table {'the same' if same else 'DIFFERENT'}"
        )
        print(f"overhead of Dask: {1e3 * overhead(2):.1f} ms an item")
        lost = sorted({*one.result.failed, *two.result.failed, *killed.result.failed})
        print(f"boats without a model: {len(lost)}", *lost[:5])
        hours = one.cpu / given.boats * LARGE_FLEET / 3600.0
        print(f"on paper, {LARGE_FLEET} boats: {hours:.1f} CPU hours")
        if lost or not same:
            raise SystemExit(1)


if __name__ == "__main__":
    main(sys.argv[1:])
