# SPDX-License-Identifier: MIT
"""docs/export.md: its commands run, and its lines in four languages say the core's number."""

import re
import shlex
import sys

import numpy as np
import pytest
from conftest import ROOT
from export_tools import program, run
from test_docs import blocks

import seatrial
from seatrial import _core
from seatrial.commands.cli import main
from seatrial.export import FORMATS
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model

PAGE = ROOT / "docs" / "export.md"


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """A folder in which the page's first block has been run."""
    pytest.importorskip("casadi")
    folder = tmp_path_factory.mktemp("docs")
    seatrial.save(
        plant_model(load_plan("clean"), seatrial.load_vehicle("mallard-mp")), folder / "model.yaml"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for line in blocks(PAGE, "sh")[0].splitlines():
            command = shlex.split(line.partition("#")[0])
            assert main([*command[1:], "-q"]) == 0, line
    assert {p.suffix for p in folder.iterdir()} == {chosen.suffix for chosen in FORMATS.values()}
    return folder


@pytest.fixture(scope="module")
def expected() -> float:
    """Surge velocity after half a second of half thrust."""
    model = plant_model(load_plan("clean"), seatrial.load_vehicle("mallard-mp"))
    plant = _core.Plant(model.boat, model.vehicle.chain, model.constants)
    plant.command(0.0, np.array([0.5, 0.0, 0.0]))
    plant.advance_to(0.5)
    return float(plant.state[3])


def said(text: str) -> float:
    return float(re.search(r"(\S+) m/s", text)[1])


@pytest.mark.system
def test_the_lines_of_c(exported, expected):
    program("cc")
    (exported / "main.c").write_text(blocks(PAGE, "c")[0])
    strict = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
    run("cc", *strict, "-o", "main", "main.c", "-lm", cwd=exported)
    assert said(run(exported / "main")) == pytest.approx(expected, abs=1e-10)


@pytest.mark.system
def test_the_lines_of_octave(exported, expected):
    program("octave-cli")
    (exported / "script.m").write_text("1;\n" + blocks(PAGE, "matlab")[0])
    shown = run("octave-cli", "--no-init-file", "--quiet", "script.m", cwd=exported)
    assert said(shown) == pytest.approx(expected, abs=1e-10)


@pytest.mark.system
def test_the_lines_of_fmpy(exported, expected):
    program("cc")
    pytest.importorskip("fmpy")
    shown = run(sys.executable, "-c", blocks(PAGE, "python")[0], cwd=exported)
    assert said(shown) == pytest.approx(expected, abs=1e-10)


def test_the_lines_of_casadi(exported, expected):
    """Steps of 10 ms, not of 1/240 s, and six digits."""
    shown = run(sys.executable, "-c", blocks(PAGE, "python")[1], cwd=exported)
    assert said(shown) == pytest.approx(expected, abs=1e-6)
