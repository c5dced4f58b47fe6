# SPDX-License-Identifier: MIT
"""Sanity in physical words: top speed, time to it, way to stop."""

from html import escape

from seatrial.boat.physics import physics_line
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.figures import physics as draw
from seatrial.report.sections.base import ALL, Section, plot
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Number, Text, between
from seatrial.report.text.table import Table
from seatrial.util.frames import AXES, SYMBOLS

UNITS = (("m/s", "m"), ("m/s", "m"), ("rad/s", "rad"))
MANY_LOST = 0.02  # share of draws that are no boat, from which on it is said


def section(evidence: Evidence) -> Section:
    """Each driven axis, with intervals."""
    found = evidence.physics
    if found.unstable or not found.axes:
        text = f"{found.unstable}." if found.unstable else "No command drives any axis."
        html = f"""<section id="physics"><h2>Is that your boat?</h2>
<p class="warning">{escape(text)}</p></section>"""
        return Section("physics", "Boat", html)
    table = boat(evidence)
    drawn = "".join(
        plot(
            ALL,
            f"start-{SYMBOLS[one.axis]}",
            f"{AXES[one.axis]}: getting going, coming to rest",
            "small",
        )
        for one in found.axes
    )
    lost = ""
    if found.lost > MANY_LOST:
        lost = (
            f'<p class="warning">With coefficients drawn from their standard errors, the model is '
            f"unstable in {100 * found.lost:.0f} % of the cases: drive more before you rely on it.</p>"
        )
    html = f"""<section id="physics"><h2>Is that your boat?</h2>
<p class="sanity">{escape(physics_line(evidence.model))}</p>
{lost}<div class="three">{drawn}</div>
{table.html()}<p class="note">{prose.PHYSICS} {prose.RISE}</p></section>"""
    figures = {
        f"start-{SYMBOLS[one.axis]}": draw.start_and_stop(evidence.model, one) for one in found.axes
    }
    return Section("physics", "Boat", html, {ALL: figures}, (table,))


def boat(evidence: Evidence) -> Table:
    """What the boat does."""
    head = ("axis", "command", "top speed", "95 % of it", "unit", "time to 63 % [s]", "95 % of that [s]",
            "coasts", "95 % of the way", "unit of the way")  # fmt: skip
    rows: list[list[Cell]] = []
    for one in evidence.physics.axes:
        speed, way = UNITS[one.axis]
        found = one.found
        rows.append(
            [
                Text(AXES[one.axis]), Number(found.command, 2), Number(found.top_speed, 3),
                between(one.top_speed), Text(speed), Number(found.rise_time, 3),
                between(one.rise_time), Number(found.coast, 3), between(one.coast), Text(way),
            ]
        )  # fmt: skip
    return Table("boat", "What the model means for the boat", head, rows)
