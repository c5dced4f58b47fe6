# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them into docs/slam.md."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy; the worker processes inherit it

from benchmarks.blocks import refill
from seatrial.errors import SeatrialError

try:
    from benchmarks.slam.figure import draw
    from benchmarks.slam.study import run
    from benchmarks.slam.tables import CASES, table
except SeatrialError as missing:
    raise SystemExit(f"error: {missing}") from None

DOCS = Path(__file__).parents[2] / "docs"
PAGE, PICTURE = DOCS / "slam.md", DOCS / "images" / "slam.svg"


def main(arguments: Sequence[str]) -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.slam", description=__doc__)
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(CASES))
    parser.add_argument("--write", action="store_true", help=f"into {PAGE.name}")
    given = parser.parse_args(arguments)
    if odd := set(given.tables) - set(CASES):
        parser.error(f"no table {', '.join(sorted(odd))}; there are {', '.join(CASES)}")
    names = given.tables or list(CASES)
    outcomes = run(list(dict.fromkeys(case for name in names for case in CASES[name])))
    made = {name: table(name, outcomes) for name in names}
    if not given.write:
        print("\n\n".join(f"## {name}\n\n{text}" for name, text in made.items()))
        return
    refill(PAGE, made)
    draw(PICTURE)


if __name__ == "__main__":
    main(sys.argv[1:])
