# SPDX-License-Identifier: MIT
"""The reference: every command with its options, and the library's public names.

The site has all of it (tools/generated.py); docs/reference.md in the repository names commands and functions.

python tools/reference.py            # writes docs/reference.md, after a new command or public name
"""

import argparse
import dataclasses
import inspect
import re
import textwrap
import typing
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import json_page  # beside this file
import msgspec

import seatrial
from seatrial.commands import make_parser

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference.md"
TERMINAL = """\
## On a terminal

- A command that takes longer than half a second shows one line: its stage, the share done and the time left.
  `--quiet` hides it, as a pipe does. In Python: `with seatrial.show_progress():`, or with your own function.
- `NO_COLOR=1` leaves colours out, `FORCE_COLOR=1` writes them to a pipe, too.
- A wide table continues below with its first column again. A pipe gets whole lines.
- The shell completes commands, options, choices and files after `source <(seatrial completion bash)` in
  `~/.bashrc`; for zsh `seatrial completion zsh > DIR/_seatrial`, where DIR is one of `$fpath`; for tcsh
  `seatrial completion tcsh`.
- Every command writes its [result as JSON](json.md).
"""
SHARED = 3  # commands from which on an option is explained once for all of them


def commands(parser: argparse.ArgumentParser) -> list[str]:
    """A section for each command."""
    chosen = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    said = {action.dest: action.help or "" for action in chosen._choices_actions}
    for command in chosen.choices.values():
        command.fill()
    rows = {
        name: [option(a) for a in command._actions if a.dest != "help"]
        for name, command in chosen.choices.items()
    }
    counts = Counter(row for some in rows.values() for row in some if row[0].startswith("-"))
    common = [row for row, count in counts.items() if count >= SHARED]
    lines = ["## Commands", "", "Options of several commands; each command names those it has:", ""]
    lines += [*listed(common), ""]
    for name, some in rows.items():
        typed = " ".join(["seatrial", name, *(n for n, _ in some if not n.startswith("-"))])
        also = ", ".join(
            f"`{re.findall('--[a-z-]+', n)[0]}`" for n, text in some if (n, text) in common
        )
        own = [(n, text) for n, text in some if (n, text) not in common and (text or n[0] == "-")]
        lines += [f"### seatrial {name}", "", said[name][:1].upper() + said[name][1:] + "."]
        lines += [f"`{typed}`; also {also}.", "", *listed(own), ""]
    return lines


def listed(rows: Sequence[tuple[str, str]]) -> list[str]:
    """Options and what they do."""
    return [f"- `{name}`: {text}" if text else f"- `{name}`" for name, text in rows]


def option(action: argparse.Action) -> tuple[str, str]:
    """An option as it is typed, and its help."""
    value = action.metavar or (
        "|".join(map(str, action.choices)) if action.choices else action.dest
    )
    if isinstance(value, tuple):
        value = " ".join(value)
    if action.nargs == 0:
        value = ""
    elif action.nargs in {"+", "*"}:
        value = f"{value} ..."
    name = " ".join([", ".join(action.option_strings), str(value)]).strip()
    text = (action.help or "") % {"default": action.default, "prog": "seatrial"}
    return name, text.replace("\n", " ")


def library() -> list[str]:
    """What `import seatrial` gives."""
    lines = ["## Library", "", "`import seatrial`; layer by layer the rest is in the source.", ""]
    things = [getattr(seatrial, name) for name in seatrial.__all__]
    for thing in [*things, *results(things)]:
        name = thing.__name__
        text = inspect.cleandoc(thing.__doc__ or "")
        head = f"{name}{inspect.signature(thing)}" if inspect.isfunction(thing) else f"class {name}"
        of_fields: list[str] = []
        if dataclasses.is_dataclass(thing) or issubclass(type(thing), type(msgspec.Struct)):
            fields = [(own, meaning) for own, _, meaning in json_page.fields(thing)]
            of_fields, text = [*listed(fields), ""], json_page.MEANING.sub("", text).strip()
        lines += [f"### {name}", "", "```python", plain(head), "```", "", text, "", *of_fields]
    return lines


def results(things: Sequence[object]) -> list[type]:
    """Classes that functions return, and that have no name in `seatrial`."""
    functions = [thing for thing in things if inspect.isfunction(thing)]
    found = dict.fromkeys(typing.get_type_hints(f)["return"] for f in functions)
    own = [kind for kind in found if inspect.isclass(kind) and kind.__module__ != "builtins"]
    return [kind for kind in own if kind not in things]


def plain(signature: str) -> str:
    """A signature with the types' own names, without their modules; a function as default value is `...`."""
    signature = re.sub(r"<function .*? at 0x[0-9a-f]+>", "...", signature)
    return re.sub(r"(?:\b[a-z_]+\.)+(?=[A-Z])", "", signature.replace("'", ""))


def names() -> list[str]:
    """Commands, each with its purpose, and the library's names."""
    chosen = next(a for a in make_parser()._actions if isinstance(a, argparse._SubParsersAction))
    rows = [f"- `{action.dest}`: {action.help}" for action in chosen._choices_actions]
    library = ", ".join(f"`{name}`" for name in seatrial.__all__)
    text = (
        "`import seatrial`, then `help(seatrial.NAME)`; `print` shows a model, scores, an inspection, "
        f"comparison or tuning like its command: {library}."
    )
    lines = ["## Commands", "", "`seatrial COMMAND --help` shows options and examples.", ""]
    lines += [*rows, "", "## Library", ""]
    return [*lines, *textwrap.wrap(text, 120, break_on_hyphens=False)]


def short() -> str:
    """The page in the repository."""
    note = "`make docs` writes every option and docstring into this page of the site."
    return "\n".join(["# Reference", "", note, "", TERMINAL, *names()]) + "\n"


def page() -> str:
    """The page of the site."""
    head = ["# Reference", "", TERMINAL]
    return "\n".join([*head, *commands(make_parser()), *library()]).rstrip() + "\n"


if __name__ == "__main__":
    PAGE.write_text(short())
