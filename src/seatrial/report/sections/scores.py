# SPDX-License-Identifier: MIT
"""Table III for all axes, and the definitions of its columns."""

from string import Template

from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.sections.base import Section
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Text, between, known
from seatrial.report.text.table import Table
from seatrial.util.frames import AXES, ERROR_UNITS, SYMBOLS


def section(evidence: Evidence) -> Section | None:
    """All recordings that could be predicted."""
    if not evidence.tested:
        return None
    table = scores(evidence)
    marked = prose.MARKED if table.marked else ""
    definitions = Template(prose.SCORES).substitute(horizon=f"{evidence.horizon:g}")
    body = f"""{table.html()}
{marked}<dl class="note">{definitions}</dl>"""
    return Section(
        "scores", "Scores", body, tables=(table,), heading=f"Scores {evidence.horizon:g} s ahead"
    )


def scores(evidence: Evidence) -> Table:
    """All velocities of every recording; the axis that dominates one is marked (Table III)."""
    head = (
        "velocity", "RMS error", "unit", "stays constant", "ratio", "floor", "expected", "excess",
        "bias", "kurtosis", "95 % of RMS", "95 % of ratio",
    )  # fmt: skip
    rows: list[list[Cell]] = []
    marked: set[int] = set()
    for run in evidence.tested:
        rows.append([Text(run.name + ("" if run.unseen else " (seen)"))])
        for axis, sign in enumerate(SYMBOLS):
            found, (name, scale) = run.score.scores[sign], ERROR_UNITS[axis]
            marked |= {len(rows)} if run.score.excited == AXES[axis] else set()
            rows.append(
                [
                    Text(f"{AXES[axis]} {sign}"), known(found.rms, 3, scale), Text(name),
                    known(found.stays_constant, 3, scale), known(found.ratio, 3),
                    known(found.floor, 3, scale), known(found.expected_rms, 3, scale),
                    known(found.excess, 3, scale), known(found.bias, 2, scale), known(found.kurtosis, 3),
                    between(found.rms_interval, 3, scale), between(found.ratio_interval, 3),
                ]
            )  # fmt: skip
    return Table("scores", "Scores", head, rows, frozenset(marked))
