# SPDX-License-Identifier: MIT
"""Odometry in messages of any library, by the C++ tests of `ros/common`, under the sanitizers."""

import shutil

import pytest
from conftest import ROOT
from test_core_cpp import run


def test_the_messages_pass_their_own_tests_under_the_sanitizers(tmp_path):
    if shutil.which("c++") is None:
        pytest.skip("no C++ compiler")
    core, common = ROOT / "core", ROOT / "ros" / "common"
    folders = (core / "include", core / "tests", common / "include")
    sources = (core / "tests" / "main.cpp", common / "tests" / "test_messages.cpp")
    run(
        "c++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all", *(f"-I{folder}" for folder in folders), "-isystem",
        str(core / "tests" / "third_party"), *map(str, sources), "-o", str(tmp_path / "tests"),
    )  # fmt: skip
    shown = run(str(tmp_path / "tests"))
    assert "Status: SUCCESS!" in shown
    assert "0 failed" in shown
