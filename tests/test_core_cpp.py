# SPDX-License-Identifier: MIT
"""The core's own C++ tests, built with the address and undefined-behaviour sanitizers."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
BIN = Path(sys.executable).parent


def run(*command: str) -> str:
    path = f"{BIN}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        command,
        cwd=ROOT,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, (
        f"{' '.join(command)}\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
    )
    return done.stdout


def test_the_core_passes_its_own_tests_under_the_sanitizers():
    cmake = shutil.which("cmake", path=f"{BIN}{os.pathsep}{os.environ['PATH']}")
    if cmake is None or shutil.which("c++") is None:
        pytest.skip("no cmake or C++ compiler")
    build = ROOT / "build" / "core"
    run("cmake", "-S", ".", "-B", str(build), "-DSEATRIAL_SANITIZE=ON")
    run("cmake", "--build", str(build), "--parallel", "2", "--target", "core_tests")
    shown = run(str(build / "core" / "tests" / "core_tests"))
    assert "Status: SUCCESS!" in shown
    assert "0 failed" in shown
