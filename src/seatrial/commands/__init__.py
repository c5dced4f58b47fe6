# SPDX-License-Identifier: MIT
"""The commands, one file each: its arguments, and what it does; no logic.

Each reads, calls the library function of the same name, prints and writes. Its file is imported when it is called.
"""

import argparse
from collections.abc import Iterable
from importlib import import_module
from typing import Any, NoReturn

from seatrial.util.printing import say

COMMANDS = {
    "auto": "from logs to a validated model and its report, in one command",
    "demo": "run everything below on the bundled recordings",
    "inspect": "check recordings: rates, gaps, faults, clocks, excitation, signs; "
    "no --vehicle: list topics or columns",
    "init": "propose a vehicle file from a recording",
    "convert": "write a recording as tables or as a bag, with the vehicle file that reads it",
    "simulate": "simulate recordings like the paper's S1-S7",
    "identify": "identify a model from recordings",
    "validate": "score how well a model predicts recordings",
    "report": "write one offline HTML file: what was identified, and how well it predicts",
    "compare": "compare two models: which parameters changed, and does it affect prediction",
    "select": "select the terms that the recordings support",
    "tune": "tune a tracking controller from the model",
    "predict": "estimate velocity and odometry as on board: along a recording, or live from lines of text",
    "allocate": "compare allocation schemes, or allocate a wrench",
    "export": "write a model for another program",
    "sim": "simulate boats live: lines of commands in; lines of poses, IMU, LiDAR and truth out",
    "mimic": "make a holonomic robot move as the boat does: commands and robot poses in, robot velocity out",
}


class Parser(argparse.ArgumentParser):
    """Its errors are one line, as all others of the program, and exit with 2."""

    def error(self, message: str) -> NoReturn:
        """What is wrong with the arguments, and where to read what they may be."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


class CommandParser(Parser):
    """Parser of one command, empty until its command is called."""

    file: str | None = None  # of the command; None: its arguments are there

    def fill(self) -> None:
        """Import the command's file, which adds its arguments."""
        if self.file is not None:
            command = import_module(f"{__name__}.{self.file}")
            self.file = None
            self.add_argument("-q", "--quiet", action="store_true", help="no progress")
            command.add(self)
            self.set_defaults(run=command.run)

    def parse_known_args(
        self,
        args: Iterable[str] | None = None,
        namespace: Any = None,  # noqa: ANN401, as the method that it overrides
    ) -> tuple[Any, list[str]]:
        """As any parser's, with the command's own arguments."""
        self.fill()
        return super().parse_known_args(args, namespace)


class Version(argparse.Action):
    """Print the version, which is looked up only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        """Print it and exit."""
        from importlib.metadata import version

        say(f"{parser.prog} {version('seatrial')}")
        parser.exit()


def make_parser() -> argparse.ArgumentParser:
    """Of the program: one parser below it for every command."""
    parser = Parser(
        prog="seatrial", description="Dynamic models of small surface vehicles from a recording."
    )
    parser.add_argument(
        "--version", action=Version, nargs=0, help="show program's version number and exit"
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=CommandParser)
    for name, text in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")
        command.file = name
    return parser
