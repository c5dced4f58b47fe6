# SPDX-License-Identifier: MIT
"""clang-tidy over all C++ of this package, in few units: what a header costs is paid once a unit, not once a file.

    python tools/tidy.py [UNITS]        # of sources, and of tests; one by default, as `make lint` has it

A unit is the text of several files: below all their includes the sources of nodes as they are, and each file of
tests in a namespace of its own. Text, not includes: the analyser follows paths in the main file only. It follows
those of nodes and programs, and from them those of headers. Tests have all other checks: what they do is checked
as they run, by the address and undefined-behaviour sanitizers. Findings are shown at their place in the files.
"""

import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "clang-tidy"
TESTS = ("core/tests/test_*.cpp", "ros/common/tests/test_*.cpp")
SOURCES = (
    "ros/common/src/*.cpp",
    *(f"ros/common/tests/{name}.cpp" for name in ("board_model", "mimic", "parameters", "script", "tracking")),
)  # fmt: skip
NOT_ANALYSED = ("--checks=-clang-analyzer-*",)  # on top of .clang-tidy
FOLDERS = ("core/include", "core/compat", "core/tests", "ros/common/include", "ros/common/tests")
FLAGS = [
    "-std=c++17", "-Wall", "-Wextra", *(f"-I{ROOT / folder}" for folder in FOLDERS),
    "-isystem", str(ROOT / "core/tests/third_party"),
]  # fmt: skip
INCLUDE = re.compile(r"^#include .*$", re.MULTILINE)


@dataclass(frozen=True)
class Unit:
    """Files in one, and where each begins in it."""

    path: Path
    starts: list[tuple[int, str]]  # (line before the file's first, file), rising
    options: tuple[str, ...] = ()  # of clang-tidy

    def placed(self, text: str) -> str:
        """Findings with the places in the files."""
        return re.sub(rf"{re.escape(str(self.path))}:(\d+)", self._place, text)

    def _place(self, found: re.Match[str]) -> str:
        line = int(found[1])
        inside = [(first, name) for first, name in self.starts if first < line]
        return f"{inside[-1][1]}:{line - inside[-1][0]}" if inside else found[0]


def tracked(patterns: tuple[str, ...]) -> list[str]:
    """Files by the patterns, as git knows them."""
    command = ["git", "ls-files", *patterns]
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.splitlines()


def unit(path: Path, files: list[str], *options: str) -> Unit:
    """One file with all of them."""
    texts = {name: (ROOT / name).read_text() for name in files}
    lines = sorted({line for text in texts.values() for line in INCLUDE.findall(text)})
    starts = []
    for name, text in texts.items():
        own = "/tests/" in name
        lines += [f"namespace {Path(name).stem}_unit {{"] if own else []
        starts.append((len(lines), name))
        lines += INCLUDE.sub("", text).splitlines()
        lines += ["}"] if own else []
    path.write_text("\n".join(lines) + "\n")
    return Unit(path, starts, options)


def tidy(made: Unit) -> tuple[bool, str]:
    """Whether all is well, and the findings."""
    command = ["clang-tidy", "--quiet", *made.options, str(made.path), "--", *FLAGS]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.returncode == 0, made.placed(done.stdout + done.stderr[-2000:])


def main() -> int:
    """Check all; 1 where there is a finding."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    BUILD.mkdir(parents=True, exist_ok=True)
    units = [
        unit(BUILD / f"{name}_{i}.cpp", files[i::count], *options)
        for name, files, options in (
            ("source", tracked(SOURCES), ()),
            ("test", tracked(TESTS), NOT_ANALYSED),
        )
        for i in range(count)
        if files[i::count]
    ]
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        found = list(pool.map(tidy, units))
    for well, text in found:
        if not well:
            sys.stdout.write(text)
    return int(not all(well for well, _ in found))


if __name__ == "__main__":
    sys.exit(main())
