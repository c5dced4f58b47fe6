# SPDX-License-Identifier: MIT
"""Figures as SVG and tables as CSV and LaTeX: the same numbers as on the page."""

import csv
import re
from dataclasses import replace
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

from seatrial.recording.faults.pose_faults import Fault, FaultKind
from seatrial.report import write_report
from seatrial.report.figures.base import (
    area,
    figure,
    level,
    line,
    logarithmic,
    marks,
    room_for,
    upright,
    whiskers,
)
from seatrial.report.figures.recorded import timeline
from seatrial.report.figures.svg import svg
from seatrial.report.figures.svg_axes import Axis
from seatrial.report.text.cells import Interval, Name, Number, Text, Unit, Worded, between, known
from seatrial.report.text.table import Table

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def written(tmp_path_factory, paper_mp, paper_mp_model):
    out = tmp_path_factory.mktemp("out")
    trials = [trial.recording for trial in paper_mp.values()]
    model = paper_mp_model
    write_report(
        model,
        [trials[3], trials[0]],
        out / "r.html",
        figures=out / "figures",
        tables=out / "tables",
    )
    return model, out


def texts(text: str) -> list[str]:
    return ["".join(e.itertext()) for e in ElementTree.fromstring(text).iter(f"{SVG}text")]


def numbers(path: str) -> list[float]:
    return [float(x) for x in re.findall(r"-?\d+\.?\d*", path)]


def test_every_figure_of_the_page_is_a_file_that_can_be_read(written):
    _, out = written
    page = (out / "r.html").read_text()
    names = set(re.findall(r'data-run="all" data-figure="([^"]*)"', page))
    own = set(re.findall(r'data-run="run-0" data-figure="([^"]*)"', page))
    files = {p.stem for p in (out / "figures").glob("*.svg")}
    expected = names | {f"{run}-{name}" for run in ("S4-MP", "S1-MP") for name in own}
    assert files == expected
    for path in (out / "figures").glob("*.svg"):
        shown = texts(path.read_text())
        assert any("[" in text for text in shown), path
        assert "href" not in path.read_text()


def test_a_line_goes_from_corner_to_corner_and_breaks():
    y = np.array([0.0, 1.0, np.nan, 2.0, 4.0])
    one = figure([line("a & b", np.arange(5.0), y, "#0072b2")], "x [m]", "y [m]",
                 xaxis={"range": [0, 4]}, yaxis={"range": [0, 4]}, showlegend=True)  # fmt: skip
    text = svg(one)
    root = ElementTree.fromstring(text)
    (path,) = [p for p in root.iter(f"{SVG}path") if p.get("stroke") == "#0072b2" and "clip" not in p.attrib
               and p.get("d").count("M") == 2]  # fmt: skip
    at = np.array(numbers(path.get("d"))).reshape(-1, 2)
    box = root.find(f".//{SVG}clipPath/{SVG}rect")
    left, top, width, height = (float(box.get(k)) for k in ("x", "y", "width", "height"))
    assert at[0] == pytest.approx([left, top + height], abs=0.1)
    assert at[-1] == pytest.approx([left + width, top], abs=0.1)
    assert at[1] == pytest.approx([left + width / 4, top + 0.75 * height], abs=0.1)
    assert {"a & b", "x [m]", "y [m]"} <= set(texts(text))


def test_bars_marks_intervals_bands_and_limits_are_drawn():
    x = np.array([1.0, 2.0, 3.0])
    traces = [
        {"type": "bar", "name": "bars", "x": x, "y": x, "marker": {"color": "#56b4e9"}},
        marks("marks", np.column_stack([x, x]), "#d55e00", "diamond")
        | {"error_y": whiskers(x, x - 0.5, x + 0.5, "#d55e00")},
        area("band", x, x - 1, x + 1, "#0072b2"),
    ]
    text = svg(
        figure(traces, "x [s]", "y [m]", shapes=[upright(2.0, "#e69f00"), level(9.0, "#009e73")])
    )
    assert text.count('fill="#56b4e9"') == 4  # three bars and the legend's
    assert text.count('stroke="#e69f00"') == 1
    assert text.count('stroke="#009e73"') == 1  # and the axis reaches up to it
    heights = [float(h) for h in re.findall(r'height="([\d.]+)" fill="#56b4e9"', text)][:3]
    assert np.diff(heights) == pytest.approx([heights[0]] * 2, abs=0.2)


def test_logarithms_and_given_ticks_stand_where_they_belong():
    axis = Axis(-1.0, 1.0, 100.0, 300.0, logarithmic=True)
    assert axis.place([0.1, 1.0, 10.0]) == pytest.approx([100.0, 200.0, 300.0])
    assert np.isnan(axis.place([-1.0])[0])
    assert ("1" in [text for _, text in axis.ticks()]) and len(axis.ticks()) == 7
    even = Axis(0.0, 0.72, 0.0, 100.0, logarithmic=False)
    assert [text for _, text in even.ticks()] == ["0", "0.2", "0.4", "0.6"] or len(
        even.ticks()
    ) >= 4
    given = Axis(0.0, 1.0, 0.0, 100.0, logarithmic=False, given=((0.5, "half"), (2.0, "out")))
    assert given.ticks() == [(50.0, "half")]


