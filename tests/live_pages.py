# SPDX-License-Identifier: MIT
"""The live page of a fake session, open in a real browser."""

import pytest
import waiting
from live_states import FakeSession, shown_state
from test_report_accessibility import LAPTOP, PHONE

from seatrial.poolside.web.server import PageServer, Place


class Poolside:
    """A fake session, its server and one open page, with what the page asked for and complained about."""

    def __init__(self, browser, state, size, token=None):
        self.session = FakeSession(state)
        self.server = PageServer(Place(port=0, token=token))
        self.server.serve(self.session)
        width, height = size
        self.context = browser.new_context(
            viewport={"width": width, "height": height}, has_touch=size == PHONE
        )
        self.page = self.context.new_page()
        self.page.set_default_timeout(1e3 * waiting.PATIENCE)
        self.complaints, self.elsewhere = [], []
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self._asked(request.url))
        self.page.goto(self.server.url)

    def _asked(self, url):
        if not url.startswith(f"http://127.0.0.1:{self.server.port}/"):
            self.elsewhere.append(url)

    def until(self, script, argument=None):
        """Wait until a script's value is true."""
        return waiting.until(lambda: self.page.evaluate(script, argument), script)

    def shows(self, place, text):
        self.until(
            """([place, text]) => document.querySelector(place).innerText.replaceAll("\\u00a0", " ").includes(text)""",
            [place, text],
        )

    def plots(self):
        """Wait for the plots, which are drawn in view only; what is drawn above moves them out of it."""
        self.until(
            """() => {
                document.querySelector("#predictions").scrollIntoView();
                return document.querySelectorAll("#predictions .main-svg").length >= 3;
            }"""
        )
        self.page.evaluate("() => window.scrollTo(0, 0)")

    def close(self):
        self.context.close()
        self.server.__exit__()


@pytest.fixture
def opened_pages(browser):
    opened = []

    def go(state=None, size=LAPTOP, **settings):
        opened.append(
            Poolside(browser, shown_state() if state is None else state, size, **settings)
        )
        return opened[-1]

    yield go
    for one in opened:
        one.close()
        assert one.elsewhere == []
        assert one.complaints == []
