# SPDX-License-Identifier: MIT
"""Identify boats drawn at random; one line for each that is not as it should be, then the sums."""

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy; the worker processes inherit it

import numpy as np

from benchmarks.fleet.work import Row, identified
from seatrial.statistics import NORMAL_95

FIRST = 1  # seed
FAR = 4.0  # standard errors: worth a line


def line(row: Row) -> str:
    """What is not as it should be; nothing where all is."""
    far = {n: round(z, 1) for n, z in row.off.items() if abs(z) > FAR}
    parts = [f"refused: {row.refused}"] if row.refused else []
    parts += [f"{n} off by {z} standard errors" for n, z in far.items()]
    parts += [f"{n} not freed" for n in row.missed] if far else []
    parts += [f"{n} freed, is 1" for n in row.spurious]
    return "; ".join([*parts, *row.notes])


def sums(rows: Sequence[Row]) -> str:
    """Of all boats."""
    z = np.array([z for row in rows for z in row.off.values()])
    inside = 100.0 * np.mean(np.abs(z) < NORMAL_95)
    return "\n".join(
        [
            f"boats {len(rows)}, refused {sum(bool(r.refused) for r in rows)}, "
            f"with a remark {sum(bool(r.notes) for r in rows)}",
            f"estimates {len(z)}: {inside:.1f} % of 95 % intervals hold the truth; RMS error "
            f"{np.sqrt(np.mean(z**2)):.2f} standard errors, largest {np.abs(z).max():.1f}",
            f"stages of the curve that a boat has and that were not freed {sum(len(r.missed) for r in rows)}, "
            f"freed though it has none {sum(len(r.spurious) for r in rows)}",
        ]
    )


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
