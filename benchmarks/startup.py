# SPDX-License-Identifier: MIT
"""Gate: what a start costs: CPU seconds of whole processes, beside an empty Python.

python -m benchmarks.startup
"""

import os
import resource
import statistics
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.harness import command

REPEATS = 9
PROGRAM = str(Path(sys.executable).parent / "seatrial")
STARTS = {
    "`python -c pass`": [sys.executable, "-c", "pass"],
    "`import seatrial`": [sys.executable, "-c", "import seatrial"],
    "`seatrial --version`": [PROGRAM, "--version"],
    "`seatrial --help`": [PROGRAM, "--help"],
    "`seatrial identify --help`": [PROGRAM, "identify", "--help"],
    "`import numpy`": [sys.executable, "-c", "import numpy"],
    "`seatrial.identify`": [sys.executable, "-c", "import seatrial; seatrial.identify"],
}


def cpu(process: Sequence[str]) -> float:
    """CPU time [s] of a process, median of several after one that compiles what Python then keeps."""
    usual = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    times = []
    for _ in range(REPEATS + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(process, stdout=subprocess.DEVNULL, check=True, env=usual)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return statistics.median(times[1:])


def main(arguments: Sequence[str]) -> None:
    """Run."""
    command.parser("startup", __doc__).parse_args(arguments)
    print("| start of | CPU [s] |\n|---|---|")
    for name, process in STARTS.items():
        print(f"| {name} | {cpu(process):.3f} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
