# SPDX-License-Identifier: MIT
"""Text for a terminal: what files say of themselves can't move the cursor, set its title or hide a line."""

import os
import sys
from contextlib import AbstractContextManager, suppress
from contextvars import ContextVar
from typing import TextIO

from seatrial.util.errors import printable
from seatrial.util.progress import held, hidden

USUAL_COLUMNS, FEWEST_COLUMNS = 80, 20  # of a terminal that does not say; of a narrow one
STANDARD_OUTPUT = "-"  # in place of a file's name
table_columns: ContextVar[int | None] = ContextVar("table_columns", default=None)  # None: any
_data_only: ContextVar[bool] = ContextVar("data_only", default=False)


def one_line(text: str) -> str:
    """Printable text on one line."""
    return printable(" ".join(text.split()), "")


def say(text: str, *, end: str = "\n", file: TextIO | None = None) -> None:
    """Print, with the line of progress out of the way. All text that commands print is printed here.

    A pipe has it at once, too: `live` prints the address of its page, and waits.
    """
    if file is None and _data_only.get():
        return
    shown = drawn(printable(text), sys.stdout if file is None else file)
    with hidden():
        print(shown, end=end, file=file, flush=True)


def put(data: str) -> None:
    """Print data for programs: ASCII, which holds no control character but the line's end."""
    if not data.isascii():
        raise ValueError("data on standard output is ASCII")
    with hidden():
        print(printable(data), end="")


def tables_fit(columns: int | None) -> AbstractContextManager[None]:
    """Tables that are made inside leave out what matters least where they are wider; None: any width."""
    return held(table_columns, columns)


def data_only() -> AbstractContextManager[None]:
    """Standard output is for `put` alone; `say` is silent there."""
    return held(_data_only, True)


def complain(words: str, program: str = "seatrial") -> None:
    """One line on standard error; where that is closed or full, nothing."""
    with suppress(OSError, ValueError), hidden():
        print(drawn(f"{program}: {one_line(words)}", sys.stderr), file=sys.stderr, flush=True)


def drawn(text: str, stream: TextIO | None) -> str:
    """Printable text as the stream shows it: on a terminal in colours, and no wider than that."""
    colour, columns = coloured(stream), columns_of(stream)
    if stream is None or not (colour or columns):
        return text
    from seatrial.util.console import terminal

    return terminal.drawn(text, stream, colour=colour, columns=columns)


def coloured(stream: TextIO | None) -> bool:
    """Whether the stream shows colours: a terminal does, unless NO_COLOR is set; FORCE_COLOR: anything does."""
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return _is_terminal(stream) and os.environ.get("TERM") not in (None, "", "dumb")


def columns_of(stream: TextIO | None) -> int | None:
    """Columns of a terminal; None where the stream is none."""
    if stream is None or not _is_terminal(stream):
        return None
    columns = 0
    with suppress(OSError, ValueError):  # a terminal without a size; a stream without a number
        given = os.environ.get("COLUMNS", "")
        columns = int(given) if given.isdecimal() else os.get_terminal_size(stream.fileno()).columns
    return max(columns, FEWEST_COLUMNS) if columns else USUAL_COLUMNS


def _is_terminal(stream: TextIO | None) -> bool:
    try:
        return stream is not None and stream.isatty()
    except ValueError:  # closed
        return False
