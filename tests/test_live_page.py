# SPDX-License-Identifier: MIT
"""The live page in a real browser, on a laptop and on a phone: drawn, updated, its buttons, its accessibility."""

import re
import time

import pytest
from live_pages import opened_pages
from msgspec.structs import replace
from test_report_accessibility import LAPTOP, PHONE, needed, violations

from seatrial.poolside.state import ParameterState, SignalState, UseState

pytestmark = needed
INK = """() => { const c = document.querySelector("#pool"), copy = document.createElement("canvas");
    [copy.width, copy.height] = [c.width, c.height];
    const pen = copy.getContext("2d", { willReadFrequently: true });
    pen.drawImage(c, 0, 0); const d = pen.getImageData(0, 0, c.width, c.height).data; let n = 0;
    for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return n; }"""


visit = opened_pages  # a fixture


@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_everything_is_drawn(visit, size):
    one = visit(size=size)
    one.shows("#order", "Drive backwards at 60 %, then turn to port.")
    one.shows(
        "#why", "12 s, for X_uu: ± 0.21 now, ± 0.12 expected. Least distance from the walls 0.35 m."
    )
    assert one.page.locator("#sticks li").all_inner_texts() == [
        "0–6 s\nF_u −60 %", "6–12 s\nF_u −60 % · F_r +40 %",
    ]  # fmt: skip
    assert one.page.locator("h1").inner_text() == "model ship: live"
    assert one.page.locator("#parameters tr").count() == 5
    assert one.page.locator("#parameters tr").nth(3).locator("td").last.inner_text() == "✓ known"
    one.shows("#signals", "The boat turns to the other side than F_r states.")
    one.shows("#signals", "F_r: {column: rudder, sign: -1}")
    assert one.page.locator(".heat").count() == 3
    fastest = one.page.locator(".heat").first.locator("tbody tr").first.locator("td")
    assert fastest.all_inner_texts() == ["", "3", "6", "9", "12"]
    one.shows("#uses", "simulation: not fit")
    one.shows("#uses", "30 % of what is needed is known. Y_v is 5 times too wide.")
    one.plots()
    one.until("() => document.querySelectorAll('#sticks-plot .main-svg').length >= 1")
    assert one.until(INK) > 2000
    one.shows("#marks", "touched the wall")
    assert one.page.evaluate("() => document.documentElement.scrollWidth") <= size[0]


@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_what_to_do_now_is_readable_from_two_metres(visit, size):
    """On a laptop of 0.25 mm a pixel capitals (0.7 em) of 50 px are 9 mm: 15 minutes of arc at two metres."""
    one = visit(size=size)
    one.shows("#order", "Drive backwards")
    box, letters = one.page.evaluate(
        """() => { const place = document.querySelector("#order");
            return [place.getBoundingClientRect().bottom, parseFloat(getComputedStyle(place).fontSize)]; }"""
    )
    assert letters >= (50 if size == LAPTOP else 28)  # [px]
    assert box < size[1] / 2
    stop = one.page.locator("#stop").bounding_box()
    assert stop["y"] + stop["height"] <= size[1]  # without scrolling


def test_the_page_follows_the_session(visit):
    one = visit()
    one.shows("#facts", "42 s, 38 s driven, 2100 poses")
    before = one.until(INK)
    one.session.rows += [(24.0 + 0.2 * i, 0.5 + 0.01 * i, -1.0, 0.0) for i in range(100)]
    one.session.set(time=61.0, pose=(1.4, -1.0, 0.0), next=None, lag=3.4)
    one.shows("#facts", "61 s, 38 s driven, 2100 poses, estimate 3.4 s behind")
    one.until("() => document.documentElement.dataset.shown === '61'")
    assert one.page.evaluate(INK) != before
    one.shows("#order", "Drive: forwards and backwards")
    assert not one.page.locator("#sticks-plot").is_visible()
    one.session.set(message="9 s of poses so far: the first estimate needs 15 s or more.")
    one.shows("#order", "the first estimate needs 15 s")
    one.session.set(enough=True, message="")
    one.shows("#order", "Enough for the chosen uses. Press stop and save.")
    one.session.set(change="boat changed (noticed): mass, +20 ± 5 %")
    one.shows("#change", "boat changed (noticed): mass, +20 ± 5 %")
    wrong = SignalState(
        "F_u", "command", 3, level="error", finding="No command for 8 s.", edit="sign: -1"
    )
    one.session.set(signals=(wrong,))
    one.shows("#order", "F_u: No command for 8 s.")
    assert one.page.locator("#now").get_attribute("class") == "mend"


@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_buttons_mark_discard_and_save(visit, size):
    one = visit(size=size)
    one.shows("#connection", "connected")
    if size == LAPTOP:
        one.page.locator("#mark-text").fill("gust")
    one.page.locator("#mark").click()
    one.shows("#answer", "marked")
    one.page.locator("#seconds").fill("7")
    one.page.locator("#discard").click()
    one.shows("#answer", "the last 7 s are discarded")
    one.page.locator("#seconds").fill("99")
    one.page.locator("#discard").click()
    one.shows("#answer", "only 42 s are recorded")
    one.session.saving = 1.0
    one.page.locator("#stop").click()
    one.shows("#order", "Wait: identifying (40 %)")
    assert one.page.locator("#discard").is_disabled()
    one.shows("#order", "Saved")
    one.shows("#why", "recording pool-1/recording")
    one.shows("#answer", "saved")
    text = "gust" if size == LAPTOP else ""
    assert one.session.calls == [("mark", text), ("discard", 7.0), ("stop", None)]
    # the refused discard is a complaint of the browser's own: the answer's status
    one.complaints = [text for text in one.complaints if "409" not in text]


