# SPDX-License-Identifier: MIT
"""The actuator chain: curve, latency and lag."""

from html import escape

from seatrial.boat.steering import angle_names
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.figures import actuators as draw
from seatrial.report.sections.base import ALL, Section, plot
from seatrial.report.sections.known import verdict_text
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Name, Text, with_error
from seatrial.report.text.table import Table


def section(evidence: Evidence) -> Section:
    """Static curve and step response."""
    model = evidence.model
    scheme = f"Allocation: {model.vehicle.scheme.value}."
    if not model.vehicle.constants.names and not any(g.table for g in model.vehicle.file.chain):
        body = f"""<p>{escape(scheme)} {prose.NO_CONSTANTS}</p>"""
        return Section("actuators", "Actuators", body)
    table = constants(evidence)
    steered = bool(angle_names(model.vehicle.file.chain))
    body = f"""<p class="note">{escape(scheme)} {about(steered=steered)}</p>
{plots(steered=steered)}
{table.html()}"""
    figures = {"curve": draw.static_curve(model), "answer": draw.step_response(model)}
    figures |= {"angle": draw.angle_curve(model)} if steered else {}
    return Section("actuators", "Actuators", body, {ALL: figures}, (table,))


def about(*, steered: bool) -> str:
    """What the curves are."""
    return f"{prose.ACTUATORS} {prose.ANGLES}" if steered else prose.ACTUATORS


def plots(*, steered: bool) -> str:
    """The plots `curve`, `answer` and, of a steered boat, `angle`."""
    curve = plot(ALL, "curve", "thrust against command", "middle", "static curve")
    answer = plot(
        ALL, "answer", "force after a step of the command", "middle", "step response, full command at 0 s"
    )  # fmt: skip
    if not steered:
        return f'<div class="pair">{curve}\n{answer}</div>'
    angle = plot(ALL, "angle", "angle against command", "middle", "static curve of the angle")
    return f'<div class="three">{curve}\n{angle}\n{answer}</div>'


def constants(evidence: Evidence) -> Table:
    """Constants of the actuator chain."""
    model = evidence.model
    chain = model.vehicle.constants
    rows: list[list[Cell]] = []
    marked = set()
    for place, (name, value) in enumerate(zip(chain.names, model.constants.tolist(), strict=True)):
        found = evidence.known[name]
        units = Text(chain.unit(name)), Text(verdict_text(found))
        rows.append([Name(name), *with_error(value, found.error), *units])
        marked |= set() if found.verdict.reliable else {place}
    head = ("constant", "value", "standard error", "95 % interval", "unit", "verdict")
    return Table("constants", "Constants of the actuator chain", head, rows, frozenset(marked))
