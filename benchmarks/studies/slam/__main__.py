# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them into docs/slam.md."""

import sys
from functools import partial

import benchmarks.studies.slam
from benchmarks.harness import command
from seatrial.util.errors import SeatrialError

try:
    from benchmarks.studies.slam.figure import draw
    from benchmarks.studies.slam.study import run
    from benchmarks.studies.slam.tables import CASES, table
except SeatrialError as missing:
    raise SystemExit(f"error: {missing}") from None

if __name__ == "__main__":
    parser = command.parser("studies.slam", benchmarks.studies.slam.__doc__)
    given = command.tables(parser, sys.argv[1:], CASES)
    outcomes = run(list(dict.fromkeys(case for name in given.tables for case in CASES[name])))
    makers = {name: partial(table, name, outcomes) for name in CASES}
    command.show(given, makers, "slam.md", partial(draw, command.DOCS / "images" / "slam.svg"))
