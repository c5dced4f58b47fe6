# SPDX-License-Identifier: MIT
"""The predictor as a program: without exceptions, under the sanitizers, and on another machine."""

import pytest
from conftest import ROOT
from cpp_tools import built, needs, run
from test_docs import blocks

from benchmarks.predictor.board import build

ESTIMATES = 2001  # of the script
NUMBERS = 44  # of an estimate: time, health, pose, velocity, covariance
EXACT = "-ffp-contract=off"  # no fused multiply-add: the same rounding everywhere


pytestmark = pytest.mark.system


def test_it_compiles_without_exceptions_and_bears_a_soak_under_the_sanitizers():
    program = built("onboard")
    for more in ((), ("coloured",)):
        shown = run(str(program), "soak", "20000", "1", *more)
        assert "20000 steps, 0 estimates that are not sound, 0 allocations" in shown


def test_the_documented_lines_compile(tmp_path):
    needs("c++")
    source = tmp_path / "documented.cpp"
    source.write_text(blocks(ROOT / "docs" / "onboard.md", "cpp")[0])
    strict = ("-std=c++17", "-fno-exceptions", "-fno-rtti", "-Wall", "-Wextra", "-Werror")
    run("c++", *strict, "-fsyntax-only", f"-I{ROOT / 'core' / 'include'}", str(source))


def test_on_aarch64_it_says_the_same(tmp_path):
    needs("c++", "aarch64-linux-gnu-g++", "qemu-aarch64")
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    native = build(tmp_path / "here", "c++", "-Werror", EXACT)
    program = build(tmp_path / "there", "aarch64-linux-gnu-g++", "-Werror", "-static", EXACT)
    for more in ((), ("coloured",)):
        here = run(str(native), "script", *more)
        there = run("qemu-aarch64", str(program), "script", *more)
        assert len(here.splitlines()) == ESTIMATES
        assert {len(row.split()) for row in here.splitlines()} == {NUMBERS}
        assert there == here
