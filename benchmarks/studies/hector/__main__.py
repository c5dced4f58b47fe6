# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them into docs/slam.md."""

import sys
import tempfile
from functools import partial
from pathlib import Path

import benchmarks.studies.hector
from benchmarks.harness import command
from seatrial.util.errors import SeatrialError
from tests import hector_tools

try:
    from benchmarks.studies.hector.figure import draw
    from benchmarks.studies.hector.study import run
    from benchmarks.studies.hector.tables import CASES, table
    from benchmarks.studies.slam.study import SEEDS
except SeatrialError as missing:
    raise SystemExit(f"error: {missing}") from None

if __name__ == "__main__":
    parser = command.parser("studies.hector", benchmarks.studies.hector.__doc__)
    command.with_seeds(parser, len(SEEDS), SEEDS[0])
    given = command.tables(parser, sys.argv[1:], CASES)
    if hector_tools.program() is None:
        parser.error(f"{hector_tools.VARIABLE} names no hector_mapping; expected: the program or the folder "
                     "that it was built in")  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        cases = list(dict.fromkeys(case for table in given.tables for case in CASES[table]))
        seeds = range(SEEDS[0], SEEDS[0] + given.seeds)
        study = run(cases, Path(name), seeds, given.workers)
    makers = {name: partial(table, name, study) for name in CASES}
    picture = partial(draw, study.outcomes, command.DOCS / "images" / "slam-hector.svg")
    command.show(given, makers, "slam.md", picture)
