# SPDX-License-Identifier: MIT
"""Tables of a page, replaced between marks in it: `<!-- name -->` and `<!-- end -->`."""

import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from seatrial.errors import FileError

MARK = re.compile(r"(<!-- (?P<name>[a-z-]+) -->\n).*?(<!-- end -->)", re.DOTALL)


def fill(path: Path, makers: Mapping[str, Callable[[], str]]) -> None:
    """Replace every block of the page by what the maker of its name makes; the words around stay.

    Raises FileError where a block has no maker.
    """
    text = path.read_text()
    names = {m["name"] for m in MARK.finditer(text)}
    unknown = names - set(makers)
    if unknown:
        raise FileError(
            f"{path}: no block {', '.join(sorted(unknown))}; there are {', '.join(makers)}"
        )
    made = {name: makers[name]() for name in names}
    path.write_text(MARK.sub(lambda m: f"{m[1]}\n{made[m['name']].strip()}\n\n{m[3]}", text))


def refill(path: Path, made: Mapping[str, str]) -> None:
    """Replace the page's blocks of these names; the others stay, and so do the words around."""
    old = {m["name"]: "\n".join(m[0].splitlines()[1:-1]) for m in MARK.finditer(path.read_text())}
    fill(path, {name: partial(str, text) for name, text in {**old, **made}.items()})
