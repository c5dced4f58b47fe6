# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them into docs/allocate.md."""

import sys

import benchmarks.studies.allocation
from benchmarks.harness import command
from benchmarks.studies.allocation import board, drives, geometries

MAKERS = {
    "mallard": drives.mallard,
    "ship": drives.ship,
    "geometries": geometries.table_of_boats,
    "speed": board.speed,
}

if __name__ == "__main__":
    parser = command.parser("studies.allocation", benchmarks.studies.allocation.__doc__)
    command.show(command.tables(parser, sys.argv[1:], MAKERS), MAKERS, "allocate.md")
