# SPDX-License-Identifier: MIT
"""What to do next, and the expected information of further manoeuvres."""

from html import escape

import numpy as np

from seatrial.identification.experiment_design.gain import drive_time
from seatrial.identification.solution import OUTPUT_ERROR
from seatrial.report.evidence.advice import advice
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.figures import advice as draw
from seatrial.report.sections.base import ALL, Section, plot
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Name, Number, Text, Worded
from seatrial.report.text.markup import listing
from seatrial.report.text.names import names_in, sentence
from seatrial.report.text.table import Table
from seatrial.util.statistics import NORMAL_95


def section(evidence: Evidence) -> Section:
    """Sentences, then the expected gain by parameter."""
    todo = [sentence(text, names_in(evidence.model)) for text in advice(evidence)]
    items = listing(todo, "advice") if todo else prose.ALL_WELL
    if not evidence.gains:
        why = f"<p class='note'>{prose.NO_GAINS} {escape(evidence.no_information)}</p>"
        body = f"{items}\n{why}"
        return Section("advice", "Next drive", body, heading="The next drive")
    table = gained(evidence)
    other = evidence.model.estimator.method != OUTPUT_ERROR
    more = f" {prose.OTHER_METHOD}" if other else ""
    body = f"""{items}
<h3>Expected information of further driving</h3>
<p class="note">{prose.GAINS}{more}</p>
{plot(ALL, "halving", "time to halve every interval", "tall", rows=len(evidence.gains))}
{table.html()}"""
    figures = {"halving": draw.halving(evidence.gains)}
    return Section("advice", "Next drive", body, {ALL: figures}, (table,), heading="The next drive")


def gained(evidence: Evidence) -> Table:
    """For every parameter the best manoeuvre."""
    head = ("parameter", "value", "± (95 %)", "± after 1 min", "halved after", "manoeuvre")
    rows: list[list[Cell]] = [
        [
            Name(g.parameter), Number(g.value, 3), Number(NORMAL_95 * g.error, 2),
            Number(NORMAL_95 * g.after, 2),
            Worded(g.seconds, drive_time(g.seconds) if np.isfinite(g.seconds) else "never", "s"),
            Text(g.manoeuvre),
        ]
        for g in evidence.gains
    ]  # fmt: skip
    return Table("gains", "Expected information of further driving", head, rows)
