# SPDX-License-Identifier: MIT
"""The page: sections in their order, and everything that they need inside the file."""

from collections.abc import Sequence
from functools import cache
from html import escape
from importlib import resources
from importlib.metadata import version

from seatrial.model import Model
from seatrial.report import known, sections
from seatrial.report.embed import pack
from seatrial.report.figures import figures
from seatrial.report.runs import Run

# The browser itself refuses every request, whatever a name in the file may try.
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
)
CONTENTS = (
    ("model", "Model"),
    ("known", "What is known"),
    ("recorded", "Recordings"),
    ("prediction", "Prediction"),
    ("scores", "Scores"),
    ("provenance", "Provenance"),
)


def page(model: Model, runs: Sequence[Run], horizon: float) -> str:
    """The whole HTML text; `horizon` in s."""
    told = known.section(model)
    body = "\n".join(
        [
            sections.verdict(model, runs, horizon),
            sections.model(model),
            told,
            sections.recorded(runs),
            sections.prediction(runs, horizon),
            sections.scores(runs, horizon),
            sections.provenance(model, runs, horizon),
        ]
    )
    figure_data = "\n".join(
        f'<script type="application/json" id="run-{i}">{pack(figures(model, run))}</script>'
        for i, run in enumerate(runs)
    )
    contents = [entry for entry in CONTENTS if entry[0] != "known" or told]
    links = "".join(f'<a href="#{name}">{title}</a>' for name, title in contents)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="generator" content="seatrial {escape(version("seatrial"))}">
<title>{escape(model.name)}: seatrial report</title>
<style>
{_asset("report.css")}</style>
</head>
<body>
<nav>{links}<button type="button" data-do="all">open all</button></nav>
<main>
<noscript><p class="warning">The plots need JavaScript, which is turned off here.</p></noscript>
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


@cache
def _asset(name: str) -> str:
    """A file that lies beside this one."""
    return (resources.files("seatrial.report") / name).read_text(encoding="utf-8")
