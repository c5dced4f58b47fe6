# SPDX-License-Identifier: MIT
"""Questions to the user at a terminal."""

import sys
from collections.abc import Sequence
from typing import Protocol

from seatrial.util.printing import say
from seatrial.util.progress import hidden


class Questions(Protocol):
    """Who answers what no log can tell."""

    def choose(self, question: str, options: Sequence[str]) -> str:
        """One of the options; the first is the usual one."""

    def text(self, question: str) -> str:
        """A line of text; empty: not known."""


class Terminal:
    """The user at the terminal. At the end of input the usual answer."""

    def choose(self, question: str, options: Sequence[str]) -> str:
        """Let the user choose by number; enter is the first."""
        with hidden():
            say(question)
            for i, option in enumerate(options, 1):
                say(f"  {i}  {option}")
            while True:
                answer = self._line(f"1 to {len(options)} [1]: ") or "1"
                if answer.isdecimal() and 1 <= int(answer) <= len(options):
                    return options[int(answer) - 1]

    def text(self, question: str) -> str:
        """A line of text."""
        with hidden():
            say(question)
            return self._line("> ")

    def _line(self, prompt: str) -> str:
        try:
            return input(prompt).strip()
        except EOFError:
            return ""


def at_terminal(*, quiet: bool = False) -> Terminal | None:
    """The user, where there is one to ask."""
    if quiet or sys.stdin is None or sys.stdout is None:
        return None
    return Terminal() if sys.stdin.isatty() and sys.stdout.isatty() else None
