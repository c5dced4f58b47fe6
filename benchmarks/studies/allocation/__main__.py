# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them into docs/allocate.md."""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy

from benchmarks.allocation import board, drives, geometries
from benchmarks.blocks import fill

PAGE = Path(__file__).parents[2] / "docs" / "allocate.md"
BLOCKS: dict[str, Callable[[], str]] = {
    "mallard": drives.mallard,
    "ship": drives.ship,
    "geometries": geometries.table_of_boats,
    "speed": board.speed,
}


def main(arguments: Sequence[str]) -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.allocation", description=__doc__)
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(BLOCKS))
    parser.add_argument("--write", action="store_true", help="all, into the page")
    given = parser.parse_args(arguments)
    if odd := set(given.tables) - set(BLOCKS):
        parser.error(f"no table {', '.join(sorted(odd))}; there are {', '.join(BLOCKS)}")
    if given.write:
        fill(PAGE, BLOCKS)
        return
    for name in given.tables or BLOCKS:
        print(f"## {name}\n\n{BLOCKS[name]()}\n", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
