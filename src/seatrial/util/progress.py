# SPDX-License-Identifier: MIT
"""One line of progress on a terminal; nothing elsewhere."""

import sys
from collections.abc import Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")


class Progress:
    """Shows progress on standard error, if that is a terminal and not silenced."""

    def __init__(self, *, quiet: bool) -> None:
        self.shown = sys.stderr.isatty() and not quiet
        self.width = 0

    def say(self, text: str) -> None:
        """Replace the line."""
        if self.shown:
            sys.stderr.write("\r" + text.ljust(self.width)[:120])
            sys.stderr.flush()
            self.width = min(len(text), 120)

    def clear(self) -> None:
        """Remove the line."""
        if self.shown and self.width:
            sys.stderr.write("\r" + " " * self.width + "\r")
            sys.stderr.flush()
            self.width = 0

    def over(self, items: Iterable[T], label: str, total: int) -> Iterator[T]:
        """Yield the items and show their count."""
        for i, item in enumerate(items):
            self.say(f"{label} {i + 1}/{total}")
            yield item
        self.clear()
