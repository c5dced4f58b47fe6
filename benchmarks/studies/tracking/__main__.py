# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them into docs/tune.md."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy

from benchmarks.blocks import refill
from benchmarks.tracking.tables import MAKERS

PAGE = Path(__file__).parents[2] / "docs" / "tune.md"


def main(arguments: Sequence[str]) -> None:
    """Make what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.tracking", description=__doc__)
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(MAKERS))
    parser.add_argument("--write", action="store_true", help=f"into {PAGE.name}")
    given = parser.parse_args(arguments)
    if odd := set(given.tables) - set(MAKERS):
        parser.error(f"no table {', '.join(sorted(odd))}; there are {', '.join(MAKERS)}")
    made = {}
    for name in given.tables or MAKERS:
        made[name] = MAKERS[name]()
        print(f"## {name}\n\n{made[name]}\n", flush=True)
    if given.write:
        refill(PAGE, made)


if __name__ == "__main__":
    main(sys.argv[1:])
