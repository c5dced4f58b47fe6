# SPDX-License-Identifier: MIT
"""The equations, with names and with numbers, and every coefficient."""

from seatrial.boat.model import Model
from seatrial.boat.physics import SIGNIFICANT
from seatrial.boat.schema import EQUATION_ERROR
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.sections.base import Section
from seatrial.report.sections.known import verdict_text
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Name, Number, Text, Unit, with_error
from seatrial.report.text.equations import equations
from seatrial.report.text.table import Table
from seatrial.util.frames import Axes


def section(evidence: Evidence) -> Section:
    """Equations, coefficients, least-squares steps."""
    model, structure = evidence.model, evidence.model.structure
    other = prose.OTHER_AXES if model.vehicle.axes is Axes.FRD else ""
    remark = prose.LEAST_SQUARES if model.estimator.method == EQUATION_ERROR else ""
    tables = [coefficients(evidence)]
    found = ""
    if model.estimator.steps:
        tables.append(steps(model))
        found = f"<h3>Estimation steps</h3>{tables[-1].html()}"
    body = f"""<p class="note">{prose.AXES_NOTE}{other} {prose.SIGNIFICANCE_NOTE.format(SIGNIFICANT)}</p>
{tables[0].html()}
<h3>Equations</h3>
{equations(structure)}
<p>With numbers (SI units, forces in command units):</p>
{equations(structure, model.values)}
{found}{remark}"""
    return Section(
        "model", "Model", body, tables=tuple(tables), heading="Coefficients and equations"
    )


def coefficients(evidence: Evidence) -> Table:
    """Values, standard errors, 95 % intervals and verdicts, forward-left-up and in the file's axes."""
    model = evidence.model
    own_axes = model.vehicle.axes is Axes.FRD
    head = ["coefficient", "value", "standard error", "95 % interval", "unit", "verdict"]
    head += [f"value in {model.vehicle.axes.value} axes"] if own_axes else []
    rows: list[list[Cell]] = []
    marked = set()
    for place, (name, value) in enumerate(model.values.items()):
        found = evidence.known[name]
        units = Unit(model.structure.units[name]), Text(verdict_text(found))
        row: list[Cell] = [Name(name), *with_error(value, found.error), *units]
        if own_axes:
            row.append(Number(-value if name in model.structure.flipped_coefficients else value))
        rows.append(row)
        marked |= set() if found.verdict.reliable else {place}
    return Table("coefficients", "Coefficients", tuple(head), rows, frozenset(marked))


def steps(model: Model) -> Table:
    """The least-squares steps of the estimate."""
    head = ("step", "coefficients", "from", "rows", "condition", "R²")
    rows: list[list[Cell]] = [
        [
            Text(step.equation),
            Name(", ".join(step.coefficients)),
            Text(", ".join(step.recordings)),
            Text(f"{step.rows}"),
            Number(step.condition, 2),
            Number(step.explained, 2),
        ]
        for step in model.estimator.steps
    ]
    return Table("steps", "Least-squares steps", head, rows)
