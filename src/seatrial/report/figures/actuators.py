# SPDX-License-Identifier: MIT
"""Static curves of thrusters and angles with their dead zones, and step response with latency and lag."""

from collections.abc import Sequence

from seatrial.boat.model import Model
from seatrial.report.evidence.actuators import Curve, angle_curves, curves, step_responses
from seatrial.report.figures.base import (
    BLACK,
    ORANGE,
    SHADE,
    WARM,
    Figure,
    area,
    colour_of,
    figure,
    line,
    upright,
)

MOST_CURVES = 8  # of one plot
COMMANDS, THRUST, ANGLE = "command [command units]", "thrust [share of full]", "angle [deg]"


def static_curve(model: Model) -> Figure:
    """Thrust against command, with 95 % bands and the edges of the dead zones."""
    return _static(model, curves(model), THRUST)


def angle_curve(model: Model) -> Figure:
    """Angle against command, likewise."""
    return _static(model, angle_curves(model), ANGLE)


def _static(model: Model, found: Sequence[Curve], y: str) -> Figure:
    each = model.vehicle.constants.of_each
    own = [model.vehicle.actuators.index(name) for curve in found for name in curve.names]
    edges = {
        sign * float(edge)
        for sign, kind in ((1.0, "edge_forward"), (-1.0, "edge_reverse"))
        for edge in each(kind, model.constants)[own]
        if edge
    }
    shapes = [upright(edge, ORANGE) for edge in sorted(edges)]
    return figure(
        _drawn(found), COMMANDS, y, xaxis={"range": [-1.02, 1.02]}, shapes=shapes, showlegend=True
    )


def step_response(model: Model) -> Figure:
    """Force after a full command at 0 s, with 95 % bands."""
    found = step_responses(model)
    shapes = [upright(0.0, BLACK, "dash")]
    return figure(
        _drawn(found), "time since the command [s]", "force [share of final value]",
        yaxis={"range": [-0.05, 1.1]}, shapes=shapes, showlegend=True,
    )  # fmt: skip


def _drawn(found: Sequence[Curve]) -> list[Figure]:
    traces = []
    for i, one in enumerate(found[:MOST_CURVES]):
        colour, dash = colour_of(i)
        if (one.high > one.low).any():
            band = area(
                f"{one.label}, 95 %", one.x, one.low, one.high, colour, shade=SHADE if i == 0 else WARM,
            )  # fmt: skip
            traces.append(band | {"showlegend": False})
        traces.append(line(one.label, one.x, one.y, colour, dash=dash, width=2.0))
    return traces
