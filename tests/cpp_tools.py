# SPDX-License-Identifier: MIT
"""Programs in C++ that tests run: one CMake tree, under the sanitizers; whoever needs one first builds it."""

import fcntl
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from contextlib import contextmanager
from pathlib import Path

import pytest
from programs import piped, printed

ROOT = Path(__file__).resolve().parents[1]
BIN = Path(sys.executable).parent
BUILD = ROOT / "build" / "cpp-tests"
CORE, NODES = BUILD, BUILD / "nodes"


def run(*command: str) -> str:
    """What it prints; the virtual environment's programs are found first."""
    path = f"{BIN}{os.pathsep}{os.environ['PATH']}"
    return printed(*command, cwd=ROOT, env={**os.environ, "PATH": path})


NOT_CLONED = {"build", "demo", "site", "dist"}  # of a folder that is worked in


def clone_into(src: Path) -> None:
    """The repository as `git clone` leaves it in a workspace, by links: what was changed is built."""
    src.mkdir(parents=True, exist_ok=True)
    for path in ROOT.iterdir():
        link = src / path.name
        if path.name not in NOT_CLONED and not path.name.startswith(".") and not link.exists():
            link.symlink_to(path)


def optimisation_option(*, quick: bool) -> str:
    """CMake's option for nodes that are tested, at half of -O3's time to compile, or timed as they are installed."""
    return f"-DCMAKE_CXX_FLAGS_RELEASE={'-O1' if quick else '-O3 -DNDEBUG'}"


def fed(
    program: Path, events: Iterable[str], **settings: object
) -> subprocess.CompletedProcess[str]:
    """A node without ROS, with these parameters, after these events on its standard input."""
    return piped(
        [program, *(f"{name}={value}" for name, value in settings.items())], input="\n".join(events)
    )


def needs(*programs: str, yaml: bool = False) -> None:
    """Skip where one of them is not installed."""
    for program in programs:
        if shutil.which(program, path=f"{BIN}{os.pathsep}{os.environ['PATH']}") is None:
            pytest.skip(f"no {program}")
    if yaml and not Path("/usr/include/yaml-cpp/yaml.h").exists():
        pytest.skip("libyaml-cpp-dev is not installed")


@contextmanager
def _alone(name: str):
    """One process at a time."""
    BUILD.mkdir(parents=True, exist_ok=True)
    with (BUILD / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def built(target: str) -> Path:
    """A program of `core/tests` or `ros/common/tests`."""
    folder = CORE if target in ("core_tests", "onboard") else NODES
    needs("cmake", "c++", yaml=folder == NODES)
    with _alone("configure"):
        run(
            "cmake", "-S", "core/tests", "-B", str(BUILD), "-G", "Unix Makefiles",
            "-DSEATRIAL_SANITIZE=ON", "-DCMAKE_BUILD_TYPE=Debug",
        )  # fmt: skip
    with _alone(target):
        run("cmake", "--build", str(BUILD), "--parallel", "2", "--target", target)
    return folder / target
