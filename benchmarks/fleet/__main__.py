# SPDX-License-Identifier: MIT
"""Identify boats drawn at random; one line for each that is not as it should be, then the sums."""

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy; the worker processes inherit it

from benchmarks.fleet.tables import line, sums
from benchmarks.fleet.work import identified

FIRST = 1  # seed


def main(arguments: Sequence[str]) -> None:
    """Draw, drive, identify, sum up."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fleet", description=__doc__)
    parser.add_argument("--boats", type=int, default=20, help=f"how many, from seed {FIRST} on")
    given = parser.parse_args(arguments)
    seeds = range(FIRST, FIRST + given.boats)
    rows = []
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        for row in pool.map(identified, seeds):
            rows.append(row)
            if said := line(row):
                print(f"{row.seed}: {said}", flush=True)
    print(sums(rows))


if __name__ == "__main__":
    main(sys.argv[1:])
