# SPDX-License-Identifier: MIT
"""Inputs of a guided path, and what it finds on the way."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from seatrial.guide.steps import Steps
from seatrial.util.questions import Questions

Say = Callable[[str], None]


@dataclass
class Task:
    """Inputs, and what is found on the way."""

    logs: tuple[Path, ...]
    folder: Path
    ask: Questions | None
    say: Say
    salvage: bool
    steps: Steps
    effects: tuple[str, ...] = ()  # estimated from the beginning
    assumed: list[str] = field(default_factory=list)

    def file(self, name: str) -> Path:
        """In the folder."""
        return self.folder / name
