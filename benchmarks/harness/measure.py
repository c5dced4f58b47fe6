# SPDX-License-Identifier: MIT
"""Time and memory of work in processes of its own: `python -m benchmarks.NAME --measure WHAT PATH`."""

import argparse
import json
import os
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from benchmarks.harness.command import ROOT

TIMES = ("seconds", "process")
CLOCK_TICKS = os.sysconf("SC_CLK_TCK")  # [1/s]
Measured = dict[str, Any]


def options(given: argparse.ArgumentParser) -> None:
    """The option that `measured` calls a benchmark with."""
    given.add_argument("--measure", nargs=2, help=argparse.SUPPRESS)
    given.add_argument("--cores", type=int, default=0, help=argparse.SUPPRESS)


def measure(given: argparse.Namespace, work: Mapping[str, Callable[[Path], Measured]]) -> bool:
    """In the process that `measured` started: do the work and print what it returns and the peak."""
    if not given.measure:
        return False
    if given.cores and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[-given.cores :])
    what, path = given.measure
    print(json.dumps({**work[what](Path(path)), "peak": peak()}))
    return True


def peak() -> int:
    """Most memory so far [bytes]; getrusage would count the parent's, before exec, too."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmHWM:")[2].split()[0]) << 10


def measured(
    name: str,
    what: str,
    path: Path,
    *,
    repeats: int = 1,
    cores: int = 0,
    environment: Mapping[str, str] | None = None,
) -> Measured:
    """Medians of the times and the largest peak [bytes] of `repeats` processes of their own."""
    command = [sys.executable, "-m", f"benchmarks.{name}", "--measure", what, str(path)]
    found = []
    for _ in range(repeats):
        begin = time.perf_counter()
        done = subprocess.run(
            [*command, "--cores", str(cores)], capture_output=True, text=True, check=False,
            cwd=ROOT, env={**os.environ, **(environment or {})},
        )  # fmt: skip
        if done.returncode:
            raise SystemExit(f"{what}: {done.stderr}")
        found.append({**json.loads(done.stdout), "process": time.perf_counter() - begin})
    middle = {k: statistics.median(f[k] for f in found) for k in found[0] if k in TIMES}
    return {**found[0], **middle, "peak": max(f["peak"] for f in found)}


def free_port(kind: socket.SocketKind = socket.SOCK_DGRAM) -> int:
    """A port that nobody has."""
    with socket.socket(socket.AF_INET, kind) as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def spent(pid: int) -> float:
    """Processor time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / CLOCK_TICKS
