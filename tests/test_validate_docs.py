# SPDX-License-Identifier: MIT
"""docs/validate.md: its commands and its code run, and print what it speaks of."""

import json
import shlex

import pytest
from test_docs import ROOT, blocks

from seatrial.commands.cli import main

PAGE = ROOT / "docs" / "validate.md"


@pytest.mark.system
def test_the_commands_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shown = []
    for line in blocks(PAGE, "sh")[0].splitlines():
        program, *arguments = shlex.split(line)
        assert program == "seatrial"
        if arguments[0] == "simulate":
            arguments += ["--vehicle", "mallard-af"]  # the page reads no trial of the other
        assert main([*arguments, "--quiet"]) == 0, line
        shown.append(capsys.readouterr().out)
    for word in (
        "error",
        "constant",
        "ratio",
        "floor",
        "excess",
        "95 %",
        "smoothed",
        "filter",
        "5 s",
    ):
        assert word in shown[2]
    assert "residuals in" in shown[2]  # the paper's method knows no dead zone, lag and delay
    assert "model (equation-error) against other (truth)" in shown[3]
    assert "worse" in shown[3]
    scores = json.loads((tmp_path / "scores.json").read_text())
    assert scores["seatrial"] == "scores 6"
    horizons = scores["recordings"][0]["horizons"]
    assert {h["start"] for h in horizons} == {"filter"}
    assert (scores["reference"], scores["recordings"][0]["reference"]) == ("smoothed", "smoothed")
    assert horizons[-1]["horizon"] == 5.0


def test_the_code_runs(capsys):
    exec(compile(blocks(PAGE, "python")[0], str(PAGE), "exec"), {})
    assert "model (truth) against other (equation-error)" in capsys.readouterr().out
