# SPDX-License-Identifier: MIT
"""Arguments of public functions that are of another type than stated: one line with how to get the right one."""

from collections.abc import Collection
from pathlib import Path

from seatrial.util.errors import SeatrialError

FROM = {
    "Model": "seatrial.load(path) or identify(...)",
    "PlanFile": "seatrial.load_plan(path)",
    "Recording": "seatrial.read(path, vehicle)",
    "Vehicle": "seatrial.load_vehicle(path)",
}
LONGEST_SHOWN = 60  # [characters] of what was given


class ArgumentError(SeatrialError, TypeError):
    """An argument of the wrong type."""


def expect(value: object, kind: type | tuple[type, ...], what: str) -> None:
    """Raises ArgumentError where an argument is not of a type, or of one of several."""
    if not isinstance(value, kind):
        names = [one.__name__ for one in (kind if isinstance(kind, tuple) else (kind,))]
        source = f", from {FROM[names[0]]}" if names[0] in FROM else ""
        raise ArgumentError(f"{what} {_shown(value)}: expected a {' or '.join(names)}{source}")


def expect_each(values: object, kind: type | tuple[type, ...], what: str) -> None:
    """Raises ArgumentError where an argument is not a list of a type: one item alone, text, an iterator."""
    if isinstance(values, (str, bytes, Path)) or not isinstance(values, Collection):
        raise ArgumentError(f"{what} {_shown(values)}: expected a list, [...]")
    for value in values:
        expect(value, kind, what)


def _shown(value: object) -> str:
    """What was given: text and numbers as they are, else the type."""
    plain = isinstance(value, (str, Path, int, float)) or value is None
    return repr(value)[:LONGEST_SHOWN] if plain else f"of type {type(value).__name__}"
