# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them into docs/tune.md."""

import sys

import benchmarks.studies.guidance
from benchmarks.harness import command
from benchmarks.studies.guidance.tables import MAKERS

if __name__ == "__main__":
    parser = command.parser("studies.guidance", benchmarks.studies.guidance.__doc__)
    command.show(command.tables(parser, sys.argv[1:], MAKERS), MAKERS, "tune.md")
