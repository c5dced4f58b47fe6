# SPDX-License-Identifier: MIT
"""Head-to-head prediction of the same recordings."""

from seatrial.evaluation.comparison.prediction import PredictionRow
from seatrial.evaluation.pooled_scores import pooled
from seatrial.report.comparison import draw
from seatrial.report.comparison.two_models import LETTERS, ModelPair
from seatrial.report.figures import recorded as draw_recorded
from seatrial.report.figures.base import Figure
from seatrial.report.sections.base import (
    ALL,
    Section,
    first_of,
    foldable,
    recorded_plots,
    store_of,
    three,
    velocity_plots,
)
from seatrial.report.sections.prediction import linked, sizes
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Number, Text, between
from seatrial.report.text.table import Table
from seatrial.util.frames import AXES, ERROR_UNITS, SYMBOLS


def recorded(pair: ModelPair) -> Section | None:
    """The recordings that both predict."""
    if pair.evidence is None:
        return None
    runs = pair.evidence[0].runs
    figures = {"tracks": draw_recorded.tracks(runs), "timeline": draw_recorded.timeline(runs)}
    return Section("recorded", "Recordings", recorded_plots(), {ALL: figures})


def horizons(pair: ModelPair) -> Section | None:
    """Errors against the horizon, with the interval of their difference."""
    if pair.evidence is None:
        return None
    chosen = [
        [run.assessment for run in side.runs if run.assessment.ahead] for side in pair.evidence
    ]
    if not chosen[0] or not chosen[1]:
        return None
    rows = pooled(chosen[0]), pooled(chosen[1])
    table = ahead_table(pair.found.ahead)
    body = f"""<p class="note">{prose.BOTH_HORIZONS}</p>
{three(ALL, "horizons", "RMS errors of both against the horizon", "middle")}
{table.html()}<p class="note">{prose.HEAD_TO_HEAD}</p>"""
    figures = {f"horizons-{s}": draw.horizons(rows, axis) for axis, s in enumerate(SYMBOLS)}
    return Section("horizons", "Which predicts better", body, {ALL: figures}, (table,))


def ahead_table(found: list[PredictionRow]) -> Table:
    """RMS errors of both from the same starts, with the interval of their difference."""
    head = ("velocity", "horizon [s]", "RMS A", "RMS B", "unit", "A − B", "95 % interval", "better")
    rows: list[list[Cell]] = []
    for row in found:
        seen = [letter for letter, s in zip(LETTERS, (row.seen_a, row.seen_b), strict=True) if s]
        more = f" (seen by {' and '.join(seen)})" if seen else ""
        rows.append([Text(f"{row.recording}, {row.horizon:g} s{more}")])
        for axis, symbol in enumerate(SYMBOLS):
            (unit, scale), one = ERROR_UNITS[axis], row.axes[symbol]
            rows.append(
                [
                    Text(f"{AXES[axis]} {symbol}"), Text(f"{row.horizon:g}"), Number(one.a, 3, scale),
                    Number(one.b, 3, scale), Text(unit), Number(one.difference, 2, scale),
                    between(one.interval, 2, scale), Text(one.better or "not significant"),
                ]
            )  # fmt: skip
    return Table("ahead", "RMS errors of both models", head, rows)


def ahead(pair: ModelPair) -> Section | None:
    """Measured, and predicted by both."""
    if pair.evidence is None:
        return None
    first, second = pair.evidence
    figures: dict[str, dict[str, Figure]] = {}
    parts = []
    opened = first_of(first.runs)
    for i, (a, b) in enumerate(zip(first.runs, second.runs, strict=True)):
        store = store_of(i)
        figures[store] = {
            f"velocity-{s}": draw.velocity(first.model, (a, b), axis)
            for axis, s in enumerate(SYMBOLS)
        }
        drawn = velocity_plots(store, "measured and predicted by both")
        facts = f"A: {sizes(a)}. B: {sizes(b)}"
        parts.append(foldable(a.name, facts, linked(a, drawn), opened=i == opened))
    heading = f"Measured and predicted, {pair.horizon:g}&nbsp;s ahead"
    return Section("prediction", "Prediction", "".join(parts), figures, heading=heading)
