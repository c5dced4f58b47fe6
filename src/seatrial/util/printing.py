# SPDX-License-Identifier: MIT
"""Text for a terminal: what files say of themselves can't move the cursor, set its title or hide a line."""

import sys
from contextlib import suppress
from typing import TextIO

from seatrial.util.errors import printable
from seatrial.util.progress import hidden


def one_line(text: str) -> str:
    """Printable text on one line."""
    return printable(" ".join(text.split()), "")


def say(text: str, *, end: str = "\n", file: TextIO | None = None) -> None:
    """Print, with the line of progress out of the way. All that commands print is printed here."""
    with hidden():
        print(printable(text), end=end, file=file)


def complain(words: str) -> None:
    """One line on standard error; where that is closed or full, nothing."""
    with suppress(OSError, ValueError), hidden():
        print(f"seatrial: {one_line(words)}", file=sys.stderr, flush=True)
