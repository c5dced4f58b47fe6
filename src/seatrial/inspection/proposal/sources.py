# SPDX-License-Identifier: MIT
"""Sources of a recording's poses and commands, and the user's choices."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from textwrap import dedent
from typing import Any

from seatrial.util.errors import RecordingError, VehicleError, printable
from seatrial.util.format import joined, table
from seatrial.util.frames import Axes

Ask = Callable[[str, Sequence[str]], str]  # a question and its options to the option chosen
Place = tuple[float, float, float]  # of a thruster: x, y [m], direction [deg]
Entries = dict[str, dict[str, Any]]  # of the vehicle file by name: columns of inputs, forces
MOST_OTHERS = 6  # candidates listed
MOORE_PENROSE = "moore-penrose"
LONGEST_PLACE = 50.0  # [m] from the origin, on a small boat; a longer one is in other units
LISTED_TOPICS = 20  # in a message
OPTIONS = {"poses": "--pose", "commands": "--commands"}


class Sureness(str, Enum):
    """How sure a recognised signal is."""

    CHOSEN = "chosen"  # by the user
    CERTAIN = "certain"  # name and values agree
    LIKELY = "likely"  # the name, or the values alone
    GUESS = "guess"


@dataclass(frozen=True)
class Recognised:
    """A signal of the boat that was found in a recording."""

    signal: str  # x, heading, stamps of the commands
    column: str  # or topic and field
    why: str
    sure: Sureness
    others: tuple[str, ...] = ()  # further candidates


@dataclass(frozen=True)
class Choices:
    """Options given by the user."""

    name: str | None = None
    axes: str = Axes.FLU.value
    pose: str | None = None  # topic, table of a folder, or columns: x=COL,y=COL,heading=COL
    commands: str | None = None
    parent: str | None = None
    child: str | None = None
    lever: tuple[float, float] | None = None  # [m] of the measured point, in the file's axes
    stern: bool = False  # whether the heading is that of the stern
    thrusters: tuple[Place, ...] = ()  # of each
    scheme: str = MOORE_PENROSE  # of the allocation to them
    axes_answered: bool = False  # whether the user answered the question on axes


@dataclass(frozen=True)
class Sources:
    """Where poses and channels come from, in the vehicle file's terms."""

    path: Path
    name: str
    axes: str
    length: float  # [s]
    pose: dict[str, Any]
    commands: dict[str, Any]  # without inputs
    channels: Entries  # by plain name: the column
    notes: Mapping[str, list[str]] = field(default_factory=dict)  # comments, by key
    full: float | None = None  # value of full command, where the message type defines it
    more: tuple[Path, ...] = ()  # further recordings of the same boat
    salvage: bool = False  # whether damaged bags are read as far as they are readable
    spare: tuple[str, ...] = ()  # further columns that change: a signal that scales thrust?
    recognised: tuple[Recognised, ...] = ()  # signals, for the user to check
    # [deg] of a steered thruster at full command, where it is stated
    full_angle: float | None = None


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


def named(columns: Iterable[tuple[str, dict[str, Any]]]) -> Entries:
    """Columns by unique plain names, made of their field paths, headers or topics."""
    found: Entries = {}
    for text, column in columns:
        word = "".join(c if c.isascii() and c.isalnum() else "_" for c in text).strip("_")
        word = word if word[:1].isalpha() else f"c_{word}".rstrip("_")
        number, name = 1, word
        while name in found:
            number += 1
            name = f"{word}_{number}"
        found[name] = column
    return found


def place_of(column: Mapping[str, Any]) -> list[str]:
    """Topic or file, and column or field of a channel."""
    return [str(column[k]) for k in ("topic", "file", "column", "field") if k in column]


def assigned(text: str, option: str, keys: Sequence[str] = ()) -> dict[str, str]:
    """The columns of `x=COL,y=COL`; empty where the text has no `=`. keys: those allowed.

    Raises RecordingError.
    """
    if "=" not in text:
        return {}
    found: dict[str, str] = {}
    for part in text.split(","):
        key, equals, column = (p.strip() for p in part.partition("="))
        if not (key and equals and column) or (keys and key not in keys):
            listed = f" with {', '.join(keys)}" if keys else ""
            raise RecordingError(f"{option} {text}: expected NAME=COLUMN,NAME=COLUMN{listed}")
        if key in found:
            raise RecordingError(f"{option} {text}: {key} is there twice")
        found[key] = column
    return found


def recognised_text(found: Sequence[Recognised]) -> str:
    """A table: signal, column, why, how sure, other candidates."""
    head = ("signal", "column", "how sure", "why", "other candidates")
    rows = [
        (r.signal, r.column, r.sure.value, r.why, ", ".join(r.others[:MOST_OTHERS]) or "-")
        for r in found
    ]
    shown = [[printable(cell, keep="") for cell in row] for row in rows]
    return dedent(table(head, shown, text=range(len(head))))


def thrusters_of(text: str) -> tuple[Place, ...]:
    """Position [m] and direction [deg] of each thruster, divided by semicolons. Raises VehicleError."""
    return tuple(_thruster(part) for part in text.split(";") if part.strip())


def one_each(places: tuple[Place, ...], names: Sequence[str]) -> tuple[Place, ...]:
    """Places of all thrusters. Raises VehicleError where their number is another."""
    if len(places) != len(names):
        raise VehicleError(
            f"{len(places)} of {len(names)} thrusters given; one each for {joined(names)}, separated by ';'"
        )
    return places


def listed_topics(names: Sequence[str]) -> str:
    """Names of topics for a message."""
    more = f" and {len(names) - LISTED_TOPICS} more" if len(names) > LISTED_TOPICS else ""
    return ", ".join(names[:LISTED_TOPICS]) + more


def lever_of(text: str) -> tuple[float, float]:
    """Two lengths [m]. Raises VehicleError."""
    numbers = _numbers(text)
    if len(numbers) != 2 or max(map(abs, numbers)) > LONGEST_PLACE:
        raise VehicleError(f"lever arm '{text}': expected two lengths in metres, such as 0.35 -0.1")
    return numbers[0], numbers[1]


def _thruster(text: str) -> Place:
    numbers = _numbers(text)
    if len(numbers) != 3 or max(map(abs, numbers[:2])) > LONGEST_PLACE:
        raise VehicleError(
            f"thruster '{text.strip()}': expected x [m], y [m] and direction [deg], such as 0.2 0.2 135"
        )
    return numbers[0], numbers[1], numbers[2]


def _numbers(text: str) -> list[float]:
    """Numbers that spaces or commas divide; none where a word is no number."""
    words = [word for word in re.split(r"[\s,]+", text.strip()) if word]
    if not all(re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)", word) for word in words):
        return []
    return [float(word) for word in words]
