# SPDX-License-Identifier: MIT
"""The demo as a user runs it: its files, its tables, and the figures that documents take from it."""

import io
import json
import re
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from conftest import CSE1, ROOT
from test_docs import plain

import seatrial
from seatrial.boat.findings import FindingKind
from seatrial.commands.cli import main
from seatrial.demo import bundled_data


@dataclass(frozen=True)
class Demo:
    """What `seatrial demo` left."""

    code: int
    out: str
    err: str
    folder: Path

    def rows(self, word: str, count: int) -> list[list[str]]:
        """The `count` lines that follow each line with this word."""
        lines = self.out.splitlines()
        return [lines[i + 1 : i + 1 + count] for i, line in enumerate(lines) if word in line]


def ran(folder: Path) -> Demo:
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = main(["demo", "--out", str(folder)])
    return Demo(code, out.getvalue(), err.getvalue(), folder)


@pytest.fixture(scope="module")
def demo(once) -> Demo:
    """All of it, which takes minutes."""
    return once("demo", ran)[1]


@pytest.mark.system
def test_the_demo_identifies_validates_and_reports(demo):
    assert (demo.code, demo.err) == (0, "")
    reports = sorted(str(p.relative_to(demo.folder)) for p in demo.folder.rglob("report.html"))
    assert reports == [
        "cse1/cse1-pair/report.html", "mallard/result-AF/report.html", "mallard/result-MP/report.html",
    ]  # fmt: skip
    for report in reports:
        scores = json.loads((demo.folder / report).with_name("scores.json").read_text())
        for row in scores["recordings"]:
            pairing = {"S4": "u", "S5": "v", "S6": "r"}  # Table III
            for symbol in pairing.get(row["recording"][:2], "uvr"):
                start = f"{row['recording']} {symbol},"
                (line,) = (text for text in demo.out.splitlines() if start in text)
                score = row["scores"][symbol]
                size = 1.0 if symbol == "r" else 100.0
                assert f" {size * score['rms']:.3f} ({score['ratio']:.2f})" in line
        assert seatrial.load((demo.folder / report).with_name("model.yaml")).recordings


@pytest.mark.system
def test_the_ships_ratios_are_the_readmes(demo):
    rows = [line for line in demo.out.splitlines() if "CSE1_data_run1 " in line]
    ratios = [re.findall(r"\((\d\.\d\d)\)", row) for row in rows]
    assert [len(row) for row in ratios] == [3, 3, 3]  # methods; u, v, r
    said = re.search(
        r"(\S+, \S+, \S+) by the paper's method; (\S+, \S+, \S+) by output-error with the paper's terms; "
        r"(\S+, \S+, \S+) with coupled terms and each propeller's two commands as a vector",
        plain(ROOT / "README.md"),
    )
    assert said is not None
    readme = [[float(number) for number in one.split(", ")] for one in said.groups()]
    # two digits of a number that lies between them differ from machine to machine
    np.testing.assert_allclose(np.array(ratios, dtype=float).T, readme, rtol=0.0, atol=0.011)


@pytest.mark.system
def test_the_share_of_poses_used_is_the_readmes(demo):
    (used,) = re.findall(r"(\d+)\.\d % of the poses used", demo.out)
    assert f"({used} % of its poses" in plain(ROOT / "README.md")


@pytest.mark.system
def test_the_default_method_finds_propellers_as_pairs_and_predicts_the_run_it_has_not_seen(
    demo, cse1
):
    """Offset and dead zone of the pitch as the bollard pulls have them; each group's own delay."""
    model, paper = (
        seatrial.load(demo.folder / "cse1" / name / "model.yaml")
        for name in ("cse1-pair", "cse1-equation-error")
    )
    run = seatrial.read(CSE1 / "csv" / "CSE1_data_run1.csv", model.vehicle)
    scores = seatrial.validate(model, [run]).recordings[0].scores
    papers = seatrial.validate(paper, [cse1["run1"]]).recordings[0].scores
    assert scores["u"].ratio < 0.45
    assert scores["v"].rms < 0.85 * papers["v"].rms
    assert scores["r"].rms < papers["r"].rms
    found = dict(zip(model.vehicle.constants.names, model.constants, strict=True))
    assert found["pair_offset_across.propellers"] == pytest.approx(0.20, abs=0.06)
    assert found["pair_dead_zone.propellers"] == pytest.approx(0.25, abs=0.08)
    for group in ("surge", "sway", "bow"):
        assert 0.1 < found[f"latency.{group}"] + found["lag"] < 0.5
    assert model.findings_of(FindingKind.MODEL_MISMATCH)


@pytest.mark.system
def test_the_simulated_boats_x_uu_are_the_documents(demo):
    tables = [rows for rows in demo.rows("N_ud", 3) if rows[0].startswith("  true")]
    x_uu = [[row.split()[2] for row in rows] for rows in tables]
    (truth, mp, mp_right), (_, af, af_right) = x_uu
    assert (
        f"X_uu is {truth}. The paper's method finds {mp} (MP) and {af} (AF), output-error {mp_right} "
        f"and {af_right}"
    ) in plain(ROOT / "README.md")
    derivations = plain(ROOT / "docs" / "derivations.md")
    assert f"X_uu = {mp} (MP) and {af} (AF) where the truth is {truth}" in derivations


def test_the_bundled_recordings_are_found_and_whole():
    assert (bundled_data() / "cse1" / "UPSTREAM_LICENSE.TXT").is_file()
    assert len(list((bundled_data() / "cse1" / "csv").glob("*.csv"))) == 3
