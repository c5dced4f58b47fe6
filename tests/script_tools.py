# SPDX-License-Identifier: MIT
"""The node without ROS as a program, `ros/common/tests/script.cpp`, built under the sanitizers."""

import fcntl
from pathlib import Path

import pytest
from conftest import ROOT
from test_core_cpp import run

BUILD = ROOT / "build" / "script"


def program() -> Path:
    """Built once, whoever of several test processes comes first."""
    if not Path("/usr/include/yaml-cpp").exists():
        pytest.skip("libyaml-cpp-dev is not installed")
    BUILD.mkdir(parents=True, exist_ok=True)
    with (BUILD / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        run(
            "cmake",
            "-S",
            ".",
            "-B",
            str(BUILD),
            "-DSEATRIAL_SANITIZE=ON",
            "-DCMAKE_BUILD_TYPE=Debug",
        )
        run("cmake", "--build", str(BUILD), "--target", "script")
    return BUILD / "ros" / "common" / "tests" / "script"
