# SPDX-License-Identifier: MIT
"""Messages of any library: odometry, commands, references; C++ tests of `ros/common` under the sanitizers."""

import shutil
from pathlib import Path

import pytest
from conftest import ROOT
from test_core_cpp import run


@pytest.mark.parametrize(
    ("source", "libraries"),
    [("test_messages.cpp", ()), ("test_tracking_messages.cpp", ("-lyaml-cpp",))],
)
def test_the_messages_pass_their_own_tests_under_the_sanitizers(source, libraries, tmp_path):
    if shutil.which("c++") is None:
        pytest.skip("no C++ compiler")
    if libraries and not Path("/usr/include/yaml-cpp").exists():
        pytest.skip("libyaml-cpp-dev is not installed")
    core, common = ROOT / "core", ROOT / "ros" / "common"
    folders = (core / "include", core / "tests", common / "include")
    sources = (core / "tests" / "main.cpp", common / "tests" / source)
    run(
        "c++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all", *(f"-I{folder}" for folder in folders), "-isystem",
        str(core / "tests" / "third_party"), *map(str, sources), *libraries, "-o", str(tmp_path / "tests"),
    )  # fmt: skip
    shown = run(str(tmp_path / "tests"))
    assert "Status: SUCCESS!" in shown
    assert "0 failed" in shown
