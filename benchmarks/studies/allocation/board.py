# SPDX-License-Identifier: MIT
"""The allocator as a C++ program of its own: what a call costs."""

import subprocess
import tempfile
from pathlib import Path

from benchmarks.predictor.board import compiled


def speed() -> str:
    """Markdown: what the program prints."""
    with tempfile.TemporaryDirectory() as folder:
        program = compiled(Path(folder) / "board", [Path(__file__).with_name("board.cpp")])
        shown = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    return f"```\n{shown}```"
