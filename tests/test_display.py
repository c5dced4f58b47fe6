# SPDX-License-Identifier: MIT
"""Tables of notebooks: every number and name is there, nothing from a file is markup."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, make_model
from survey_boat import TRUTH, boat

import seatrial
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.schema import EstimatorEntry, RecordingEntry
from seatrial.boat.vehicle import vehicle_from
from seatrial.display.html import LONGEST_NAME, MOST_LINES, MOST_ROWS

HOSTILE = "<script>alert(1)</script>&\"'<img src=x onerror=y>\x1b[31m\n"
VOID = {"wbr"}
KNOWN = {
    "table", "caption", "thead", "tbody", "tr", "th", "td", "b", "i", "sub", "sup", "wbr", "details",
    "summary", "ul", "li",
}  # fmt: skip


class Page(HTMLParser):
    """Checks that elements close in order, and gathers texts of cells."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.rows: list[list[str]] = []
        self.text = ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        assert tag in KNOWN, tag
        assert {name for name, _ in attrs} <= {"style", "class", "colspan"}
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data
        if {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data


@pytest.fixture
def model(mp):
    return make_model(mp, TABLE_II["MP"])


def test_a_model_shows_every_parameter_with_error_unit_and_relative_interval(model):
    head, *rows = Page(model._repr_html_()).rows
    assert head == ["parameter", "value ± standard error", "unit", "relative 95 % interval"]
    shown = {row[0]: row[1:] for row in rows}
    assert len(rows) == len(model.parameters) == len(shown)
    for name, value in model.values.items():
        text, unit, relative = shown[name.replace("_", "", 1)]
        assert float(text.partition(" ±")[0].replace("−", "-")) == pytest.approx(value, rel=0.02)
        assert unit.replace("2", "^2") == model.structure.units[name]
        assert relative == "± 20 %"  # 1.96 standard errors of 10 %
    assert "forward-left-up axes" in Page(model._repr_html_()).text


def test_a_parameter_that_is_given_or_at_its_bound_is_named_so_and_findings_are_folded():
    model = make_model(boat([{"latency": 0.05, "lag": 0.1}]), TRUTH)
    found = finding_of(FindingKind.AT_BOUND, "lag", bound=0.002)
    entry = EstimatorEntry("output-error", findings=[found])
    page = Page(replace(model, estimator=entry, warnings=("look",))._repr_html_())
    shown = {row[0]: row[1:] for row in page.rows}
    assert shown["lag"] == ["0.1", "s", "at its bound"]
    assert shown["latency"] == ["0.05", "s", "given"]
    assert "2 findings" in page.text
    assert "lag: the estimate is at the bound 0.002" in page.text


@pytest.mark.parametrize("where", ["model", "recording", "scores"])
def test_names_from_files_are_no_markup(model, paper_mp, where):
    recording = replace(
        paper_mp["S1"].recording.cut(0, 60), name=HOSTILE, remarks=(HOSTILE,), doubts=(HOSTILE,)
    )
    if where == "model":
        content = model.vehicle.to_mapping() | {"name": "<b onclick=x>&amp;"}
        entry = EstimatorEntry(HOSTILE)
        shown = replace(
            model, vehicle=vehicle_from(content, "v"), estimator=entry, warnings=(HOSTILE,),
            recordings=(RecordingEntry(HOSTILE, 3.0),),
        )._repr_html_()  # fmt: skip
    elif where == "recording":
        shown = recording._repr_html_()
    else:
        scores = seatrial.validate(model, [recording])
        shown = msgspec.structs.replace(scores, model=HOSTILE, method=HOSTILE)._repr_html_()
    page = Page(shown)  # refuses elements that seatrial does not write
    assert "<script>alert(1)</script>&\"'" in page.text or "<b onclick=x>&amp;" in page.text
    assert "\x1b" not in shown


def test_long_names_and_many_rows_are_cut(paper_mp, model):
    scores = seatrial.validate(model, [paper_mp["S1"].recording.cut(0, 60)])
    (row,) = scores.recordings
    row = msgspec.structs.replace(row, recording="x" * 5000)
    many = msgspec.structs.replace(scores, recordings=[row] * 400)
    page = Page(many._repr_html_())
    assert len(page.rows) == 1 + MOST_ROWS + 1
    assert page.rows[-1] == [f"… {1200 - MOST_ROWS} more rows"]
    assert max(len(cell) for cells in page.rows for cell in cells) == LONGEST_NAME
    noisy = replace(paper_mp["S1"].recording, remarks=tuple("abcdefghijklmnopqrst"))
    assert f"… {20 + len(noisy.faults) - MOST_LINES} more" in Page(noisy._repr_html_()).text


def test_scores_show_error_floor_and_constant_velocity(model, paper_mp):
    scores = seatrial.validate(model, [paper_mp["S1"].recording.cut(0, 60)])
    _, *rows = Page(scores._repr_html_()).rows
    assert [row[1] for row in rows] == ["surge u", "sway v", "yaw r"]
    for row, symbol, scale in zip(rows, "uvr", (100.0, 100.0, 1.0), strict=True):
        score = scores.recordings[0].scores[symbol]
        for cell, value in (
            (2, score.rms * scale),
            (3, score.floor * scale),
            (5, score.stays_constant * scale),
        ):
            assert number(row[cell]) == pytest.approx(value, rel=0.006)
        assert number(row[6]) == pytest.approx(score.ratio, rel=0.06)


def number(text: str) -> float:
    """A number with a true minus and a power of ten."""
    plain = text.replace("−", "-").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    return float(re.sub("·10", "e", plain))


def test_a_recording_shows_ranges_rates_and_faults(paper_mp):
    recording = paper_mp["S1"].recording
    page = Page(recording._repr_html_())
    shown = {row[0]: row[1:3] for row in page.rows}
    eta = recording.eta[recording.valid]
    for i, name in enumerate(("x", "y", "psi")):
        least, most = (number(cell) for cell in shown[name])
        assert least == pytest.approx(eta[:, i].min(), rel=0.01)
        assert most == pytest.approx(eta[:, i].max(), rel=0.01)
    assert {"Fu", "Fv", "Fr"} <= set(shown)
    assert f"{len(recording.t)} poses" in page.text
    assert all(fault.kind.value in page.text for fault in recording.faults[:MOST_LINES])


def test_a_recording_without_a_usable_number_is_shown(paper_mp):
    recording = paper_mp["S1"].recording
    eta = np.where(np.arange(3) == 1, np.nan, recording.eta)
    page = Page(replace(recording, eta=eta)._repr_html_())
    assert ["y", "–", "–", "m"] in page.rows


def test_every_bundled_boat_and_the_ship_are_shown(cse1, af):
    assert "propeller" in Page(cse1["run1"]._repr_html_()).text
    assert "mallard" in Page(make_model(af, TABLE_II["AF"])._repr_html_()).text