def test_an_estimate_has_the_decimals_of_its_interval_and_a_reason_is_a_sentence(visit):
    """2.0047 ± 0.0018 is not 2.00 ± 0.0018, whose interval does not hold the estimate."""
    one = visit()
    found = [
        ("N_F", "rad/s^2", 2.00472, 0.00093),
        ("X_u", "1/s", -0.352, 0.1),
        ("Y_v", "1/s", -31.4, 9.0),
    ]
    one.session.set(
        parameters=tuple(ParameterState(*given, 0.1, True) for given in found),
        uses=(UseState("control", "not fit", "there is no model yet", 0.0),),
    )
    one.shows("#uses", "0 % of what is needed is known. There is no model yet.")
    cells = one.page.locator("#parameters td:nth-child(2)").all_inner_texts()
    assert cells == ["2.0047 ± 0.0018 rad/s²", "−0.35 ± 0.20 1/s", "−31 ± 18 1/s"]


def test_a_long_finding_leaves_room_for_the_pool_on_a_phone(visit):
    """What was found is readable from two metres; what to do about it stands below."""
    found, advice = (
        "the heading has another zero: with psi = heading - 90 deg the track agrees with it",
        "lines are wrong; correct them",
    )
    one = visit(size=PHONE)
    wrong = SignalState(
        "pose", "pose", 3, level="error", finding=f"{found}; {advice}", edit="psi: {offset: 90}"
    )
    one.session.set(signals=(wrong,))
    one.shows("#order", f"pose: {found}")
    assert "correct" not in one.page.locator("#order").inner_text()
    assert (
        one.page.locator("#why").inner_text()
        == "Lines are wrong; correct them. Vehicle file: psi: {offset: 90}"
    )
    box = one.page.locator("#now").bounding_box()
    assert box["y"] + box["height"] < PHONE[1] / 2
    for text, large, below in (
        ("yaw rates of 35.1 rad/s: is psi in degrees? State unit: deg",
         "pose: yaw rates of 35.1 rad/s: is psi in degrees?", "State unit: deg."),
        ("a gap of 1.5 s. Keep the boat in view", "pose: a gap of 1.5 s.", "Keep the boat in view."),
        ("No command for 8 s.", "pose: No command for 8 s.", ""),
    ):  # fmt: skip
        one.session.set(signals=(replace(wrong, finding=text, edit=""),))
        one.shows("#order", large)
        assert one.page.locator("#order").inner_text() == large
        assert one.page.locator("#why").inner_text() == below


def test_a_mark_leaves_its_field_empty_and_no_number_discards_nothing(visit):
    one = visit()
    one.shows("#connection", "connected")
    one.page.locator("#mark-text").fill("gust")
    one.page.locator("#mark").click()
    one.until("() => document.querySelector('#mark-text').value === ''")
    one.page.locator("#seconds").fill("")
    one.page.locator("#discard").click()
    one.shows("#answer", "nothing was discarded: give a number of seconds")
    assert one.session.calls == [("mark", "gust")]


def test_the_session_is_driven_by_keys_alone(visit):
    one = visit()
    one.shows("#order", "Drive backwards")
    reached = []
    for _ in range(12):
        one.page.keyboard.press("Tab")
        reached.append(one.page.evaluate("() => document.activeElement.id"))
    assert [name for name in reached if name][:6] == [
        "drive", "mark", "mark-text", "discard", "seconds", "stop",
    ]  # fmt: skip
    one.page.locator("#mark").focus()
    one.page.keyboard.press("Enter")
    one.shows("#answer", "marked")
    assert one.session.calls == [("mark", "")]


def test_the_countdown_keeps_one_manoeuvre(visit):
    one = visit()
    one.shows("#order", "Drive backwards")
    one.page.locator("#drive").click()
    one.shows("#now-title", "GET READY")
    one.session.set(next=None)
    one.shows("#order", "F_u −60 %")  # after three seconds
    assert one.page.locator("#sticks .current").count() == 1
    assert re.fullmatch(r"DRIVE NOW, 1[0-2] S LEFT", one.page.locator("#now-title").inner_text())
    one.page.locator("#drive").click()
    one.shows("#order", "Drive: forwards")


@pytest.mark.parametrize("size", [LAPTOP, PHONE], ids=["laptop", "phone"])
def test_no_rule_of_axe_core_fails(visit, size):
    one = visit(size=size)
    one.plots()
    assert violations(one.page) == {}
    one.page.emulate_media(color_scheme="dark")
    one.until("() => getComputedStyle(document.body).color === 'rgb(232, 234, 237)'")
    assert violations(one.page) == {}
    for state in ({"enough": True}, {"message": "too short"}, {"stopped": True}):
        one.session.set(next=None, **state)
        one.until("() => !document.querySelector('#sticks').childElementCount")
        assert violations(one.page) == {}


def test_names_of_a_log_are_text(visit):
    evil = "<img src=x onerror=\"document.title='taken'\">"
    one = visit()
    one.session.set(
        vehicle=evil, inputs=(evil, "<b>F</b>"), source=evil, message=evil, change=evil,
        marks=((1.0, evil),), signals=(SignalState(evil, "pose", 1, level="warning", finding=evil, edit=evil),),
    )  # fmt: skip
    one.shows("#marks", "onerror")
    one.shows("#signals", "onerror")
    one.shows("#sticks", "<b>F</b>")
    time.sleep(0.5)
    assert one.page.locator("img").count() == 0
    assert one.page.title() != "taken"
