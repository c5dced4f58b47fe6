# SPDX-License-Identifier: MIT
"""Reports of odd models and recordings in a real browser: whatever is missing, the page is whole."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import TABLE_II, make_model
from report_pages import DRAWN, RANGE, UNFOLD, Visit, needed

import seatrial
from seatrial.evaluation.comparison.compare import compare
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.report import write_report
from seatrial.report.comparison import write_comparison

pytestmark = needed


@pytest.fixture(scope="module")
def mallard(mp, paper_mp, paper_mp_model):
    """A boat with trials, and a model of it by the default method."""
    return mp, [trial.recording for trial in paper_mp.values()], paper_mp_model


def one_recording(boat):
    _, runs, model = boat
    return model, runs[-1:]


def twelve_recordings(boat):
    _, runs, model = boat
    cuts = [(r, start) for r in runs[:6] for start in (0.0, 95.0)]
    return model, [
        replace(r.cut(start, start + 60.0), name=f"{r.name}-{start:g}-and-a-long-name")
        for r, start in cuts
    ]


def bad_model(boat):
    vehicle, runs, _ = boat
    return make_model(vehicle, TABLE_II["MP"] | {"X_u": 5.0, "X_uu": 20.0}), runs[3:5]


def wrong_sign(boat):
    vehicle, runs, _ = boat
    return make_model(vehicle, TABLE_II["MP"] | {"Y_F": -0.26}, step=1 / 20), runs[3:5]


def nothing_estimated(boat):
    vehicle, runs, _ = boat
    model = make_model(vehicle, TABLE_II["MP"], step=1 / 20)
    return replace(model, covariance=np.zeros_like(model.covariance)), runs[-1:]


def papers_method(boat):
    vehicle, runs, _ = boat
    return seatrial.identify(runs[:3], vehicle, method="equation-error"), runs[2:4]


def commands_missing(boat):
    _, runs, model = boat
    whole = runs[-1]
    stamps = whole.commands.stamps
    keep = (stamps < whole.origin + 60e9) | (stamps > whole.origin + 90e9)
    commands = Signal(whole.commands.names, stamps[keep], whole.commands.values[keep])
    silent = make_recording("silent", whole.stamps, whole.eta, commands, timeout=1.0)
    return model, [silent, runs[3].cut(0.0, 0.9)]  # and one that is too short


ODD = (
    one_recording, twelve_recordings, bad_model, wrong_sign, nothing_estimated, papers_method,
    commands_missing,
)  # fmt: skip


@pytest.mark.parametrize("case", ODD, ids=lambda case: case.__name__)
def test_whatever_is_missing_the_page_is_whole(browser, mallard, tmp_path, case):
    path = tmp_path / "report.html"
    model, recordings = case(mallard)
    write_report(model, recordings, path)
    assert path.stat().st_size < 3e6
    whole_and_quiet(browser, path)


def test_two_models_side_by_side_are_drawn_and_zoom(browser, mallard, tmp_path):
    _, runs, model = mallard
    other, _ = papers_method(mallard)
    path = tmp_path / "compare.html"
    recordings = runs[3:5]
    write_comparison(model, other, recordings, compare(model, other, recordings), path)
    one = whole_and_quiet(browser, path, close=False)
    plot = one.wide()
    names = plot.locator(".legendtext").all_text_contents()
    assert names[:3] == ["measured", "A", "B"]
    bar = one.page.locator("details[open] .bar").first
    bar.get_by_role("button", name="whole run").click()
    end = recordings[0].duration
    assert plot.evaluate(RANGE) == pytest.approx([0.0, end], abs=0.01)
    one.context.close()
    assert one.complaints == []


def whole_and_quiet(browser, path, *, close=True):
    """Visit a page on a narrow and on a wide screen: all that is open is drawn, nothing sticks out."""
    for width in (390, 1280):
        one = Visit(browser, path, width=width)
        one.page.evaluate(UNFOLD)
        tall = one.page.evaluate("document.documentElement.scrollHeight")
        one.page.set_viewport_size({"width": width, "height": int(tall)})  # all in view
        one.until(DRAWN)
        assert one.page.locator(".plot[data-drawn]").count() > 5
        assert one.page.evaluate("document.documentElement.scrollWidth") == width
        if close or width == 390:
            one.context.close()
        assert one.requests == []
        assert one.complaints == []
    return one


def test_a_hostile_name_stays_text(browser, cse1, cse1_paper_model, tmp_path):
    name = '</script><img src="https://example.org/x.png" onerror="window.hit = 1"><b>x'
    path = tmp_path / "report.html"
    write_report(cse1_paper_model, [replace(cse1["run1"], name=name)], path)
    one = Visit(browser, path)
    one.wide()
    assert one.page.locator("#prediction summary b").first.inner_text() == name
    assert one.page.locator("img").count() == 0
    assert one.page.evaluate("window.hit") is None
    one.close()
