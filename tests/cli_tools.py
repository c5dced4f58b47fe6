# SPDX-License-Identifier: MIT
"""The command line within a test."""

import json
from pathlib import Path

import msgspec
from programs import PROGRAM, piped
from waiting import PATIENCE

from seatrial.commands.cli import main
from seatrial.commands.shared.schemas import SCHEMAS


def run(capsys, *arguments) -> tuple[int, str, str]:
    code = main([str(a) for a in arguments])
    shown = capsys.readouterr()
    return code, shown.out, shown.err


def done(capsys, *arguments) -> str:
    """What a command shows that does what it is asked to, without a word of errors."""
    code, shown, error = run(capsys, *arguments)
    assert (code, error) == (0, ""), error
    return shown


def refused(capsys, *arguments) -> str:
    """The one line with which a command refuses, and nothing else that it says."""
    code, shown, error = run(capsys, *arguments)
    assert (code, shown, error.count("\n")) == (1, "", 1), error
    return error


def by_lines(command: str, *arguments, lines=()) -> tuple[int, list[dict], str]:
    """Code, lines of JSON and what is said by a command in a process of its own, given lines."""
    done = piped([PROGRAM, command, *map(str, arguments)], input="\n".join(lines), timeout=PATIENCE)
    return done.returncode, [json.loads(line) for line in done.stdout.splitlines()], done.stderr


def documented(command: str, path: Path) -> dict:
    """The content of a JSON file, which is as the page on JSON says: no other field, none missing, no other type."""
    content = json.loads(path.read_text())
    kind = SCHEMAS[command][content["seatrial"]]
    msgspec.convert(content, kind, strict=True)
    names = {field.name: field.required for field in msgspec.structs.fields(kind)}
    assert set(content) - {"seatrial"} <= set(names)
    assert {name for name, required in names.items() if required} <= set(content)
    return content
