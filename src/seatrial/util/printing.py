# SPDX-License-Identifier: MIT
"""Text for a terminal: what files say of themselves can't move the cursor, set its title or hide a line."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from typing import TextIO

from seatrial.util.errors import printable
from seatrial.util.progress import hidden

STANDARD_OUTPUT = "-"  # in place of a file's name
_data_only: ContextVar[bool] = ContextVar("data_only", default=False)


def one_line(text: str) -> str:
    """Printable text on one line."""
    return printable(" ".join(text.split()), "")


def say(text: str, *, end: str = "\n", file: TextIO | None = None) -> None:
    """Print, with the line of progress out of the way. All text that commands print is printed here."""
    if file is None and _data_only.get():
        return
    with hidden():
        print(printable(text), end=end, file=file)


def put(data: str) -> None:
    """Print data for programs: ASCII, which holds no control character but the line's end."""
    if not data.isascii():
        raise ValueError("data on standard output is ASCII")
    with hidden():
        print(printable(data), end="")


@contextmanager
def data_only() -> Iterator[None]:
    """Standard output is for `put` alone; `say` is silent there."""
    token = _data_only.set(True)
    try:
        yield
    finally:
        _data_only.reset(token)


def complain(words: str) -> None:
    """One line on standard error; where that is closed or full, nothing."""
    with suppress(OSError, ValueError), hidden():
        print(f"seatrial: {one_line(words)}", file=sys.stderr, flush=True)
