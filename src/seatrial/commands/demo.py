# SPDX-License-Identifier: MIT
"""`seatrial demo`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import add_json, guard, write_json
from seatrial.util.printing import say


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument(
        "--out", type=Path, default=Path("demo"), help="folder to write to (default: demo)"
    )
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """Everything on the bundled recordings."""
    from seatrial.commands.shared.results import DemoResult
    from seatrial.demo import demo

    guard(args.json, "{")
    demo(args.out, say)
    files = sorted(str(path) for path in args.out.rglob("*") if path.is_file())
    write_json(args, "demo 1", DemoResult(str(args.out), files))
