# SPDX-License-Identifier: MIT
"""`seatrial demo`."""

import argparse
from pathlib import Path

from seatrial.util.printing import say


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument(
        "--out", type=Path, default=Path("demo"), help="folder to write to (default: demo)"
    )


def run(args: argparse.Namespace) -> None:
    """Everything on the bundled recordings."""
    from seatrial.demo import demo

    demo(args.out, say)
