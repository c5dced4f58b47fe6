# SPDX-License-Identifier: MIT
"""`seatrial completion`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import add_json, guard, write_json
from seatrial.util.printing import say

SHELLS = ("bash", "zsh", "tcsh")
FOLDERS = {"DIR", "FOLDER"}
VEHICLES = {"V", "VEHICLE"}  # files or names of bundled vehicles: not paths for the parser


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("shell", choices=SHELLS, help="the shell that is to complete")
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """The script that the shell sources."""
    from seatrial.commands.shared.results import CompletionResult

    guard(args.json, "{")
    text = script(args.shell)
    write_json(args, "completion 1", CompletionResult(args.shell, text))
    say(text)


def script(shell: str) -> str:
    """Commands, options, choices and files of the whole program."""
    import shtab

    from seatrial.commands import CommandParser, make_parser

    parser = make_parser()
    (commands,) = (a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    for command in commands.choices.values():
        if isinstance(command, CommandParser):
            command.fill()
        for action in command._actions:
            if action.type is Path or action.metavar in VEHICLES:
                folder = action.metavar in FOLDERS
                action.complete = shtab.DIRECTORY if folder else shtab.FILE
    return str(shtab.complete(parser, shell))
