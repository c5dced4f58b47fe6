# SPDX-License-Identifier: MIT
"""Templates: files with ${names} to fill in; pieces of one file under `---- name` lines."""

import re
from collections.abc import Mapping, Sequence
from importlib import resources
from string import Template


def template(name: str) -> str:
    """A file of `templates/`."""
    return (resources.files("seatrial") / "export" / "templates" / name).read_text(encoding="utf-8")


def fill(text: str, words: Mapping[str, str]) -> str:
    """The text with every ${name} filled in, one blank line at most, and no blanks at line ends."""
    filled = Template(text).substitute(words)
    return re.sub(r"\n{3,}", "\n\n", re.sub(r"[ \t]+\n", "\n", filled))


def pieces(name: str, mark: str) -> dict[str, str]:
    """The pieces of a file by name; each starts after a line `mark---- name`."""
    _, *found = re.split(rf"^{re.escape(mark)}---- (\w+).*\n", template(name), flags=re.MULTILINE)
    return dict(zip(found[::2], found[1::2], strict=True))


def block(lines: Sequence[str], indent: str) -> str:
    """Lines at one indent."""
    return "\n".join(indent + line if line else "" for line in lines)
