# SPDX-License-Identifier: MIT
"""docs/reference.md: every command with its options, and the library's public names.

python tools/reference.py            # after a change of either
"""

import argparse
import inspect
import re
from pathlib import Path

import seatrial
from seatrial.commands import make_parser

PAGE = Path(__file__).resolve().parents[1] / "docs" / "reference.md"


def commands(parser: argparse.ArgumentParser) -> list[str]:
    """A section for each command."""
    chosen = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    said = {action.dest: action.help or "" for action in chosen._choices_actions}
    lines = ["## Commands", ""]
    for name, command in chosen.choices.items():
        lines += [f"### seatrial {name}", "", said[name][:1].upper() + said[name][1:] + ".", ""]
        lines += ["| | |", "|---|---|"]
        lines += [option(a) for a in command._actions if a.dest != "help"]
        lines.append("")
    return lines


def option(action: argparse.Action) -> str:
    """A row of the table."""
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
    return f"| `{cell(name)}` | {cell(text)} |"


def cell(text: str) -> str:
    """Text that may stand in a table."""
    return text.replace("|", "\\|").replace("\n", " ")


def library() -> list[str]:
    """What `import seatrial` gives."""
    lines = ["## Library", "", "`import seatrial`; layer by layer the rest is in the source.", ""]
    for name in seatrial.__all__:
        thing = getattr(seatrial, name)
        text = inspect.cleandoc(thing.__doc__ or "")
        head = f"{name}{inspect.signature(thing)}" if inspect.isfunction(thing) else f"class {name}"
        lines += [f"### {name}", "", "```python", plain(head), "```", "", text, ""]
    return lines


def plain(signature: str) -> str:
    """A signature with the types' own names, without their modules."""
    return re.sub(r"(?:\b[a-z_]+\.)+(?=[A-Z])", "", signature.replace("'", ""))


def page() -> str:
    """The whole page."""
    head = ["# Reference", "", "Made by `tools/reference.py` from the program itself.", ""]
    return "\n".join([*head, *commands(make_parser()), *library()]).rstrip() + "\n"


if __name__ == "__main__":
    PAGE.write_text(page())
