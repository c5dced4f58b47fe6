# SPDX-License-Identifier: MIT
"""Implied physics: top speed, rise time, stopping distance."""

from html import escape

from seatrial.boat.physics import physics_line
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.physics import Spread
from seatrial.report.figures import physics as draw
from seatrial.report.sections.base import ALL, Section, plot
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Number, Text, between
from seatrial.report.text.table import Table
from seatrial.util.frames import AXES, SYMBOLS

HEADING = "Implied physics: compare with your boat"
MOTION_UNITS = (("m/s", "m"), ("m/s", "m"), ("rad/s", "rad"))  # of speed and of coasting
PHYSICS_HEAD = (
    "command", "top speed", "95 % interval", "unit", "time to 63 % [s]", "95 % interval [s]",
    "coasting", "95 % interval of coasting", "unit of coasting",
)  # fmt: skip
MANY_UNSTABLE = 0.02  # share of unstable draws above which a warning is given


def section(evidence: Evidence) -> Section:
    """Each driven axis, with intervals."""
    found = evidence.physics
    if found.unstable or not found.axes:
        text = f"{found.unstable}." if found.unstable else "No command drives any axis."
        body = f"""<p class="warning">{escape(text)}</p>"""
        return Section("physics", "Boat", body, heading=HEADING)
    table = boat(evidence)
    drawn = "".join(
        plot(ALL, f"start-{SYMBOLS[one.axis]}", f"{AXES[one.axis]}: start and stop", "small")
        for one in found.axes
    )
    warning = ""
    if found.unstable_share > MANY_UNSTABLE:
        warning = (
            f'<p class="warning">{100 * found.unstable_share:.0f} % of the models drawn from the parameter '
            f"covariance are unstable: drive more before you use the model.</p>"
        )
    body = f"""<p class="sanity">{escape(physics_line(evidence.model))}</p>
{warning}<div class="three">{drawn}</div>
{table.html()}<p class="note">{prose.PHYSICS} {prose.RISE}</p>"""
    figures = {
        f"start-{SYMBOLS[one.axis]}": draw.start_and_stop(evidence.model, one) for one in found.axes
    }
    return Section("physics", "Boat", body, {ALL: figures}, (table,), heading=HEADING)


def boat(evidence: Evidence) -> Table:
    """A row for each driven axis."""
    rows = [[Text(AXES[one.axis]), *physics_cells(one)] for one in evidence.physics.axes]
    return Table("boat", "Physics of the model", ("axis", *PHYSICS_HEAD), rows)


def physics_cells(one: Spread) -> list[Cell]:
    """The columns of `PHYSICS_HEAD` for one axis of a model."""
    speed, distance = MOTION_UNITS[one.axis]
    found = one.found
    return [
        Number(found.command, 2), Number(found.top_speed, 3), between(one.top_speed), Text(speed),
        Number(found.rise_time, 3), between(one.rise_time), Number(found.coast, 3),
        between(one.coast), Text(distance),
    ]  # fmt: skip
