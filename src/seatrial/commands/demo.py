# SPDX-License-Identifier: MIT
"""`seatrial demo`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import (
    add_command,
    say,
)

if TYPE_CHECKING:
    from seatrial.commands.shared import Verbs


def add(verbs: "Verbs") -> None:
    """Its arguments."""
    demo = add_command(verbs, "demo", run, "run everything below on the bundled recordings")
    demo.add_argument(
        "--out", type=Path, default=Path("demo"), help="folder to write to (default: demo)"
    )


def run(args: argparse.Namespace) -> None:
    """Everything on the bundled recordings."""
    from seatrial.demo import demo

    demo(args.out, say)
