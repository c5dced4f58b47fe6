# SPDX-License-Identifier: MIT
"""The program: `seatrial`, or `python -m seatrial`. Ctrl-C ends it without a traceback while it imports, too."""

import sys


def main() -> int:
    """As `seatrial.commands.cli.main`, from before its modules are imported."""
    try:
        from seatrial.commands.cli import main as run

        return run()
    except KeyboardInterrupt:
        return 130  # as a shell has it: 128 + SIGINT


if __name__ == "__main__":
    sys.exit(main())
