# SPDX-License-Identifier: MIT
"""The report in a real browser: it draws, zooms, fits a phone, prints, and asks for nothing."""

import re

import pytest
from report_pages import RANGE, WIDE, Visit, draw, needed

from seatrial.report import write_report

pytestmark = needed
PLOTS = 19  # of a recording: its track, and six for each axis
OVERALL = 18  # of all together: 1 picture, 1 of what is known, 2 of actuators, 2 + 3 of what was recorded,
# 3 horizons, 2 of whether recordings agree, 3 of the boat, 1 of the next drive


@pytest.fixture(scope="module")
def path(cse1, cse1_paper_model, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(cse1_paper_model, [cse1["random_run3"], cse1["run1"]], path)
    return path


@pytest.fixture
def visit(browser, path):
    opened = []

    def open_report(**settings):
        opened.append(Visit(browser, path, **settings))
        return opened[-1]

    yield open_report
    for one in opened:
        one.close()


def test_every_plot_is_drawn_when_it_comes_into_view(visit):
    page = (one := visit()).page
    assert page.locator(".plot").count() == 2 * PLOTS + OVERALL
    assert page.locator("details.run[open]").count() == 3
    assert page.locator(".plot[data-drawn]").count() < 5  # those on the first screen
    page.get_by_role("button", name="open all").click()
    assert page.locator("details.run[open]").count() == 6
    for plot in page.locator(".plot").all():
        draw(plot)
    one.until("() => [...document.querySelectorAll('.plot')].every(d => d.querySelector('.trace'))")
    for plot in page.locator(".plot").all():
        titles = [plot.locator(f".{k}title").all_text_contents() for k in "xy"]
        named = plot.locator(".ytick").first.text_content() or ""
        words = re.search(r"[a-zA-Z]", named.replace("e", "")) is not None  # rows have names
        assert any("[" in title for title in (*titles[0], *titles[1])), titles
        assert words or any("[" in title for title in titles[1]), titles
    page.get_by_role("button", name="close all").click()
    assert page.locator("details.run[open]").count() == 0


def test_dragging_zooms_all_three_time_axes(visit):
    one = visit()
    plot = one.wide()
    start, end = plot.evaluate(RANGE)
    assert end - start == pytest.approx(40.0)
    box = plot.locator(".nsewdrag.drag").first.bounding_box()
    y = box["y"] + box["height"] / 2
    one.page.mouse.move(box["x"] + 0.25 * box["width"], y)
    one.page.mouse.down()
    one.page.mouse.move(box["x"] + 0.5 * box["width"], y, steps=5)
    one.page.mouse.up()
    one.until(f"() => {{ const r = ({RANGE})(document.querySelector('details[open] {WIDE}')); "
              "return r[1] - r[0] < 12; }")  # fmt: skip
    zoomed = plot.evaluate(RANGE)
    assert zoomed[0] == pytest.approx(start + 10, abs=0.5)
    assert zoomed[1] == pytest.approx(start + 20, abs=0.5)
    one.until(
        """([begin, end]) => [...document.querySelectorAll('details[open] .plot.wide')]
        .filter(d => d.layout).every(d => Math.abs(d.layout.xaxis.range[0] - begin) < 1e-6
                                       && Math.abs(d.layout.xaxis.range[1] - end) < 1e-6)""",
        zoomed,
    )
    lower = one.page.locator('details[open] .plot.wide[data-figure="velocity-r"]')
    draw(lower)  # one that was drawn only after the zoom follows too
    lower.locator(".trace").first.wait_for(state="attached")
    assert lower.evaluate(RANGE) == pytest.approx(zoomed)


def test_buttons_show_the_whole_run_and_forty_seconds(visit, cse1):
    one = visit()
    plot = one.wide()
    home = plot.evaluate(RANGE)
    bar = one.page.locator("details[open] .bar")

    def press(name):
        bar.get_by_role("button", name=name).click()
        return plot.evaluate(RANGE)

    assert press("whole run") == pytest.approx([0.0, cse1["run1"].duration], abs=0.01)
    assert press("later") == pytest.approx([0.0, cse1["run1"].duration], abs=0.01)
    assert press("40 s") == pytest.approx(home)
    later = press("later")
    assert later == pytest.approx([home[0] + 32, home[1] + 32])
    assert press("earlier") == pytest.approx(home)
    for _ in range(8):
        first = press("earlier")
    assert first == pytest.approx([0.0, 40.0])


def test_double_click_shows_the_whole_run(visit, cse1):
    one = visit()
    box = one.wide().locator(".nsewdrag.drag").first.bounding_box()
    one.page.mouse.dblclick(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    one.until(f"() => {{ const r = ({RANGE})(document.querySelector('details[open] {WIDE}')); "
              f"return r[1] > {cse1['run1'].duration - 1}; }}")  # fmt: skip


@pytest.mark.parametrize("touch", [True, False])
def test_a_phone_has_no_horizontal_scroll(visit, touch):
    one = visit(width=390, height=844, touch=touch)
    one.page.get_by_role("button", name="open all").click()
    for plot in one.page.locator(".plot").all():
        draw(plot)
        box = plot.locator(".main-svg").first.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 390
    assert one.page.evaluate("document.documentElement.scrollWidth") == 390
    rows = "[...document.querySelectorAll('tbody tr')].map(d => d.clientHeight)"
    assert max(one.page.evaluate(rows)) < 150  # [px] no cell is squeezed to a word a line


@pytest.mark.parametrize("width", [1280, 390])
def test_equations_are_drawn_as_mathematics(visit, cse1_vehicle, width):
    """MathML, with indices below and dots above; lines break between terms on a phone."""
    page = visit(width=width).page
    drawn = page.evaluate("""() => [...document.querySelectorAll('.equation math')].map(d => {
        const box = d.getBoundingClientRect();
        return [d.namespaceURI, box.height, box.left, box.right]; })""")
    assert len(drawn) == 2 * (3 + len(cse1_vehicle.structure.terms))
    for space, height, left, right in drawn:
        assert space.endswith("MathML")
        assert height > 6  # [px]
        assert 0 < left < right < width
    ends = """name => [...document.querySelectorAll(name)].map(d =>
        [...d.children].map(c => c.getBoundingClientRect()).flatMap(b => [b.top, b.bottom]))"""
    for _, bottom, _, below in (found := page.evaluate(ends, ".equation msub")):
        assert below > bottom + 1
    assert len(found) > 20
    for top, _, above, under in (found := page.evaluate(ends, ".equation mover")):
        assert above < under <= top + 1
    assert len(found) >= 6
    tall = page.evaluate("[...document.querySelectorAll('.equation')].at(-1).clientHeight")
    assert (tall > 60) == (width == 390)  # several lines
    copied = page.locator(".equations pre").first.text_content()
    assert copied.startswith("u_dot = v r + X_u u")


def test_dark_follows_the_system_and_back(visit):
    one = visit(scheme="dark")
    plot = one.wide()
    line = plot.locator(".scatterlayer .js-line").first
    colour = "e => getComputedStyle(e).stroke"
    assert line.evaluate(colour) == "rgb(242, 242, 242)"
    one.page.emulate_media(color_scheme="light")
    one.until("() => getComputedStyle(document.querySelector("
              f"'details[open] {WIDE} .scatterlayer .js-line')).stroke === 'rgb(0, 0, 0)'")  # fmt: skip


def test_printing_draws_every_plot_in_light_colours_and_restores_the_page(visit, tmp_path):
    one = visit(scheme="dark")
    page = one.page
    page.evaluate("""() => addEventListener('beforeprint', () => {
        window.seen = {
            drawn: [...document.querySelectorAll('.plot')].filter(d => d.querySelector('.trace')).length,
            open: document.querySelectorAll('details.run[open]').length,
            width: Math.max(...[...document.querySelectorAll('.plot .main-svg')].map(d => d.clientWidth)),
            table: Math.max(...[...document.querySelectorAll('table')]
                .filter(d => !d.closest('.fine, .files')).map(d => d.getBoundingClientRect().right)),
            colour: getComputedStyle(document.querySelector('.plot.wide .js-line')).stroke };
    })""")
    page.pdf(path=str(tmp_path / "report.pdf"), prefer_css_page_size=True)
    seen = page.evaluate("window.seen")
    assert seen["drawn"] == 2 * PLOTS + OVERALL
    assert seen["open"] == 6
    assert seen["width"] <= 690  # [px] 182 mm, what A4 leaves between its margins
    assert seen["table"] <= 690
    assert seen["colour"] == "rgb(0, 0, 0)"
    assert page.locator("details.run[open]").count() == 3
    assert page.locator("body.printing").count() == 0


def test_the_policy_stops_requests_that_a_script_would_make(visit):
    one = visit()
    outcome = one.page.evaluate(
        "() => fetch('https://example.org/').then(() => 'went out', () => 'refused')"
    )
    assert outcome == "refused"
    assert any("Content Security Policy" in text for text in one.complaints)
    one.complaints.clear()
