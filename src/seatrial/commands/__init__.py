# SPDX-License-Identifier: MIT
"""The commands, one file each: its arguments, and what it does; no logic.

Each reads, calls the library function of the same name, prints and writes. Its file is imported when it is called.
"""

import argparse
import sys
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from importlib import import_module
from typing import Any, NoReturn

from seatrial.util.printing import complain, say

COMMANDS = {
    "auto": "from logs to a validated model and its report, in one command",
    "demo": "run everything below on the bundled recordings",
    "inspect": "check recordings: rates, gaps, faults, clocks, excitation, signs; "
    "no --vehicle: list topics or columns",
    "init": "propose a vehicle file from a recording",
    "live": "identify while driving: a local page shows what is known, what to drive next, and when it is enough",
    "convert": "write a recording as tables or as a bag, with the vehicle file that reads it",
    "simulate": "simulate recordings like the paper's S1-S7, or of your own boat",
    "identify": "identify a model from recordings",
    "validate": "score how well a model predicts recordings",
    "report": "write one offline HTML file: what was identified, and how well it predicts",
    "compare": "compare two models: which parameters changed, and does it affect prediction",
    "fleet": "identify, validate and compare many boats: one table and one report",
    "select": "select the terms that the recordings support",
    "tune": "tune a tracking controller from the model",
    "predict": "estimate velocity and odometry as on board: along a recording, or live from lines of text",
    "allocate": "compare allocation schemes, or allocate a wrench",
    "export": "write a model for another program",
    "sim": "simulate boats live: lines of commands in; lines of poses, IMU, LiDAR and truth out",
    "mimic": "make a holonomic robot move as the boat does: commands and robot poses in, robot velocity out",
    "completion": "print the script by which a shell completes commands, options and files",
}
EXAMPLES_TITLE = "examples:"


class Formatter(argparse.HelpFormatter):
    """Lines of examples stay as they are."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if text.startswith(EXAMPLES_TITLE) else super()._fill_text(text, width, indent)


class Parser(argparse.ArgumentParser):
    """Its errors are one line, as all others of the program, and exit with 2; they name what is spelt alike."""

    def __init__(self, *args: Any, **options: Any) -> None:  # noqa: ANN401, as the class that it extends
        options.setdefault("formatter_class", Formatter)
        super().__init__(*args, **options)
        self.color = False  # Python 3.14's own; colours are those of all other text

    def error(self, message: str) -> NoReturn:
        """What is wrong with the arguments, and where to read what they may be."""
        joint = " See" if message.endswith("?") else "; see"
        complain(f"{message}{joint} {self.prog} --help", self.prog)
        self.exit(2)

    def parse_known_args(
        self,
        args: Iterable[str] | None = None,
        namespace: Any = None,  # noqa: ANN401, as the method that it overrides
    ) -> tuple[Any, list[str]]:
        """As any parser's. An unknown option is named first: what else is missing may follow from it."""
        given = list(sys.argv[1:] if args is None else args)
        for word in given:
            if word == "--" or not (word.startswith("-") or self.takes_all_options):
                break
            if word.startswith("--") and " " not in word:
                self._check_option(word.partition("=")[0])
        return super().parse_known_args(given, namespace)

    takes_all_options = False  # those after the first word are of a command

    def _check_option(self, option: str) -> None:
        known = [name for name in self._option_string_actions if name.startswith("--")]
        if not any(name.startswith(option) for name in known):
            self.error(f"unknown option {option}{alike(option, known)}")

    def _check_value(self, action: argparse.Action, value: Any) -> None:  # noqa: ANN401
        if action.choices is None or value in action.choices:
            return
        choices = [str(choice) for choice in action.choices]
        kind = "command" if action.metavar == "COMMAND" else f"value for {_name(action)}"
        close = alike(str(value), choices) or f"; known: {', '.join(choices)}"
        self.error(f"unknown {kind} '{value}'{close}")

    def format_help(self) -> str:
        """As any parser's, with examples at the end."""
        self.epilog = examples_of(self.prog.partition(" ")[2])
        return super().format_help()

    def _print_message(self, message: str, file: Any = None) -> None:  # noqa: ANN401
        if message:
            say(message, end="", file=file)


def alike(word: str, known: Sequence[str]) -> str:
    """What may have been meant, as the end of a sentence."""
    close = get_close_matches(word, known, 1)
    return f"; did you mean {close[0]}?" if close else ""


def _name(action: argparse.Action) -> str:
    return "/".join(action.option_strings) or str(action.metavar or action.dest)


class CommandParser(Parser):
    """Parser of one command, empty until its command is called."""

    file: str | None = None  # of the command; None: its arguments are there
    takes_all_options = True

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


def examples_of(command: str) -> str:
    """The end of its --help; "": of the program's."""
    from seatrial.commands.shared.examples import EXAMPLES

    return "\n  ".join([EXAMPLES_TITLE, *EXAMPLES[command].splitlines()])


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
