# SPDX-License-Identifier: MIT
"""The commands, one file each: its arguments, and what it does; no logic.

Each reads, calls the library function of the same name, prints and writes.
"""

import argparse
from importlib.metadata import version
from typing import NoReturn

from seatrial.commands import (
    allocate,
    compare,
    demo,
    export,
    identify,
    init,
    inspect,
    mimic,
    predict,
    report,
    select,
    sim,
    simulate,
    tune,
    validate,
)

ORDER = (
    demo,
    inspect,
    init,
    simulate,
    identify,
    validate,
    report,
    compare,
    select,
    tune,
    predict,
    allocate,
    export,
    sim,
    mimic,
)


class Parser(argparse.ArgumentParser):
    """Its errors are one line, as all others of the program, and exit with 2."""

    def error(self, message: str) -> NoReturn:
        """What is wrong with the arguments, and where to read what they may be."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def make_parser() -> argparse.ArgumentParser:
    """Of the program: one parser below it for every command."""
    parser = Parser(
        prog="seatrial", description="Dynamic models of small surface vehicles from a recording."
    )
    parser.add_argument("--version", action="version", version=f"seatrial {version('seatrial')}")
    verbs = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in ORDER:
        command.add(verbs)
    return parser
