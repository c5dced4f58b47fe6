# SPDX-License-Identifier: MIT
"""The command line within a test."""

from seatrial.commands.cli import main


def run(capsys, *arguments) -> tuple[int, str, str]:
    code = main([str(a) for a in arguments])
    shown = capsys.readouterr()
    return code, shown.out, shown.err
