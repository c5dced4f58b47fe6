# SPDX-License-Identifier: MIT
"""`seatrial auto`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import (
    add_json,
    add_places,
    add_salvage,
    choices_of,
    guard,
    open_page,
    to_programs,
    write_json,
)
from seatrial.util.printing import complain, say


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("logs", nargs="+", type=Path, metavar="LOG")
    command.add_argument(
        "-o", "--out", type=Path, metavar="DIR", help="folder to write to (default: LOG-model)"
    )
    command.add_argument(
        "--test", type=Path, metavar="LOG",
        help="the log that tests the model, one of LOG or a further one (default: the last quarter of each log)",
    )  # fmt: skip
    command.add_argument("--name", help="the boat's name (default: that of DIR, else the log's)")
    command.add_argument(
        "--pose", metavar="TOPIC", help="topic, table or columns of the poses, as for init"
    )
    command.add_argument(
        "--commands", metavar="TOPIC", help="topic, table or columns of the commands, as for init"
    )
    add_places(command)
    command.add_argument(
        "--yes", action="store_true", help="ask nothing: decide, and state what is assumed"
    )
    command.add_argument("-v", "--verbose", action="store_true", help="all findings on the model")
    command.add_argument("--no-browser", action="store_true", help="do not open the report")
    add_salvage(command)
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """All steps; what was assumed; the report in the browser, where there is one."""
    from seatrial.commands.shared.results import AutoResult, identified
    from seatrial.guide import auto
    from seatrial.identification.console import summary
    from seatrial.util.questions import at_terminal

    guard(args.json, "{", *args.logs, args.test)
    folder = args.out or Path(f"{args.logs[0].name.partition('.')[0]}-model")
    name = args.name or (None if args.out is None else args.out.resolve().name)
    choices = choices_of(args, name)
    try:
        found = auto(
            args.logs, folder, test=args.test, choices=choices, salvage=args.salvage, say=say,
            ask=at_terminal(quiet=args.quiet or args.yes or to_programs(args)),
        )  # fmt: skip
    except KeyboardInterrupt:
        complain("stopped; the same command goes on where it was")
        raise
    say(f"\n{summary(found.model, brief=not args.verbose)}")
    for assumed in found.assumed:
        say(f"assumed: {assumed}")
    say(found.next.text)
    model = identified(found.model, folder / "model.yaml", found.next.text)
    scores = folder / "scores.json"
    result = AutoResult(
        str(folder), str(found.report), str(scores), model, list(found.assumed), found.next.text
    )
    write_json(args, "auto 1", result)
    open_page(args, found.report.resolve().as_uri())
