# SPDX-License-Identifier: MIT
"""Sources of a recording's poses and commands, and the user's choices."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from seatrial.util.errors import RecordingError
from seatrial.util.frames import Axes

Ask = Callable[[str, Sequence[str]], str]  # a question and its options to the option chosen
OPTIONS = {"poses": "--pose", "commands": "--commands"}


@dataclass(frozen=True)
class Choices:
    """Options given by the user."""

    name: str | None = None
    axes: str = Axes.FLU.value
    pose: str | None = None  # topic, or table of a folder
    commands: str | None = None
    parent: str | None = None
    child: str | None = None


@dataclass(frozen=True)
class Sources:
    """Where poses and channels come from, in the vehicle file's terms."""

    path: Path
    name: str
    axes: str
    length: float  # [s]
    pose: dict[str, Any]
    commands: dict[str, Any]  # without inputs
    channels: dict[str, dict[str, Any]]  # by plain name: the column
    notes: Mapping[str, list[str]] = field(default_factory=dict)  # comments, by key
    full: float | None = None  # value of full command, where the message type defines it
    more: tuple[Path, ...] = ()  # further recordings of the same boat


def choose(path: Path, role: str, likely: Sequence[str], ask: Ask | None) -> str:
    """The candidate for a role: the only one, or the answer of `ask`. Raises RecordingError without it."""
    if len(likely) == 1:
        return likely[0]
    if ask is not None:
        return ask(f"Which are the {role} of the boat?", likely)
    raise RecordingError(
        f"{path}: several candidates for the {role}: {', '.join(likely)}; name one with {OPTIONS[role]} "
        "(of two boats in one recording, choose poses and commands of the same boat)"
    )


def named(columns: Iterable[tuple[str, dict[str, Any]]]) -> dict[str, dict[str, Any]]:
    """Columns by unique plain names, made of their field paths, headers or topics."""
    found: dict[str, dict[str, Any]] = {}
    for text, column in columns:
        word = "".join(c if c.isascii() and c.isalnum() else "_" for c in text).strip("_")
        word = word if word[:1].isalpha() else f"c_{word}".rstrip("_")
        number, name = 1, word
        while name in found:
            number += 1
            name = f"{word}_{number}"
        found[name] = column
    return found