def test_ticks_of_a_logarithmic_axis_are_numbers_that_people_read():
    for low, high, least in ((0.3, 12.0, 4), (0.011, 0.9, 5), (1e-3, 1e3, 6)):
        axis = logarithmic(low, high)
        shown = [t for t in axis["tickvals"] if low <= t <= high]
        assert least <= len(shown) <= 8
        assert [float(t) for t in axis["ticktext"]] == pytest.approx(axis["tickvals"])
        assert axis["range"] == pytest.approx([np.log10(low), np.log10(high)])
    bars = {"y": np.array([1.0, np.nan]), "error_y": {"array": [9.0, 0], "arrayminus": [0.5, 0]}}
    begin, end = room_for([bars, {"y": np.array([0.0, 3.0])}])["range"]
    assert 10.0**begin < 0.5 and 10.0**end > 10.0
    assert "range" not in room_for([{"y": np.zeros(2)}])


def test_short_faults_can_be_seen_on_the_timeline(clean_mp):
    long, short = clean_mp["S7"].recording, clean_mp["S1"].recording.cut(0.0, 60.0)
    fault = Fault(FaultKind.GAP, 10.0, 10.1, 0)
    runs = [
        SimpleNamespace(recording=replace(r, faults=(fault,)), name=r.name) for r in (long, short)
    ]
    figure = timeline(runs)
    x = np.asarray(figure["data"][1]["x"])
    assert np.diff(x)[[0, 3]] == pytest.approx(long.duration / 150, abs=1e-9)


def test_names_in_figures_cannot_become_markup():
    text = svg(
        figure([line("</svg><script>", np.arange(2.0), np.arange(2.0), "#000")] * 2, "x", "y")
    )
    assert "<script" not in text
    assert "</svg><script>" in texts(text)


def test_csv_has_the_models_numbers_in_full(written):
    model, out = written
    with (out / "tables" / "coefficients.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["coefficient"] for row in rows] == list(model.values)
    for row in rows:
        value, error = model.values[row["coefficient"]], model.standard_errors[row["coefficient"]]
        assert float(row["value"]) == pytest.approx(value, rel=1e-9)
        assert float(row["standard error"]) == pytest.approx(error, rel=1e-9)
        assert float(row["95 % interval from"]) == pytest.approx(value - 1.959964 * error, rel=1e-9)
        assert float(row["95 % interval to"]) == pytest.approx(value + 1.959964 * error, rel=1e-9)
    with (out / "tables" / "scores.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["group"] for row in rows] == ["S4-MP"] * 3 + ["S1-MP (seen)"] * 3
    assert rows[0]["unit"] == "cm/s"
    with (out / "tables" / "gains.csv").open() as file:
        seconds = [row["halved after [s]"] for row in csv.DictReader(file)]
        assert len(seconds) > 5 and all(not s or float(s) > 0 for s in seconds)


def test_latex_rows_are_as_long_as_their_head(written):
    _, out = written
    files = sorted((out / "tables").glob("*.tex"))
    assert {p.stem for p in files} == {p.stem for p in (out / "tables").glob("*.csv")}
    assert len(files) >= 10
    for path in files:
        text = path.read_text()
        columns = len(re.search(r"\\begin\{tabular\}\{(\w+)\}", text)[1])
        body = text.split(r"\midrule")[1].split(r"\bottomrule")[0]
        for row in filter(str.strip, body.split(r"\\")):
            if "multicolumn" not in row:
                assert row.count(" & ") == columns - 1, row
        assert text.count("$") % 2 == 0
        assert not re.search(r"[−–±²₀ᵤ]", text)


def test_cells_say_the_same_three_times():
    assert Number(0.123456, 3, 100.0).plain() == "12.3456"
    assert Number(0.123456, 3, 100.0).latex() == "$12.3$"
    assert Number(-1.5e-7, 2).latex() == r"$-1.5 \cdot 10^{-7}$"
    assert (
        "−0.200060" in Interval(-0.20006, -0.19994).html()
    )  # enough digits to tell the ends apart
    assert Interval(1.0, 2.0).ends() == ("1", "2")
    assert Name("X_uu").latex() == r"$X_{\mathrm{uu}}$"
    assert Name("edge_forward").latex() == r"edge\_forward"
    assert Unit("rad/m^2").latex() == "rad/m$^{2}$"
    assert Text("50 % of A&B_1").latex() == r"50 \% of A\&B\_1"
    assert Worded(120.0, "2 min").plain() == "120"
    assert known(None).plain() == known(float("nan")).plain() == between(None).plain() == ""
    assert known(float("nan")).html() == "–"


def test_a_column_of_sentences_among_numbers_stands_to_the_left_and_is_wrapped():
    rows = [[Text("a"), Number(1.0), Text("as long as a sentence is, and longer")],
            [Text("as long as a sentence is, and longer"), Number(2.0), Text("brief")]]  # fmt: skip
    table = Table("t", "T", ("scheme", "power", "why"), rows)
    assert re.findall(r"<t[hd][^>]*words[^>]*>(.*?)</t", table.html()) == [
        "why", "as long as a sentence is, and longer", "brief"
    ]  # fmt: skip
    assert r"\begin{tabular}{lrl}" in table.latex()
    assert "words" not in Table("t", "T", table.head, rows, numbers=False).html()
    assert "words" not in Table("t", "T", table.head, [[Text("a"), Number(1.0), Text("b")]]).html()


def test_a_group_heads_its_rows_in_every_form():
    table = Table("t", "T", ("a", "b"), [[Text("g")], [Text("x"), between((1.0, 2.0))]])
    assert table.csv() == "group,a,b from,b to\ng,x,1,2\n"
    assert r"\multicolumn{2}{l}{g} \\" in table.latex()
    assert '<th scope="rowgroup" colspan="2">g</th>' in table.html()
