# SPDX-License-Identifier: MIT
"""A real browser, and a report that is open in it."""

import shutil
import time
from importlib.util import find_spec

import pytest
import waiting

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
needed = [
    pytest.mark.system,
    pytest.mark.skipif(find_spec("playwright") is None, reason="playwright is not installed"),
    pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed"),
]
DRAWN = """() => [...document.querySelectorAll('.plot')].filter(d => !d.closest('details:not([open])'))
    .every(d => d.querySelector('.main-svg'))"""
UNFOLD = "() => document.querySelectorAll('details.fold').forEach((part) => { part.open = true; })"
ARGUMENTS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
WIDE = '.plot.wide[data-figure="velocity-u"]'
PATIENCE = 120_000  # [ms] a machine that tests other things beside is slow
RANGE = "div => div.layout.xaxis.range"


IN_VIEW = "(part) => { part.scrollIntoView({ block: 'center' }); return part.querySelector('.main-svg') !== null; }"
STILL = 5.0  # [s] without a plot, after which the browser is asked for a frame


def draw(plot):
    """Scroll to a plot until it is drawn; Playwright's own scrolling waits for frames, which may never come.

    A browser without a screen may stop making frames, in which plots are drawn: a screenshot makes one.
    """
    page, began = plot.page, time.monotonic()

    def done():
        if plot.evaluate(IN_VIEW):
            return True
        if time.monotonic() - began > STILL:
            page.bring_to_front()
            page.screenshot()
        return False

    waiting.until(done, "a plot in view is not drawn")


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        yield chromium
        chromium.close()


class Visit:
    """One open report, and everything that it asked for or complained about."""

    def __init__(self, browser, path, *, width=1280, height=900, scheme="light", touch=False):
        self.context = browser.new_context(
            viewport={"width": width, "height": height}, color_scheme=scheme, has_touch=touch
        )
        self.page = self.context.new_page()
        self.page.set_default_timeout(PATIENCE)
        self.requests, self.complaints = [], []
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.route("**/*", self._handle)
        self.page.goto(path.as_uri())

    def _handle(self, route):
        if route.request.url.startswith("file:"):
            route.continue_()
        else:
            self.requests.append(route.request.url)
            route.abort()

    def until(self, script, argument=None):
        """Wait until a script's value is true (the page's policy forbids wait_for_function)."""
        waiting.until(lambda: self.page.evaluate(script, argument), script)

    def close(self):
        """It has asked for nothing, and complained about nothing."""
        self.context.close()
        assert self.requests == []
        assert self.complaints == []

    def wide(self):
        """The open recording's plot of surge velocity, drawn."""
        plot = self.page.locator(f"details[open] {WIDE}")
        draw(plot)
        plot.locator(".drag").first.wait_for(state="attached")
        return plot
