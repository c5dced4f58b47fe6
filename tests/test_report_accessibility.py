# SPDX-License-Identifier: MIT
"""Both pages are accessible: axe-core's rules in a browser, the keyboard, ten screens, verdicts in sight."""

from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from importlib.util import find_spec

import msgspec
import pytest
from report_pages import Visit, draw
from report_pages import needed as in_a_browser
from test_guide import CURRENT, LEVER, one_drive, tables

import seatrial
from seatrial.evaluation.comparison.compare import compare
from seatrial.report import write_report
from seatrial.report.comparison import write_comparison

pytestmark = needed = [
    *in_a_browser,
    pytest.mark.skipif(
        find_spec("axe_playwright_python") is None, reason="axe-playwright-python is not installed"
    ),
]
LAPTOP, PHONE = (1366, 768), (390, 844)  # [px]
COLOUR_RULES = ("color-contrast", "link-in-text-block")
MOST_SCREENS = 10  # before anything is unfolded
OPEN_ALL = "() => document.querySelectorAll('details').forEach((part) => { part.open = true; })"
OVERLAPS = """() => {
    const found = [], most = 1.5;  // [px] of two boxes, which are taller than their letters
    const boxes = (parts) => [...parts].map((part) => part.getBoundingClientRect());
    const common = (a, b) => Math.min(
        Math.min(a.right, b.right) - Math.max(a.left, b.left),
        Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));
    for (const plot of document.querySelectorAll(".plot")) {
        for (const kind of ["x", "y", "y2", "y3"]) {
            const ticks = boxes(plot.querySelectorAll(`.${kind}tick text`));
            if (ticks.some((a, i) => ticks.slice(0, i).some((b) => common(a, b) > most)))
                found.push(`${plot.dataset.figure}: ticks of ${kind}`);
        }
        const titles = boxes(plot.querySelectorAll(".ytitle, .y2title, .y3title"));
        const ran = (a, b) => Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 0;
        if (titles.some((a, i) => titles.slice(0, i).some((b) => ran(a, b))))
            found.push(`${plot.dataset.figure}: titles`);
    }
    return found;
}"""


@pytest.fixture(scope="module")
def pages(cse1, cse1_paper_model, tmp_path_factory):
    """A report, one of the guided path with effects, and a comparison of models of two recordings."""
    folder = tmp_path_factory.mktemp("pages")
    a = cse1_paper_model
    b = replace(a, coefficients=a.coefficients / 1.2)  # as of a fifth more mass
    b = replace(
        b, recordings=tuple(msgspec.structs.replace(r, name=f"{r.name}b") for r in b.recordings)
    )
    fresh = cse1["run1"]
    write_report(a, [fresh], folder / "report.html")
    write_comparison(a, b, [fresh], compare(a, b, [fresh]), folder / "compare.html")
    write_comparison(a, b, [], compare(a, b, []), folder / "changes.html")
    drive = tables(folder / "lake", one_drive(seconds=240.0), lever=LEVER, current=CURRENT)
    guided = seatrial.auto([drive], folder / "guided").report
    return {"guided": guided} | {
        name: folder / f"{name}.html" for name in ("report", "compare", "changes")
    }


@contextmanager
def visits(browser, pages):
    """Opens pages, which ask for nothing."""
    opened = []

    def go(page, size=LAPTOP):
        width, height = size
        one = Visit(browser, pages[page], width=width, height=height, touch=size == PHONE)
        opened.append(one)
        return one.page

    yield go
    for one in opened:
        one.close()


@pytest.fixture
def visit(browser, pages):
    with visits(browser, pages) as go:
        yield go


@pytest.fixture(scope="module")
def drawn(browser, pages):
    """Opens a page, all unfolded and every plot drawn, once."""
    with visits(browser, pages) as go:

        @cache
        def opened(name, size=LAPTOP):
            page = go(name, size)
            page.evaluate(OPEN_ALL)
            for plot in page.locator(".plot").all():
                draw(plot)
            page.evaluate("() => window.scrollTo(0, 0)")
            return page

        yield opened


def violations(page, rules=()):
    """Of all rules, or of some."""
    from axe_playwright_python.sync_playwright import Axe

    options = {"resultTypes": ["violations"]}
    if rules:
        options["runOnly"] = {"type": "rule", "values": list(rules)}
    found = Axe().run(page, options=options).response
    assert len(found["passes"]) > (0 if rules else 20), "axe-core did not look at the page"
    return {v["id"]: [n["html"][:200] for n in v["nodes"]] for v in found["violations"]}


