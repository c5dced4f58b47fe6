# SPDX-License-Identifier: MIT
"""Whether recordings agree: scores, and what each alone makes of the parameters."""

from html import escape

from seatrial.report.evidence.homogeneity import Repeat, repeat
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.figures import homogeneity as draw
from seatrial.report.figures.base import Figure
from seatrial.report.sections.base import ALL, Section, fine, plot
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Name, Text, known
from seatrial.report.text.names import names_in, sentence
from seatrial.report.text.table import Table
from seatrial.util.format import joined


def section(evidence: Evidence) -> Section | None:
    """Only where there are two recordings or more."""
    if len(evidence.runs) < 2:
        return None
    found = repeat(evidence)
    figures: dict[str, Figure] = {}
    parts, tables = [], []
    if len(evidence.tested) > 1:
        figures["repeat-scores"] = draw.scores(evidence.tested)
        parts.append(
            plot(ALL, "repeat-scores", "error over constant velocity's, by recording", "middle",
                 "error over that of a velocity that stays, by recording")
        )  # fmt: skip
    if found is None:
        parts.append(f"<p>{escape(prose.NO_INFORMATION)} {escape(evidence.silent)}.</p>")
    else:
        figures["repeat-parameters"] = draw.parameters(found)
        tables = [shifts(found)]
        told = sentence(_said(found), names_in(evidence.model))
        parts.append(f"<p>{told}</p><p class='note'>{prose.REPEAT}</p>")
        label = "what each recording alone makes of each parameter"
        high = len(found.rows) * max(1, len(evidence.runs) // 3)
        parts.append(plot(ALL, "repeat-parameters", label, "tall", label, rows=high))
        parts.append(fine("as a table", tables[0].html()))
    html = f"""<section id="repeat"><h2>Do recordings agree?</h2>
{"".join(parts)}</section>"""
    return Section("repeat", "Agreement", html, {ALL: figures}, tuple(tables))


def shifts(found: Repeat) -> Table:
    """Each recording's own value, as a share of the model's."""
    head = ("parameter", *(f"{name} [%]" for name in found.recordings), "spread [%]", "p of chance")
    rows: list[list[Cell]] = [
        [
            Name(row.name),
            *(known(shift, 2, 100.0) for shift in row.shifts),
            known(row.spread, 2, 100.0),
            Text("–" if row.p is None else "< 0.001" if row.p < 0.001 else f"{row.p:.3f}"),
        ]
        for row in found.rows
    ]
    marked = frozenset(i for i, row in enumerate(found.rows) if row.name in found.unlike)
    return Table("repeat", "What each recording alone makes of the parameters", head, rows, marked)


def _said(found: Repeat) -> str:
    if not any(row.p is not None for row in found.rows):
        return "No parameter is told well enough by two recordings to compare them."
    if not found.unlike:
        return "Where several recordings tell a parameter, they agree as far as their errors let one see."
    return (
        f"Recordings differ by more than chance in {joined(found.unlike)}: something changed between "
        "them (payload, battery, current), or the structure lacks what would explain it; the "
        "intervals above are too narrow by that."
    )
