# SPDX-License-Identifier: MIT
"""The allocator as a C++ program of its own: what a call costs."""

import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[3]
FLAGS = ("-std=c++17", "-O3", "-fno-exceptions", "-fno-rtti", "-Wall", "-Wextra", "-Werror")


def speed() -> str:
    """Markdown: what the program prints."""
    source = Path(__file__).with_name("board.cpp")
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "board"
        subprocess.run(
            ["c++", *FLAGS, f"-I{ROOT / 'core' / 'include'}", str(source), "-o", str(program)],
            check=True,
        )
        shown = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    return f"```\n{shown}```"
