# SPDX-License-Identifier: MIT
"""What --json writes for each command, from the classes of the content and what they state of their fields.

The site has every field (tools/generated.py); docs/json.md in the repository names the kinds of content.

python tools/json_page.py            # writes docs/json.md, after a new kind or version
python tools/json_page.py validate   # prints the fields of one command
"""

import dataclasses
import enum
import inspect
import re
import sys
import textwrap
import typing
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from seatrial.commands import COMMANDS
from seatrial.commands.shared.schemas import SCHEMAS

PLAIN = {
    str: "text", float: "number", int: "whole number", bool: "true or false", type(None): "null", Any: "any",
}  # fmt: skip
MEANING = re.compile(r"^(\w+): (.*(?:\n {4}.*)*)", re.MULTILINE)  # of a field in a docstring
PAGE = Path(__file__).resolve().parents[1] / "docs" / "json.md"
HEAD = """\
# Results as JSON

Every command takes `--json FILE` and also writes its result as JSON. With `--json -` the JSON is on
standard output, and nothing else is: `seatrial inspect run1.bag --vehicle boat.yaml --json - | jq .signs`. Exit
codes are the same: 0 done, 1 a mistake in a file or a value, 2 a mistake in the arguments.

The first field, `seatrial`, states kind and version of the content, such as `scores 6`. A new version may remove
or rename fields; the same version may get new ones. Units are SI unless a field states another one. null stands
for a number that is infinite or does not exist. `seatrial report --scores` reads what `seatrial validate --json`
writes.
"""


def fields(kind: type) -> list[tuple[str, str, str]]:
    """Name, type and meaning of each field, in the order of the source.

    Public classes state the meaning in their docstring, others in a comment.
    """
    lines = inspect.getsource(kind).splitlines()
    stated = dict(MEANING.findall(inspect.getdoc(kind) or ""))
    names = typing.get_type_hints(kind, include_extras=True)
    own: dict[str, tuple[str, str, str]] = {}
    for i, line in enumerate(lines):
        found = re.match(r"    (\w+):", line)
        if found is None or found[1] not in names:
            continue
        rows, opened = [], 0
        for row in lines[i:]:  # a field may take several lines
            code, _, comment = row.partition("  # ")
            rows.append(comment)
            opened += code.count("(") - code.count(")")
            if opened <= 0:
                break
        meaning = " ".join(stated.get(found[1], "").split()) or " ".join(filter(None, rows))
        own[found[1]] = (found[1], text_of(names[found[1]]), meaning)
    return [*own.values()]


def text_of(kind: Any) -> str:  # noqa: ANN401, a type or what stands for several
    """A type in words of JSON."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin is typing.Annotated:
        text = text_of(inner[0])
    elif origin is typing.Literal:
        text = " or ".join(f"`{value}`" for value in inner)
    elif origin in (dict, Mapping):
        text = f"object of {text_of(inner[1])}"
    elif origin in (list, tuple, Sequence):
        text = f"list of {text_of(inner[0])}"
    elif origin is not None:  # a union
        text = " or ".join(dict.fromkeys(text_of(one) for one in inner))
    elif isinstance(kind, type) and issubclass(kind, enum.Enum):
        text = "text"
    else:
        text = PLAIN.get(kind, f"`{getattr(kind, '__name__', kind)}`")
    return text


def classes_in(kind: Any) -> Iterator[type]:  # noqa: ANN401
    """Classes that a type mentions."""
    if isinstance(kind, type) and (
        issubclass(kind, msgspec.Struct) or dataclasses.is_dataclass(kind)
    ):
        yield kind
    for inner in typing.get_args(kind):
        yield from classes_in(inner)


def section(kind: type, done: set[type]) -> Iterator[str]:
    """A class and those that it mentions, each once on the page."""
    waiting = [kind]
    while waiting:
        here = waiting.pop(0)
        if here in done:
            continue
        done.add(here)
        if here is not kind:
            yield f"`{here.__name__}`: {first_line(here)}"
            yield ""
        rows = [row for row in fields(here) if row[0] != "seatrial"]
        yield from ("| field | type | meaning |", "|---|---|---|")
        for name, type_text, comment in rows:
            yield f"| `{name}` | {type_text} | {comment.replace('|', chr(92) + '|')} |"
        yield ""
        for hint in typing.get_type_hints(here).values():
            waiting += classes_in(hint)


def first_line(kind: type) -> str:
    """Of the class's docstring."""
    return inspect.cleandoc(kind.__doc__ or "").partition("\n\n")[0].replace("\n", " ")


def sections(commands: Sequence[str]) -> str:
    """What each command writes, a class once."""
    lines, done = list[str](), set[type]()
    for command in commands:
        for kind, content in SCHEMAS.get(command, {}).items():
            lines += [f"## seatrial {command}: `{kind}`", "", first_line(content), ""]
            lines += section(content, done)
    return "\n".join(lines).rstrip() + "\n"


def page() -> str:
    """The page of the site."""
    return f"{HEAD}\n{sections(list(COMMANDS))}"


def short() -> str:
    """The page in the repository."""
    kinds = [f"`{kind}`".replace(" ", "~") for name in COMMANDS for kind in SCHEMAS[name]]
    text = f"Kinds, in the order of `seatrial --help`: {', '.join(kinds)}."
    listed = [line.replace("~", " ") for line in textwrap.wrap(text, 120)]
    note = (
        "Fields of one command, with type, unit and meaning: `python tools/json_page.py validate`. `make docs`\n"
        "writes those of all commands into this page of the site.\n"
    )
    return "\n".join([HEAD, note, *listed]) + "\n"


if __name__ == "__main__":
    if sys.argv[1:]:
        print(sections(sys.argv[1:]), end="")
    else:
        PAGE.write_text(short())
