# SPDX-License-Identifier: MIT
"""Pin all dependencies with hashes: requirements/base.txt (run, build), test.txt, docs.txt, wheels.txt."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def compile_requirements(name: str, extras: list[str]) -> None:
    """Resolve pyproject.toml with some extras into requirements/NAME.txt."""
    command = ["uv", "pip", "compile", "pyproject.toml", "--universal", "--python-version", "3.10"]
    command += [
        "--generate-hashes", "--no-header", "--no-annotate", "--quiet", "--no-emit-index-url",
    ]  # fmt: skip
    command += [f"--extra={extra}" for extra in extras]
    subprocess.run([*command, "-o", f"requirements/{name}.txt"], cwd=ROOT, check=True)


if __name__ == "__main__":
    compile_requirements("base", ["build"])
    compile_requirements("test", ["build", "test", "lint"])
    compile_requirements("docs", ["docs"])
    compile_requirements("wheels", ["wheels"])
