# SPDX-License-Identifier: MIT
"""Release checklist.

python tools/release.py --check      # all of it, one line a point; exit code 1 where something is missing

Then `git tag -a vX.Y.Z -m "seatrial X.Y.Z"`, `make wheels`, and upload what is in dist/.
"""

import argparse
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SEMANTIC = r"(\d+\.\d+\.\d+)"  # of semver.org, without pre-releases
PLACES: Mapping[str, str] = {  # where the version stands; the first decides
    "pyproject.toml": rf'(?m)^version = "{SEMANTIC}"$',
    "CITATION.cff": rf"(?m)^version: {SEMANTIC}$",
    "core/package.xml": rf"<version>{SEMANTIC}</version>",
    "core/CMakeLists.txt": rf"project\(seatrial_core VERSION {SEMANTIC} ",
    "ros/package.xml": rf"<version>{SEMANTIC}</version>",
    "packaging/conda/recipe.yaml": rf"(?m)^  version: {SEMANTIC}$",
}
Point = tuple[str, bool, str]  # what, whether it holds, what to do


def versions() -> dict[str, str]:
    """The version by place; "": none of semantic form."""
    found = {p: re.search(pattern, (ROOT / p).read_text()) for p, pattern in PLACES.items()}
    return {place: match[1] if match else "" for place, match in found.items()}


def git(*command: str) -> str:
    """What it prints."""
    done = subprocess.run(["git", *command], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def points() -> Iterator[Point]:
    """The checklist."""
    stated = versions()
    version = next(iter(stated.values()))
    for place, other in stated.items():
        yield f"{place}: version {other or 'missing'}", other == version != "", f"write {version}"
    section = rf"(?m)^## {re.escape(version)}$"
    changes = (ROOT / "CHANGELOG.md").read_text()
    yield (
        f"CHANGELOG.md: section of {version}", re.search(section, changes) is not None,
        f"name the section '## {version}'",
    )  # fmt: skip
    yield (
        "CHANGELOG.md: nothing unreleased", "## Unreleased" not in changes,
        "move its lines into the release's section",
    )  # fmt: skip
    yield "tree is clean", not git("status", "--porcelain"), "commit, or remove files"
    yield f"tag v{version} is free", not git("tag", "--list", f"v{version}"), "raise the version"


def main() -> None:
    """Print the list."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", required=True, help="print the checklist")
    parser.parse_args()
    found = list(points())
    for what, holds, advice in found:
        print(f"{'ok     ' if holds else 'MISSING'} {what}{'' if holds else f': {advice}'}")
    sys.exit(not all(holds for _, holds, _ in found))


if __name__ == "__main__":
    main()
