# SPDX-License-Identifier: MIT
"""Accuracy of each parameter and of their combinations; before any residual."""

from html import escape

from seatrial.boat.findings import finding_text
from seatrial.boat.schema import EQUATION_ERROR
from seatrial.identification.console import combined, condition_text
from seatrial.identification.methods import caution
from seatrial.identification.uncertainty.identifiability import Identifiability
from seatrial.identification.uncertainty.parameter_verdict import ParameterAccuracy, reach_text
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.figures import known as draw
from seatrial.report.sections.base import ALL, Section, fine, plot
from seatrial.report.text import prose
from seatrial.report.text.cells import NOTHING, Cell, Name, Number, Text
from seatrial.report.text.markup import listing, number, true_minus
from seatrial.report.text.names import html_symbol, names_in, sentence
from seatrial.report.text.table import Table

SHADES = ("0,114,178", "213,94,0")  # of negative and positive correlations


def section(evidence: Evidence) -> Section:
    """Verdicts, combinations, correlation map."""
    found, model = evidence.known, evidence.model
    names = names_in(model)
    notes = [sentence(finding_text(f), names) for f in model.estimator.findings]
    if not found.names:
        body = f"""<p>{prose.NOTHING_ESTIMATED}</p>{listing(notes)}"""
        return Section("known", "What is known", body)
    lines = [*map(combined, found.combinations), *condition_text(found)]
    combinations = [sentence(line, names) for line in lines]
    scatter = model.estimator.method == EQUATION_ERROR
    warned = f'<p class="warning">{escape(caution(model))}</p>' if scatter else ""
    table = verdicts(found)
    matrix = f'<p class="note">{prose.CORRELATIONS}</p>{correlation_map(found)}'
    body = f"""<p class="note">{prose.KNOWN}</p>
{warned}<div class="pair wider">{table.html()}
{plot(ALL, "known", "relative error of every parameter", "tall", rows=len(found.names))}</div>
{listing([*combinations, *notes])}
{fine("correlations of the estimates", matrix, printed=True)}"""
    tables = (table, correlations(found))
    return Section("known", "What is known", body, {ALL: {"known": draw.errors(found)}}, tables)


def verdicts(found: Identifiability) -> Table:
    """A row for each parameter that was estimated."""
    kept = [f for f in found.findings if f.verdict.estimated]
    loose = frozenset(i for i, f in enumerate(kept) if not f.verdict.reliable)
    head = ("parameter", "relative error", "verdict", "correlated most with")
    rows = [_row(f) for f in kept]
    return Table("known", "How well each parameter is known", head, rows, loose)


def correlations(found: Identifiability) -> Table:
    """The correlations as numbers."""
    rows: list[list[Cell]] = [
        [Name(name), *(Number(rho, 2) for rho in found.correlation[i].tolist())]
        for i, name in enumerate(found.names)
    ]
    return Table("correlations", "Correlations of the estimates", ("", *found.names), rows)


def correlation_map(found: Identifiability) -> str:
    """The correlations as a table whose cells are the darker the closer they are to 1 or -1."""
    names = [html_symbol(name) for name in found.names]
    rows = []
    for i, name in enumerate(names):
        cells = "".join(
            f'<td style="background:rgba({SHADES[rho > 0]},{abs(rho):.2f})">'
            f'<data value="{rho:.4f}">{true_minus(str(round(100 * rho)))}</data></td>'
            if i != j else "<td></td>"
            for j, rho in enumerate(found.correlation[i].tolist())
        )  # fmt: skip
        rows.append(f'<tr><th scope="row">{name}</th>{cells}</tr>')
    top = "".join(f'<th scope="col">{name}</th>' for name in names)
    return (
        f'<div class="scroll" tabindex="0"><table class="numbers correlations"><thead><tr><td></td>{top}'
        f"</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def share(found: ParameterAccuracy) -> Cell:
    """Standard error over value [%]."""
    return Number(found.relative, 2, 100.0, " %") if found.relative < 1.0 else Text("> 100 %")


def verdict_text(found: ParameterAccuracy) -> str:
    """The verdict; of an insignificant parameter its upper limit."""
    return ", ".join([found.verdict.value, reach_text(found)]).rstrip(", ")


def _row(found: ParameterAccuracy) -> list[Cell]:
    partner: Cell = NOTHING
    if found.partners:
        name, rho = found.partners[0]
        partner = Name(name, f" ({number(rho, 2)})")
    return [Name(found.name), share(found), Text(verdict_text(found)), partner]
