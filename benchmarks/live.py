# SPDX-License-Identifier: MIT
"""The estimate while driving: share of a core, memory, latency, and its distance from `identify`.

    python -m benchmarks.live                # ten minutes of a pushed boat, poses at 50 Hz, commands at 100 Hz
    python -m benchmarks.live --minutes 121 --memory    # memory every half hour; --rate 5: sooner
    python -m benchmarks.live --boat twin    # two thrusters, wind with gusts

Time is that of the drive: the rows are used as fast as they can be, work is due four times a second of the drive.
CPU time is of the thread that uses the rows and works.
"""

import argparse
import itertools
import resource
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

import seatrial
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.poolside.live_estimator import LiveEstimator
from seatrial.poolside.live_prediction import LivePrediction
from seatrial.recording.recording import Recording
from tests.boats.live_drives import Row, holonomic, rows, twin_in_wind

RATE = 50.0  # [Hz] of the poses
REPEATED = 300.0  # [s] of the drive that is played again and again for the memory
PAUSE = 5_000_000_000  # [ns] between two turns
HALF_HOUR = 1_800_000_000_000  # [ns]
EVERY = 250_000_000  # [ns] of the drive between two calls of work
BOATS = {"holonomic": holonomic, "twin": twin_in_wind}
MEGABYTE = 1e6
KILOBYTES = 1e-3 if sys.platform == "linux" else 1e-6  # of ru_maxrss, in MB


def at_100_hz(recording: Recording) -> list[Row]:
    """The rows of a recording, every command a second time 10 ms later."""
    found = list(rows(recording))
    found += [(s + 10_000_000, k, v) for s, k, v in found if k == "command"]
    return sorted(found, key=lambda row: (row[0], row[1]))


def again_and_again(found: list[Row], seconds: float) -> Iterator[Row]:
    """Rows of a drive that is played again after a pause, up to a time [s]: what takes long is not simulated."""
    begin, length = found[0][0], found[-1][0] - found[0][0] + PAUSE
    for turn in itertools.count():
        for stamp, kind, values in found:
            if 1e-9 * (stamp - begin + turn * length) > seconds:
                return
            yield stamp + turn * length, kind, values


def resident() -> float:
    """Memory [MB] of this process now."""
    if sys.platform == "linux":
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize() / MEGABYTE
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * KILOBYTES


def driven(
    vehicle: Vehicle, found: Iterable[Row], *, memory: bool = False
) -> tuple[LiveEstimator, list[float], list[float]]:
    """The estimator at the end, and CPU seconds of each call of use, and of each of work.

    memory: print that of the process every half hour of the drive.
    """
    begin_memory, first, half_hour = resident(), 0, 0
    estimator, prediction = LiveEstimator(vehicle), LivePrediction()
    used, worked, due = [], [], 0
    for stamp, kind, values in found:
        first = first or stamp
        half_hour = half_hour or first + HALF_HOUR
        if memory and stamp >= half_hour:
            grown, minutes = resident() - begin_memory, 1e-9 * (half_hour - first) / 60.0
            print(
                f"{minutes:.0f} min: {grown:.0f} MB more, {estimator.log.bytes / MEGABYTE:.0f} MB of rows",
                flush=True,
            )
            half_hour += HALF_HOUR
        begin = time.thread_time()
        estimator.use(kind, stamp, values)
        prediction.use(kind, stamp, values)
        used.append(time.thread_time() - begin)
        if stamp >= due:
            due = stamp + EVERY
            begin = time.process_time()
            if estimator.work() and (model := estimator.model()) is not None:
                prediction.reload(model)
            worked.append(time.process_time() - begin)
    while estimator.work(ended=True):
        pass
    return estimator, used, worked


def use_during_work(vehicle: Vehicle, found: list[Row]) -> list[float]:
    """Wall seconds of each call of use while another thread works all the time."""
    estimator, ended, waits = LiveEstimator(vehicle), threading.Event(), []

    def work() -> None:
        while not ended.is_set():
            estimator.work()
            time.sleep(0.005)

    worker = threading.Thread(target=work)
    worker.start()
    for stamp, kind, values in found:
        begin = time.perf_counter()
        estimator.use(kind, stamp, values)
        waits.append(time.perf_counter() - begin)
    ended.set()
    worker.join()
    return waits


def apart(model: Model, whole: Model) -> tuple[float, str]:
    """Largest distance of a parameter in standard errors, and its name."""
    values = [np.concatenate([m.coefficients, m.constants]) for m in (model, whole)]
    far = {
        name: abs(a - b) / error
        for (name, error), a, b in zip(whole.standard_errors.items(), *values, strict=True)
        if error > 0
    }
    name = max(far, key=lambda n: far[n])
    return far[name], name


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--boat", choices=BOATS, default="holonomic")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rate", type=float, default=RATE, help="[Hz] of the poses")
    parser.add_argument("--memory", action="store_true", help="memory every half hour, no more")
    options = parser.parse_args()
    seconds = min(60.0 * options.minutes, REPEATED) if options.memory else 60.0 * options.minutes
    vehicle, recording = BOATS[options.boat](seconds, seed=options.seed, rate=options.rate)
    found = at_100_hz(recording)
    if options.memory:
        driven(vehicle, again_and_again(found, 60.0 * options.minutes), memory=True)
        return
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    estimator, used, worked = driven(vehicle, found)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * KILOBYTES
    live = estimator.model()
    assert live is not None, estimator.problem
    far, name = apart(live, seatrial.identify([recording], vehicle))
    waits = np.array(use_during_work(vehicle, found))
    hours = seconds / 3600.0
    p50, p99, most = 1e6 * np.percentile(waits, [50, 99, 100])
    table = [
        ("drive", f"{options.minutes:g} min, {estimator.log.poses} poses, {len(found)} rows"),
        ("share of a core: rows", f"{100 * sum(used) / seconds:.2f} %"),
        ("share of a core: work", f"{100 * sum(worked) / seconds:.2f} %"),
        (
            "a call of work: median, longest",
            f"{1e3 * np.median(worked):.1f} ms, {max(worked):.2f} s",
        ),
        ("a row during work: median, 99 %, longest", f"{p50:.0f}, {p99:.0f}, {most:.0f} us"),
        ("memory of the log", f"{estimator.log.bytes / MEGABYTE / hours:.1f} MB/h"),
        ("peak memory above the start", f"{grown:.0f} MB"),
        ("live from identify", f"{far:.3f} standard errors ({name})"),
    ]
    for what, figure in table:
        print(f"{what:42} {figure}")


if __name__ == "__main__":
    main()
