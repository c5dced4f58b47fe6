# SPDX-License-Identifier: MIT
"""Inputs of a guided path, and steps that are done: one that was stopped goes on where it was."""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

from seatrial.recording.recording import Recording, Source
from seatrial.util.errors import FileError
from seatrial.util.files import dump_json, expect_format, read_json, sha256, write_text
from seatrial.util.questions import Questions

STEPS_FORMAT = "steps 1"


class Steps:
    """What each step was made from and what it wrote, in a file of the folder."""

    def __init__(self, folder: Path) -> None:
        """Read the file, where there is one. Raises FileError."""
        self.folder, self.path = folder, folder / "steps.json"
        self._known: dict[str, Any] = {}
        if self.path.is_file():
            steps = expect_format(read_json(self.path), STEPS_FORMAT, self.path).get("steps")
            if not isinstance(steps, dict):
                raise FileError(f"{self.path}: steps is not a mapping; remove the file")
            self._known = steps

    def done(self, name: str, made_from: str, files: Sequence[Path]) -> bool:
        """Whether the step was done from the same, and its files are as it wrote them."""
        known = self._known.get(name)
        if not isinstance(known, dict) or known.get("from") != made_from:
            return False
        return known.get("files") == {f.name: sha256(f) for f in files if f.is_file()}

    def note(self, name: str, made_from: str, files: Sequence[Path]) -> None:
        """The step is done."""
        self._known[name] = {"from": made_from, "files": {f.name: sha256(f) for f in files}}
        self._write()

    def answer(self, name: str) -> str | None:
        """An answer of the user's that no other file has."""
        answers = self._known.get("answers")
        value = answers.get(name) if isinstance(answers, dict) else None
        return value if isinstance(value, str) else None

    def keep_answer(self, name: str, value: str) -> None:
        """Keep it."""
        answers = self._known.get("answers")
        self._known["answers"] = {**(answers if isinstance(answers, dict) else {}), name: value}
        self._write()

    def _write(self) -> None:
        write_text(self.path, dump_json({"seatrial": STEPS_FORMAT, "steps": self._known}))


def digest_of(*parts: object) -> str:
    """Of values that JSON has, and of the text of others."""
    return hashlib.sha256(json.dumps(parts, default=str).encode()).hexdigest()


def work_digest(*parts: object) -> str:
    """Digest of everything that a step is made from, and of the program that does it."""
    return digest_of(version("seatrial"), *parts)


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
    # by the files of a recording
    log_of: dict[tuple[Source, ...], Path] = field(default_factory=dict)
    # NAME=FROM-TO of what is left out, by log
    left_out: dict[Path, list[str]] = field(default_factory=dict)

    def file(self, name: str) -> Path:
        """In the folder."""
        return self.folder / name

    def again(self, *logs: Path) -> list[str]:
        """Logs, and how they are read, as words of a command line."""
        spans = [span for log in dict.fromkeys(logs) for span in self.left_out.get(log, ())]
        without = [word for span in spans for word in ("--without", span)]
        return [*map(str, logs), *without, *(["--salvage"] if self.salvage else [])]

    def made_from(self, recordings: Sequence[Recording], training: Sequence[Recording]) -> str:
        """Digest of what the model is made from: logs, vehicle file, what of them identifies, effects."""
        return work_digest(
            [source.sha256 for r in recordings for source in r.sources],
            self.file("vehicle.yaml").read_text("utf-8"),
            [(r.name, r.offset, r.duration) for r in training],
            *self.effects,
        )
