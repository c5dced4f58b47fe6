# SPDX-License-Identifier: MIT
"""`seatrial init`."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import (
    add_json,
    add_places,
    add_salvage,
    choices_of,
    guard,
    recordings_again,
    to_programs,
    write_json,
)
from seatrial.util.frames import Axes
from seatrial.util.printing import say
from seatrial.util.progress import stage
from seatrial.util.questions import at_terminal

if TYPE_CHECKING:
    from seatrial.commands.shared.results import InitResult
    from seatrial.inspection.proposal.propose import Proposal

AXES_NAMES = tuple(axes.value for axes in Axes)


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("recordings", nargs="+", type=Path, metavar="RECORDING")
    command.add_argument("-o", "--out", type=Path, required=True, metavar="VEHICLE")
    command.add_argument("--name", help="the boat's name (default: the recording's)")
    command.add_argument(
        "--axes",
        choices=AXES_NAMES,
        help=f"axes of the recording (default: {AXES_NAMES[0]}; of an autopilot's log {AXES_NAMES[1]})",
    )
    command.add_argument(
        "--pose",
        metavar="TOPIC",
        help="topic or table of the poses; or columns, in bags and logs TOPIC/FIELD: x=COL,y=COL,heading=COL",
    )
    command.add_argument(
        "--commands",
        metavar="TOPIC",
        help="topic or table of the commands; or columns, in bags and logs TOPIC/FIELD: COL,COL or NAME=COL",
    )
    command.add_argument(
        "--parent", metavar="FRAME", help="the world's frame, where poses come from tf"
    )
    command.add_argument(
        "--child", metavar="FRAME", help="the boat's frame, where poses come from tf"
    )
    add_places(command)
    add_salvage(command)
    add_json(command)
    command.add_argument("--force", action="store_true", help="overwrite an existing file")


def run(args: argparse.Namespace) -> None:
    """A vehicle file proposed from a recording; asks where it may."""
    from seatrial.inspection.proposal.axes import asked_axes
    from seatrial.inspection.proposal.propose import init
    from seatrial.inspection.proposal.sources import recognised_text
    from seatrial.util.errors import FileError
    from seatrial.util.files import write_text
    from seatrial.workflow.next_step import NextStep, command

    guard(args.out, "", *args.recordings)
    guard(args.json, "{", *args.recordings, args.out)
    if args.out.exists() and not args.force:
        raise FileError(
            f"{args.out}: exists already; give another name, or --force to write over it"
        )
    asked = at_terminal(quiet=args.quiet or to_programs(args))
    ask = None if asked is None else asked.choose
    choices = replace(choices_of(args, args.name), parent=args.parent, child=args.child)
    axes = args.axes or asked_axes(args.recordings[0], choices, ask)
    answered = ask is not None and args.axes is None
    choices = replace(choices, axes=axes, axes_answered=answered)
    with stage("looking at the recordings"):
        proposal = init(*args.recordings, choices=choices, ask=ask, salvage=args.salvage)
    write_text(args.out, proposal.text)
    if proposal.sources.recognised:
        say(f"{recognised_text(proposal.sources.recognised)}\n")
    say(proposal.text, end="")
    follow = command("inspect", *recordings_again(args), "--vehicle", args.out)
    for found in proposal.sources.notes.get("clock", []):
        say(found)
    say(f"wrote {args.out}")
    say(NextStep(follow).text)
    write_json(args, "init 1", _result(args, proposal, follow))


def _result(args: argparse.Namespace, proposal: "Proposal", follow: str) -> "InitResult":
    """For `--json`."""
    from seatrial.commands.shared.results import InitResult, RecognisedSignal

    found = [
        RecognisedSignal(r.signal, r.column, r.why, r.sure.value, list(r.others))
        for r in proposal.sources.recognised
    ]
    paths = [str(path) for path in args.recordings]
    return InitResult(str(args.out), paths, found, follow)
