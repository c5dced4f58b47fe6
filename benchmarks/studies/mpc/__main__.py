# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them and the picture into docs/."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy

from benchmarks.blocks import refill
from benchmarks.mpc.figure import draw
from benchmarks.mpc.tables import MAKERS

DOCS = Path(__file__).parents[2] / "docs"


def main(arguments: Sequence[str]) -> None:
    """Make what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mpc", description=__doc__)
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(MAKERS))
    parser.add_argument(
        "--write", action="store_true", help="into docs/mpc.md, docs/images/mpc.svg"
    )
    given = parser.parse_args(arguments)
    if odd := set(given.tables) - set(MAKERS):
        parser.error(f"no table {', '.join(sorted(odd))}; there are {', '.join(MAKERS)}")
    made = {}
    for name in given.tables or MAKERS:
        made[name] = MAKERS[name]()
        print(f"## {name}\n\n{made[name]}\n", flush=True)
    if not given.write:
        return
    refill(DOCS / "mpc.md", made)
    if not given.tables:
        draw(DOCS / "images" / "mpc.svg")


if __name__ == "__main__":
    main(sys.argv[1:])
