# SPDX-License-Identifier: MIT
"""Identify boats drawn at random; one line for each with a finding, then the sums."""

import sys
from collections.abc import Sequence

import benchmarks.fleet
from benchmarks.fleet.tables import line, sums
from benchmarks.fleet.work import identified
from benchmarks.harness import command
from benchmarks.harness.workers import gathered

FIRST = 1  # seed


def main(arguments: Sequence[str]) -> None:
    """Draw, drive, identify, sum up."""
    parser = command.parser("fleet", benchmarks.fleet.__doc__)
    parser.add_argument("--boats", type=int, default=20, help=f"how many, from seed {FIRST} on")
    command.with_workers(parser)
    given = parser.parse_args(arguments)
    jobs = [(seed,) for seed in range(FIRST, FIRST + given.boats)]
    rows = gathered(identified, jobs, given.workers)
    for row in rows:
        if text := line(row):
            print(f"{row.seed}: {text}")
    print(sums(rows))


if __name__ == "__main__":
    main(sys.argv[1:])