@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
@pytest.mark.parametrize("name", ["report", "compare"])
def test_no_rule_of_axe_core_fails(drawn, name, size):
    page = drawn(name, size)
    assert violations(page) == {}
    if size == LAPTOP:  # colours do not depend on the size, nothing else on the scheme
        page.emulate_media(color_scheme="dark")
        assert page.evaluate("() => getComputedStyle(document.body).color") == "rgb(232, 234, 237)"
        assert violations(page, COLOUR_RULES) == {}
        page.emulate_media(color_scheme="light")


def test_axe_core_finds_what_is_wrong(visit):
    page = visit("report")
    page.evaluate("() => { document.querySelector('.lead').style.color = '#ddd'; }")
    assert "color-contrast" in violations(page)


@pytest.mark.parametrize("name", ["report", "compare", "changes"])
def test_the_first_screen_has_picture_dials_and_next_step(visit, name):
    for width, height in (LAPTOP, PHONE):
        page = visit(name, (width, height))
        page.locator(".plot.picture .main-svg").first.wait_for(state="visible")
        ends = page.evaluate(
            """() => [".plot.picture", ".dials", ".next"].map((part) =>
                document.querySelector(part).getBoundingClientRect().bottom)"""
        )
        assert max(ends) < height, (width, ends)
        assert page.locator(".dial svg[role=img]").count() == 3
        for dial in page.locator(".dial svg").all():
            assert len(dial.get_attribute("aria-label")) > 10
        assert page.evaluate("() => document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("name", ["report", "compare", "changes"])
def test_no_label_of_a_plot_runs_into_another_on_a_phone(drawn, name):
    """Ticks of an axis, and the titles of the panels that are one above the other."""
    page = drawn(name, PHONE)
    pictured = page.evaluate(
        """() => [...document.querySelectorAll(".plot.picture .ytick text")].map((d) => d.textContent)"""
    )
    assert len(pictured) >= 3
    assert page.evaluate(OVERLAPS) == []


@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
@pytest.mark.parametrize("name", ["report", "guided", "compare"])
def test_a_page_is_at_most_ten_screens_long(visit, name, size):
    page = visit(name, size)
    tall = page.evaluate("() => document.documentElement.scrollHeight")
    assert tall <= MOST_SCREENS * size[1]
    assert page.locator("details.fold:not([open])").count() >= 5
    on_a_phone = page.locator("details.narrow")
    assert on_a_phone.count() == 2
    assert page.locator("details.narrow[open]").count() == (0 if size == PHONE else 2)


def test_every_plot_has_a_legend(drawn):
    for name in ("report", "compare"):
        without = drawn(name).evaluate(
            """() => [...document.querySelectorAll(".plot")].filter((div) => !div.querySelector(".legend .traces"))
                .map((div) => div.dataset.figure)"""
        )
        assert without == []


def test_a_folded_section_opens_by_key_and_by_its_link(visit):
    page = visit("report")
    handle = page.locator("#scores > details > summary")
    handle.focus()
    page.keyboard.press("Enter")
    assert page.locator("#scores > details[open]").count() == 1
    page.keyboard.press("Enter")
    assert page.locator("#scores > details[open]").count() == 0
    page.locator('nav a[href="#provenance"]').focus()
    page.keyboard.press("Enter")
    page.locator("#provenance > details[open]").wait_for(state="attached")


def test_names_and_verdicts_stay_in_sight_on_a_phone(visit):
    page = visit("report", PHONE)
    page.evaluate(OPEN_ALL)
    box = page.locator(".scroll:has(> table.coefficients)")
    box.evaluate("(box) => box.scrollIntoView()")
    places = """(box) => { box.scrollLeft = SHIFT; const whole = box.getBoundingClientRect();
        return [...box.querySelectorAll("tbody tr:first-child > :is(th, td.verdict)")].map((cell) => {
            const own = cell.getBoundingClientRect();
            return [own.left - whole.left, whole.right - own.right]; }); }"""
    room = box.evaluate("(box) => box.scrollWidth - box.clientWidth")
    assert room > 50, "the table does not scroll"
    for shift in (0, room // 2, room):
        (name_left, _), (_, verdict_right) = box.evaluate(places.replace("SHIFT", f"{shift}"))
        assert name_left == pytest.approx(0.0, abs=1.0)
        assert verdict_right >= -1.0
        if shift == 0:  # further columns are hidden, the verdict is not
            assert verdict_right == pytest.approx(0.0, abs=1.0)
