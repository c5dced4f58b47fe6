# SPDX-License-Identifier: MIT
"""The live page and its connection: lost, silent, found again, ended; and the token that opens it."""

from live_pages import opened_pages
from test_report_accessibility import needed

from seatrial.poolside.web.server import PageServer, Place

pytestmark = needed
visit = opened_pages  # a fixture


def test_a_server_that_says_nothing_is_a_lost_connection(visit, monkeypatch):
    """A phone that left the network gets no end of the connection; a session at rest sends beats."""
    one = visit()
    one.shows("#order", "Drive backwards")
    one.page.evaluate("() => { window.began = performance.now(); }")
    one.until("() => performance.now() - window.began > 7000")  # longer than a page waits
    assert one.page.locator("#connection").inner_text() == "connected"
    monkeypatch.setattr("seatrial.poolside.web.app._sent", _kept_back)
    one.shows("#connection", "connection lost; what is shown is old")
    one.shows("#order", "What is shown is old. Check seatrial and the network.")
    monkeypatch.undo()
    one.shows("#order", "Drive backwards")


async def _kept_back(*_):
    return True


def test_the_link_to_the_report_is_there_as_long_as_it_is_served(visit):
    one = visit()
    one.shows("#connection", "connected")
    assert one.server.connected
    one.session.set(stopped=True, saved=(("recording", "r"), ("report", "r/report.html")))
    one.shows("#why", "open the report")
    one.server.__exit__()
    one.shows("#connection", "seatrial has ended")
    one.shows("#why", "report r/report.html")
    assert one.page.locator("#why a").count() == 0


def test_a_lost_connection_is_stated_and_found_again(visit):
    one = visit()
    one.shows("#connection", "connected")
    port = one.server.port
    one.server.__exit__()
    one.shows("#connection", "connection lost")
    one.page.locator("#mark").click()
    one.shows("#answer", "nothing was done")
    one.server = PageServer(Place(port=port))
    one.server.serve(one.session)
    one.session.set(time=99.0)
    one.shows("#connection", "connected")
    one.shows("#facts", "99 s")
    assert one.session.calls == []
    one.complaints = [text for text in one.complaints if "ERR_CONNECTION_REFUSED" not in text]


def test_a_token_opens_the_page_and_leaves_the_address(visit):
    one = visit(token="correct-horse-battery")
    one.shows("#connection", "connected")
    assert one.page.url == f"http://127.0.0.1:{one.server.port}/"
    one.page.reload()
    one.shows("#connection", "connected")
    cookies = one.context.cookies()
    assert [(c["sameSite"], c["httpOnly"]) for c in cookies] == [("Strict", True)]
