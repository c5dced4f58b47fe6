# SPDX-License-Identifier: MIT
"""Homogeneity across recordings: scores, and each recording's own estimates."""

from html import escape

from seatrial.report.evidence.homogeneity import Homogeneity, homogeneity
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.figures import homogeneity as draw
from seatrial.report.figures.base import Figure
from seatrial.report.sections.base import ALL, Section, fine, plot
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Name, Text, known
from seatrial.report.text.names import names_in, sentence
from seatrial.report.text.table import Table
from seatrial.util.format import chance, joined


def section(evidence: Evidence) -> Section | None:
    """Only where there are two recordings or more."""
    if len(evidence.runs) < 2:
        return None
    found = homogeneity(evidence)
    figures: dict[str, Figure] = {}
    parts, tables = [], []
    if len(evidence.tested) > 1:
        figures["repeat-scores"] = draw.scores(evidence.tested)
        parts.append(
            plot(ALL, "repeat-scores", "RMS error over that of constant velocity, by recording", "middle",
                 "RMS error over that of constant velocity, by recording")
        )  # fmt: skip
    if found is None:
        parts.append(f"<p>{escape(prose.NO_INFORMATION)} {escape(evidence.no_information)}.</p>")
    else:
        figures["repeat-parameters"] = draw.parameters(found)
        tables = [shifts(found)]
        result = sentence(_result(found), names_in(evidence.model))
        parts.append(f"<p>{result}</p><p class='note'>{prose.HOMOGENEITY}</p>")
        label = "each recording's own estimate of each parameter"
        high = len(found.rows) * max(1, len(evidence.runs) // 3)
        parts.append(plot(ALL, "repeat-parameters", label, "tall", label, rows=high))
        parts.append(fine("as a table", tables[0].html()))
    return Section(
        "repeat", "Homogeneity", "".join(parts), {ALL: figures}, tuple(tables),
        heading="Homogeneity across recordings",
    )  # fmt: skip


def shifts(found: Homogeneity) -> Table:
    """Each recording's own value, as a share of the model's."""
    head = ("parameter", *(f"{name} [%]" for name in found.recordings), "spread [%]", "p (Cochran)")
    rows: list[list[Cell]] = [
        [
            Name(row.name),
            *(known(shift, 2, 100.0) for shift in row.shifts),
            known(row.spread, 2, 100.0),
            Text("–" if row.p is None else chance(row.p)),
        ]
        for row in found.rows
    ]
    marked = frozenset(i for i, row in enumerate(found.rows) if row.name in found.inhomogeneous)
    return Table("repeat", "Each recording's own estimates", head, rows, marked)


def _result(found: Homogeneity) -> str:
    if not any(row.p is not None for row in found.rows):
        return "No parameter is determined by two recordings, so they can't be compared."
    if not found.inhomogeneous:
        return (
            "No significant difference between recordings in any parameter that several determine."
        )
    return (
        f"Recordings differ significantly in {joined(found.inhomogeneous)}; the table shows which. Possible "
        "causes: a change of payload, battery, propeller speed or current between them, or model mismatch. "
        "If the model is identified from recordings that differ, its intervals are too narrow."
    )
