# SPDX-License-Identifier: MIT
"""The report as a page: of any model, with harmless names, written whole or not at all."""

import json
import re
from dataclasses import replace

import msgspec
import pytest
from conftest import at_length
from html_tables import Tables
from test_report import boat

import seatrial
from seatrial.boat.schema import EQUATION_ERROR as PAPERS
from seatrial.identification.methods import METHODS
from seatrial.report import report, write_report
from seatrial.report.figures.embed import pack
from seatrial.report.text.names import html_symbol, mathml_symbol, sentence
from seatrial.util.errors import FileError, RecordingError

HOSTILE = '</script><b onclick="x()">&amp;'


@pytest.fixture(scope="module")
def model(cse1_paper_model):
    return cse1_paper_model


@pytest.fixture(scope="module")
def part(cse1) -> seatrial.Recording:
    """A minute of the ship, where it matters little what the report is of."""
    return cse1["run1"].cut(0.0, 60.0)


@pytest.fixture(scope="module")
def surge(clean_af) -> seatrial.Recording:
    """A minute in which little but surge is driven."""
    return clean_af["S4"].recording.cut(0.0, 60.0)


@pytest.mark.parametrize(
    "method", [m if m == "weak-form" else at_length(m) for m in METHODS if m != PAPERS]
)
def test_a_model_of_another_method_is_told_without_the_papers_caution(method, paper_af, af):
    records = [paper_af[s].recording.cut(0.0, 100.0) for s in ("S1", "S2", "S3")]
    other = seatrial.identify(records, af, method=method)
    text = report(other, [records[0].cut(0.0, 60.0), paper_af["S7"].recording.cut(0.0, 60.0)])
    shown = Tables(text).found
    assert len(shown.get("steps", [])) == bool(other.estimator.steps)
    (rows,) = shown["constants"]
    assert [row[0][0] for row in rows[1:]] == list(other.vehicle.constants.names)
    assert [row[1][1] for row in rows[1:]] == [pytest.approx([v]) for v in other.constants.tolist()]
    assert f"identified by {method} from 3 recordings" in text
    assert "covers scatter only" not in text


def test_warnings_and_the_sanity_line_are_shown(model, part):
    warned = replace(model, warnings=("N_rr < 0 & so on",))
    text = report(warned, [part])
    assert '<p class="warning"><i>N</i><sub>rr</sub> &lt; 0 &amp; so on</p>' in text
    assert re.search(r'<p class="sanity">Implied top speed [\d.]+ m/s in surge', text)


def test_an_unstable_model_gets_a_report_that_says_so(af, surge):
    wild = boat(af, X_u=5.0, X_uu=20.0)
    text = report(wild, [surge])
    assert "It can&#x27;t be used: mallard: the model is unstable" in text
    assert "Next: do not use this model" in text
    assert "no prediction" in text
    assert 'id="recorded"' in text
    assert 'id="scores"' not in text


def test_a_physical_doubt_is_a_warning_whoever_made_the_model(af, surge):
    odd = boat(af, X_u=0.05)
    assert odd.warnings == ()
    text = report(odd, [surge])
    assert re.search(r'<p class="warning">[^<]*<i>X</i><sub>u</sub> = 0.05', text)


def test_names_cannot_become_markup(model, part, cse1_vehicle):
    file = msgspec.structs.replace(cse1_vehicle.file, name=HOSTILE)
    vehicle = seatrial.Vehicle(file)
    hostile = replace(
        model.with_vehicle(vehicle), warnings=(HOSTILE,),
        recordings=tuple(msgspec.structs.replace(r, name=HOSTILE) for r in model.recordings),
    )  # fmt: skip
    text = report(hostile, [replace(part, name=HOSTILE)])
    assert "<b onclick" not in text
    assert text.count("</script>") == text.count("<script") == 4
    assert text.count("&lt;/script&gt;&lt;b onclick=&quot;x()&quot;&gt;&amp;amp;") >= 6
    shown = json.loads(re.search(r'id="all">(.*?)</script>', text, re.DOTALL)[1])["figures"]
    assert not any("<b" in str(figure) for figure in shown.values())


def test_force_names_cannot_become_markup():
    figure = json.loads(pack({"a": {"name": "</script><b>"}}))
    assert figure["figures"]["a"]["name"] == "</script><b>"
    assert "<" not in pack({"a": {"name": "</script><b>"}})
    assert html_symbol("F_<b>") == "<i>F</i><sub>&lt;b&gt;</sub>"
    assert "<b>" not in mathml_symbol("F_<b>") + sentence("F_<b> <b>", ["F_<b>"])


def test_no_recording_is_an_error(model):
    with pytest.raises(RecordingError, match="pass at least one"):
        report(model, [])


def test_write_report_writes_whole_or_not_at_all(model, part, tmp_path):
    """And the same report for the same input."""
    path, text = tmp_path / "deep" / "report.html", report(model, [part])
    write_report(model, [part], path)
    assert path.read_text(encoding="utf-8") == text
    (tmp_path / "file").write_text("kept")
    with pytest.raises(FileError):
        write_report(model, [part], tmp_path / "file" / "report.html")
    with pytest.raises(RecordingError):
        write_report(model, [part.cut(0, 1)], path)
    assert path.read_text(encoding="utf-8") == text
    assert [p.name for p in path.parent.iterdir()] == ["report.html"]
