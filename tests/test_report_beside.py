# SPDX-License-Identifier: MIT
"""Two models on one page: the numbers of `compare`, and both in every plot."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import steered_boat
from html_tables import Tables

from seatrial.evaluation.comparison.compare import compare
from seatrial.evaluation.filtering import run_filter
from seatrial.evaluation.prediction import Lookahead
from seatrial.evaluation.reference import smoothed_motion
from seatrial.report.comparison import write_comparison
from seatrial.report.figures.embed import decode


@pytest.fixture(scope="module")
def runs(paper_mp):
    return [trial.recording.cut(0.0, 60.0) for trial in paper_mp.values()]


@pytest.fixture(scope="module")
def models(paper_mp_model):
    """The boat, and one that was made a fifth heavier by hand."""
    a = paper_mp_model
    b = replace(a, coefficients=a.coefficients / 1.2, recordings=())
    return a, b


@pytest.fixture(scope="module")
def found(models, runs):
    return compare(*models, runs[3:5], labels=("old.yaml", "<b>new</b>"))


@pytest.fixture(scope="module")
def text(models, runs, found, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "page.html"
    write_comparison(*models, runs[3:5], found, path)
    return path.read_text()


def test_the_order_is_the_reports(text):
    order = "verdict known model actuators recorded horizons prediction errors physics advice provenance"
    places = [text.index(f'id="{name}"') for name in order.split()]
    assert places == sorted(places)


def test_differences_are_those_of_compare(text, found):
    (rows,) = Tables(text).found["differences"]
    assert [row[0][0] for row in rows[1:]] == [p.name.replace("_", "", 1) if len(p.name.split("_")[0]) == 1
                                               else p.name for p in found.pairs]  # fmt: skip
    for row, pair in zip(rows[1:], found.pairs, strict=True):
        assert row[1][1] == [pair.a]
        assert row[3][1] == [pair.b]
        assert row[5][1] == [pair.difference]
        assert row[6][1] == [pair.z]


def test_errors_of_both_are_those_of_compare(text, found):
    (rows,) = Tables(text).found["ahead"]
    heads = [row[0][0] for row in rows[1:] if len(row) == 1]
    assert heads == [
        "S4-MP, 1 s (seen by A)" if row.seen_a else f"{row.recording}, 1 s" for row in found.ahead
    ]
    axes = [row for row in rows[1:] if len(row) > 1]
    for place, row in enumerate(found.ahead):
        for axis, symbol in enumerate("uvr"):
            cells, one = axes[3 * place + axis], row.axes[symbol]
            assert cells[2][1] == [one.a]
            assert cells[3][1] == [one.b]
            assert tuple(cells[6][1]) == one.interval
            assert cells[7][0] == (one.better or "no difference seen")


def test_both_predictions_are_in_the_plot(text, models, runs):
    packed = json.loads(re.search(r'id="run-0">(.*?)</script>', text, re.DOTALL)[1])
    traces = packed["figures"]["velocity-u"]["data"]
    assert [t["name"] for t in traces[:3]] == ["measured", "A", "B"]
    for trace, model in zip(traces[1:3], models, strict=True):
        moving, filtered = smoothed_motion(model, runs[3]), run_filter(model, runs[3])
        ahead = Lookahead(model, runs[3], filtered=filtered, smoothed=moving).predict(1.0)
        t, y = (decode(packed["columns"][trace[k]["column"]]) for k in "xy")
        there = np.isfinite(y)
        expected = np.interp(t[there], ahead.t, ahead.nu[:, 0])
        assert np.abs(y[there] - expected).max() < 0.03 * np.abs(expected).max()


def test_what_changed_is_said_first_and_names_stay_text(text):
    said = re.search(r'<div class="said">(.*?)</div>', text, re.DOTALL)[1]
    assert "A is old.yaml (mallard, output-error" in said
    assert "&lt;b&gt;new" in said
    assert "<i>X</i><sub>F</sub>" in said
    assert "17\u00a0%" in said or "20\u00a0%" in said  # less force a mass: as a fifth more mass
    assert "1 s ahead, the change matters for prediction: A is better in surge" in said
    assert "(*)" not in said
    assert "<b>new" not in text


def test_angles_are_compared_in_degrees(tmp_path):
    both = steered_boat.known(), steered_boat.known({"angle_deg": 30.0})
    write_comparison(*both, [], compare(*both), tmp_path / "c.html", figures=tmp_path / "f")
    angle, curve = ((tmp_path / "f" / f"{name}.svg").read_text() for name in ("angle", "curve"))
    assert "angle [deg]" in angle and "A: helm" in angle and "B: helm" in angle
    assert "thrust [share of full]" in curve and "motor" in curve and "helm" not in curve


def test_without_recordings_the_page_is_shorter_and_asks_for_them(models, tmp_path):
    path = tmp_path / "c.html"
    write_comparison(
        *models, [], compare(*models), path, figures=tmp_path / "f", tables=tmp_path / "t"
    )
    text = path.read_text()
    assert 'id="prediction"' not in text
    assert "Next: give recordings" in text
    assert {p.stem for p in (tmp_path / "f").glob("*.svg")} == {
        "picture", "known", "differences", "curve", "answer", "start-u", "start-v", "start-r",
    }  # fmt: skip
    assert {p.name for p in (tmp_path / "t").glob("*.csv")} == {
        "causes.csv", "known.csv", "differences.csv", "boat.csv", "provenance.csv",
    }  # fmt: skip
