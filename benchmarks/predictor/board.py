# SPDX-License-Identifier: MIT
"""The predictor as a C++ program of its own: the time of a step, and a soak test."""

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = ("onboard.cpp", "heap.cpp")
FLAGS = ("-std=c++17", "-O3", "-fno-exceptions", "-fno-rtti", "-Wall", "-Wextra")
STEPS = 10_000_000
SEED = 1
LABEL = 44  # width of what a line is about
RUNS = 5  # whatever else the machine does is in some of them


def build(folder: Path, compiler: str = "c++", *more: str) -> Path:
    """The program, in `folder`."""
    tests = ROOT / "core" / "tests"
    return compiled(folder / "onboard", [tests / s for s in SOURCES], compiler, f"-I{tests}", *more)


def compiled(made: Path, sources: Sequence[Path], compiler: str = "c++", *more: str) -> Path:
    """A program of the core, as for a board."""
    include = f"-I{ROOT / 'core' / 'include'}"
    command = [compiler, *FLAGS, *more, include, *map(str, sources), "-o", str(made)]
    subprocess.run(command, check=True)
    return made


def run(*arguments: str) -> str:
    """What it prints, as a block of a page."""
    with tempfile.TemporaryDirectory() as folder:
        program = build(Path(folder))
        done = subprocess.run(
            [str(program), *arguments], capture_output=True, text=True, check=False
        )
    if done.returncode != 0:
        raise SystemExit(f"onboard {' '.join(arguments)} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


def speed() -> str:
    """Markdown, with correlated pose errors at the right. Each line from the fastest of RUNS for it."""
    white, correlated = (
        [min(each, key=_median) for each in zip(*printed, strict=True)]
        for printed in (
            [run("time", *more).splitlines() for _ in range(RUNS)] for more in ((), ("coloured",))
        )
    )
    return beside(white, correlated)


def beside(white: Sequence[str], correlated: Sequence[str]) -> str:
    """Times of white and of correlated pose errors in one block."""
    width = max(map(len, white)) + 2
    lines = [f"{a:<{width}}{b[LABEL:]}" for a, b in zip(white, correlated, strict=True)]
    return "\n".join(["```", " " * (width + 3) + "correlated:", *lines, "```"])


def _median(line: str) -> float:
    """The line's first number; nothing where it has none."""
    numbers = [word for word in line[LABEL:].split() if word.replace(".", "").isdigit()]
    return float(numbers[0]) if numbers else 0.0


def soak() -> str:
    """Markdown; fails on an estimate that is not finite, or where memory is allocated."""
    return f"```\n{run('soak', str(STEPS), str(SEED))}```"
