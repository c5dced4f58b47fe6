# SPDX-License-Identifier: MIT
"""Tables of a page, made anew between marks in it: `<!-- name -->` and `<!-- end -->`."""

import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from seatrial.errors import FileError

MARK = re.compile(r"(<!-- (?P<name>[a-z-]+) -->\n).*?(<!-- end -->)", re.DOTALL)


def fill(path: Path, makers: Mapping[str, Callable[[], str]]) -> None:
    """Every block of the page by the maker of its name; the words around them stay.

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
    """Some of the page's blocks anew, the others as they stand. Raises FileError as `fill`."""
    old = {m["name"]: "\n".join(m[0].splitlines()[1:-1]) for m in MARK.finditer(path.read_text())}
    fill(path, {name: partial(str, text) for name, text in {**old, **made}.items()})
