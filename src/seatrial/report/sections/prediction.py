# SPDX-License-Identifier: MIT
"""Measured against predicted velocity of every axis, with the commands."""

from html import escape
from string import Template

from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.runs import PLOT_WINDOW, Run
from seatrial.report.figures import prediction as draw
from seatrial.report.sections.base import Section, first_of, foldable, store_of, velocity_plots
from seatrial.report.text import prose
from seatrial.report.text.markup import number
from seatrial.util.frames import ERROR_UNITS, SYMBOLS

BUTTONS = (
    ("whole", "whole run"),
    ("window", f"{PLOT_WINDOW:g} s"),
    ("earlier", "‹ earlier"),
    ("later", "later ›"),
)


def section(evidence: Evidence) -> Section:
    """Each recording, foldable."""
    runs, horizon = evidence.runs, f"{evidence.horizon:g}"
    parts = "\n".join(_one(run, i, opened=i == first_of(runs)) for i, run in enumerate(runs))
    note = Template(prose.PREDICTION).substitute(horizon=horizon, window=f"{PLOT_WINDOW:g}")
    body = f"""<p class="note">{note}</p>
{parts}"""
    figures = {
        store_of(i): {
            f"velocity-{s}": draw.velocity(evidence.model, run, a) for a, s in enumerate(SYMBOLS)
        }
        for i, run in enumerate(runs)
    }
    heading = f"Measured and predicted, {horizon}&nbsp;s ahead"
    return Section("prediction", "Prediction", body, figures, heading=heading)


def sizes(run: Run) -> str:
    """Seen or not, and its RMS errors."""
    kind = "not seen" if run.unseen else "seen"
    if not run.tested:
        return f"{kind}; no prediction"
    found = [
        f"{sign} {number(run.score.scores[sign].rms * scale, 2)} {name}"
        for sign, (name, scale) in zip(SYMBOLS, ERROR_UNITS, strict=True)
    ]
    return f"{kind}; RMS error {', '.join(found)}"


def linked(run: Run, inside: str) -> str:
    """Plots whose time axes move together, with buttons."""
    whole = f"{run.t[0]:.6g},{run.t[-1]:.6g}"
    window = f"{run.window[0]:.6g},{run.window[1]:.6g}"
    buttons = "".join(
        f'<button type="button" data-do="{do}">{label}</button>' for do, label in BUTTONS
    )
    return (
        f'<div class="linked" data-whole="{whole}" data-window="{window}">'
        f'<div class="bar">{buttons}</div>{inside}</div>'
    )


def _one(run: Run, place: int, *, opened: bool) -> str:
    warning = "" if run.tested else f'<p class="warning">{escape(run.failure)}</p>'
    drawn = velocity_plots(store_of(place), "measured and predicted")
    return foldable(run.name, sizes(run), warning + linked(run, drawn), opened=opened)
