# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them and the picture into docs/."""

import sys

import benchmarks.studies.mpc
from benchmarks.harness import command
from benchmarks.studies.mpc.figure import draw
from benchmarks.studies.mpc.tables import MAKERS

if __name__ == "__main__":
    parser = command.parser("studies.mpc", benchmarks.studies.mpc.__doc__)
    given = command.tables(parser, sys.argv[1:], MAKERS)
    command.show(given, MAKERS, "mpc.md", lambda: draw(command.DOCS / "images" / "mpc.svg"))
