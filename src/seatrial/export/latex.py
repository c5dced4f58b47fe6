# SPDX-License-Identifier: MIT
"""Equations and coefficients for a paper: LaTeX, by the cells of the report."""

from seatrial.export.content import Content
from seatrial.identification.uncertainty.identifiability import identifiability
from seatrial.report.text.cells import Cell, Name, Number, Text, Unit, between, known
from seatrial.report.text.equations import latex_equations
from seatrial.report.text.latex import latex_text
from seatrial.report.text.table import Table
from seatrial.util.statistics import NORMAL_95

TABLE_HEAD = ("parameter", "value", "standard error", "95 % interval", "unit", "verdict")


def text(content: Content) -> str:
    """A `tabular` with intervals, and above it the equations as `align*`."""
    about = latex_text(f"{content.vehicle_name}, {content.axes.value} axes, {content.source}")
    return (
        f"% {about}; needs \\usepackage{{amsmath}} and \\usepackage{{booktabs}}\n"
        "% Coefficients are per unit mass and inertia, forces F in command units (1: full).\n"
        f"\\begin{{align*}}\n{latex_equations(content.structure)}\n\\end{{align*}}\n\n{table(content).latex()}"
    )


def table(content: Content) -> Table:
    """Coefficients, then the thrusters' constants."""
    found = identifiability(content.model)
    rows: list[list[Cell]] = []
    for name, source in content.sources.items():
        value, error = content.values[source], content.errors[source]
        width = NORMAL_95 * error
        rows.append([
            Name(name),
            Number(value),
            known(error if error > 0 else None, 2),
            between((value - width, value + width) if error > 0 else None),
            Unit(content.units[source]),
            Text(found[source].verdict.value),
        ])  # fmt: skip
    return Table("coefficients", f"Coefficients of {content.vehicle_name}", TABLE_HEAD, rows)
