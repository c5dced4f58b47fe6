# SPDX-License-Identifier: MIT
"""A source of lines for a line loop: what it reads is there at once, what it writes is kept."""

from collections.abc import Callable
from typing import Any


class Given:
    """Lines that are all there, and the answers to them, as `parsed` makes them."""

    def __init__(self, given: list[str], parsed: Callable[[str], Any] = str) -> None:
        self.given, self.parsed = given, parsed
        self.answers: list[Any] = []
        self.ended = False

    def read(self, wait):
        self.ended = True
        return self.given

    def follow(self, line):
        pass

    def write(self, line):
        self.answers.append(self.parsed(line))
