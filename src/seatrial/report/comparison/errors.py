# SPDX-License-Identifier: MIT
"""Residuals of both models in the same plots."""

from string import Template

from seatrial.report.comparison import draw
from seatrial.report.comparison.two_models import ModelPair
from seatrial.report.evidence.runs import Run
from seatrial.report.figures import errors as draw_errors
from seatrial.report.figures.base import Figure
from seatrial.report.sections.base import Section, axis_heading, first_of, foldable, plot, store_of
from seatrial.report.text import prose
from seatrial.util.frames import SYMBOLS


def errors(pair: ModelPair) -> Section | None:
    """Autocorrelations and histograms of recordings that both can predict."""
    if pair.evidence is None:
        return None
    first, second = pair.evidence
    parts: list[str] = []
    figures: dict[str, dict[str, Figure]] = {}
    opened = first_of(first.runs)
    for i, (a, b) in enumerate(zip(first.runs, second.runs, strict=True)):
        if a.tested and b.tested:
            figures[store_of(i)] = _figures(a, b)
            parts.append(foldable(a.name, "errors of both", _one(store_of(i)), opened=i == opened))
    if not parts:
        return None
    note = Template(prose.BOTH_ERRORS).substitute(horizon=f"{pair.horizon:g}")
    body = f"""<p class="note">{note}</p>
{"".join(parts)}"""
    return Section("errors", "Residuals", body, figures)


def _figures(a: Run, b: Run) -> dict[str, Figure]:
    found = {}
    for axis, symbol in enumerate(SYMBOLS):
        outlines = [draw_errors.outline(run, axis) for run in (a, b)]
        correlated = [draw_errors.correlation(run, axis) for run in (a, b)]
        found[f"histogram-{symbol}"] = draw.overlaid(outlines)
        found[f"autocorrelation-{symbol}"] = draw.overlaid(correlated)
    return found


def _one(store: str) -> str:
    return "".join(
        axis_heading(axis)
        + f'<div class="pair">{plot(store, f"histogram-{s}", "histogram of the errors of both", "small")}'
        f"{plot(store, f'autocorrelation-{s}', 'autocorrelation of the errors of both', 'small')}</div>"
        for axis, s in enumerate(SYMBOLS)
    )
