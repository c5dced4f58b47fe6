# SPDX-License-Identifier: MIT
"""The page: sections in order, with all assets inside the file."""

import re
from collections.abc import Sequence
from functools import cache
from html import escape
from importlib import resources
from importlib.metadata import version

from seatrial.report.figures.base import Figure
from seatrial.report.figures.embed import pack
from seatrial.report.sections.base import Section

# The browser itself refuses every request, whatever a name in a file contains.
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
)


def page(title: str, found: Sequence[Section]) -> str:
    """The whole HTML text of some sections."""
    body = _kept_together("\n".join(section.html for section in found))
    figure_data = "\n".join(
        f'<script type="application/json" id="{store}">{pack(figures)}</script>'
        for store, figures in stores(found).items()
    )
    links = "".join(f'<a href="#{s.name}">{escape(s.title)}</a>' for s in found if s.title)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="generator" content="seatrial {escape(version("seatrial"))}">
<title>{escape(title)}</title>
<style>
{_asset("report.css")}</style>
</head>
<body>
<nav>{links}<button type="button" data-do="all">open all</button></nav>
<main>
<noscript><p class="warning">The plots need JavaScript; it is disabled here.</p></noscript>
{body}
</main>
{figure_data}
<script>
{_asset("plotly-basic.min.js")}
</script>
<script>
{_asset("report.js")}</script>
</body>
</html>
"""


def stores(found: Sequence[Section]) -> dict[str, dict[str, Figure]]:
    """All plots by store, by name."""
    out: dict[str, dict[str, Figure]] = {}
    for section in found:
        for store, figures in section.figures.items():
            out.setdefault(store, {}).update(figures)
    return out


def _kept_together(html: str) -> str:
    """No line breaks before a per cent sign, or around ±."""
    return re.sub(r"(?<=\d) (?=%)|(?<=\d) (?=± )|(?<=±) (?=\d)", "\u00a0", html)


@cache
def _asset(name: str) -> str:
    return (resources.files("seatrial.report") / "assets" / name).read_text(encoding="utf-8")
