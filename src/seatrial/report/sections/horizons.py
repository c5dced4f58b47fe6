# SPDX-License-Identifier: MIT
"""Prediction at several horizons, with intervals and floor."""

from collections.abc import Sequence
from html import escape

from seatrial.boat.findings import finding_text
from seatrial.evaluation.scores import Scored
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.runs import Run, judged
from seatrial.report.figures import prediction as draw
from seatrial.report.sections.base import ALL, Section, fine, three
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Text, between, known
from seatrial.report.text.numbers import names_of
from seatrial.report.text.table import Table
from seatrial.util.frames import AXES, ERROR_UNITS, SYMBOLS


def section(evidence: Evidence) -> Section | None:
    """The recordings that score the model, pooled."""
    chosen = judged(evidence.runs)
    rows = evidence.scores.pooled
    if not rows:
        return None
    table = horizons("horizons", "Prediction at several horizons", [("", rows)])
    every = horizons(
        "horizons-by-recording", "Prediction at several horizons, by recording",
        [(run.name, run.score.horizons) for run in evidence.tested if run.score.horizons],
    )  # fmt: skip
    kind = "not seen" if chosen[0].unseen else "seen: identified from"
    notes = "".join(f"<p>{escape(note)}</p>" for note in _findings(evidence.runs))
    said = [prose.HORIZONS_NOTE]
    if any(row.start == "odometry" for row in rows):
        said.append(prose.ODOMETRY_NOTE)
    body = f"""<p class="note">{escape(names_of(chosen))} ({kind}), pooled. {" ".join(said)}</p>
{three(ALL, "horizons", "RMS error against the horizon", "middle")}
{notes}{fine("as a table", table.html())}{fine("by recording", every.html())}"""
    figures = {f"horizons-{s}": draw.horizons(rows, axis) for axis, s in enumerate(SYMBOLS)}
    heading = "Prediction error against horizon"
    return Section("horizons", "Horizons", body, {ALL: figures}, (table, every), heading=heading)


def horizons(name: str, caption: str, groups: Sequence[tuple[str, Sequence[Scored]]]) -> Table:
    """Scores by horizon, start and axis; a group for each of several recordings."""
    head = (
        "velocity", "horizon [s]", "start", "RMS error", "95 %", "unit", "stays constant", "ratio",
        "floor", "expected", "predictions",
    )  # fmt: skip
    rows: list[list[Cell]] = []
    for title, found in groups:
        rows += [[Text(title)]] if title else []
        for axis, symbol in enumerate(SYMBOLS):
            unit, scale = ERROR_UNITS[axis]
            for row in found:
                score = row.scores[symbol]
                rows.append(
                    [
                        Text(f"{AXES[axis]} {symbol}"), Text(f"{row.horizon:g}"), Text(row.start),
                        known(score.rms, 3, scale), between(score.rms_interval, 3, scale), Text(unit),
                        known(score.stays_constant, 3, scale), known(score.ratio, 2),
                        known(score.floor, 3, scale), known(score.expected_rms, 3, scale),
                        Text(f"{row.predictions}"),
                    ]
                )  # fmt: skip
    return Table(name, caption, head, rows)


def _findings(runs: Sequence[Run]) -> list[str]:
    return [f"{run.name}: {finding_text(finding)}." for run in runs for finding in run.findings]
