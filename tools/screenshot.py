# SPDX-License-Identifier: MIT
"""A picture of a report: `screenshot.py REPORT.html OUT.png [--width 1280] [--dark]`."""

import argparse
import shutil
import sys
from pathlib import Path

ARGUMENTS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip


def screenshot(
    report: Path | str,
    out: Path,
    *,
    width: int,
    height: int,
    dark: bool,
    at: str | None,
    whole: bool,
) -> None:
    """Write a PNG of `report`, a file or an address, `width` by `height` px, from the top or from `at`."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=list(ARGUMENTS)
        )
        page = browser.new_page(
            viewport={"width": width, "height": height}, color_scheme="dark" if dark else "light"
        )
        page.goto(report if isinstance(report, str) else report.resolve().as_uri())
        if at:
            page.evaluate("at => document.querySelector(at).scrollIntoView()", at)
        if whole:  # plots are drawn as they come into view
            tall = page.evaluate("document.documentElement.scrollHeight")
            page.set_viewport_size({"width": width, "height": int(tall)})
        page.wait_for_timeout(1500)
        page.screenshot(path=str(out))
        browser.close()


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("report", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--width", type=int, default=1280, help="[px]")
    parser.add_argument("--height", type=int, default=900, help="[px]")
    parser.add_argument("--dark", action="store_true")
    parser.add_argument("--at", help="CSS selector to scroll to, for instance '#prediction'")
    parser.add_argument("--whole", action="store_true", help="the whole page, whatever its height")
    chosen = parser.parse_args()
    if shutil.which("chromium") is None:
        print("screenshot.py: chromium is not installed", file=sys.stderr)
        return 1
    screenshot(
        chosen.report, chosen.out, width=chosen.width, height=chosen.height, dark=chosen.dark,
        at=chosen.at, whole=chosen.whole,
    )  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
