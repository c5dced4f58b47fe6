# SPDX-License-Identifier: MIT
"""Curves of a tuning, with the band of its draws."""

import numpy as np

from seatrial.control.tuning.design import SENSITIVITY_LIMIT
from seatrial.control.tuning.responses import Curves
from seatrial.report.figures.base import (
    BLACK,
    BLUE,
    ORANGE,
    Figure,
    area,
    figure,
    level,
    line,
    logarithmic,
)

OMEGA = "angular frequency [rad/s]"


def step(curves: Curves, axis: int, name: str) -> Figure:
    """Step response; dotted: the reference."""
    return _banded(
        curves, axis, "time [s]", f"{name}: response over step",
        shapes=[level(1.0, BLACK)], xaxis={"range": [0.0, float(curves.x[-1])]}, yaxis={"range": [-0.1, 1.6]},
    )  # fmt: skip


def gain(curves: Curves, axis: int, name: str) -> Figure:
    """Of the open loop in decibels; dotted: 0, a gain of 1."""
    decibels = Curves(curves.x, *(20.0 * np.log10(y) for y in (curves.y, curves.low, curves.high)))
    return _banded(
        decibels, axis, OMEGA, f"{name}: gain [dB]", shapes=[level(0.0, ORANGE)],
        xaxis=_along(curves), yaxis={"range": [-40.0, 60.0]},
    )  # fmt: skip


def phase(curves: Curves, axis: int, name: str) -> Figure:
    """Of the open loop; dotted: -180."""
    return _banded(
        curves, axis, OMEGA, f"{name}: phase [deg]", shapes=[level(-180.0, ORANGE)], xaxis=_along(curves),
        yaxis={"range": [-360.0, -60.0], "tickvals": [-360, -270, -180, -90]},
    )  # fmt: skip


def sensitivity(curves: Curves, axis: int, name: str) -> Figure:
    """|S| over frequency; dotted: the limit."""
    return _banded(
        curves, axis, OMEGA, f"{name}: sensitivity", shapes=[level(SENSITIVITY_LIMIT, ORANGE)],
        xaxis=_along(curves), yaxis={"range": [0.0, 2.2]},
    )  # fmt: skip


def _banded(curves: Curves, axis: int, x: str, y: str, **layout: object) -> Figure:
    traces = []
    if (curves.high[axis] > curves.low[axis]).any():
        traces.append(area("draws", curves.x, curves.low[axis], curves.high[axis], BLUE))
    traces.append(line("model", curves.x, curves.y[axis], BLUE, width=2.0))
    return figure(traces, x, y, **layout)


def _along(curves: Curves) -> Figure:
    return logarithmic(float(curves.x[0]), float(curves.x[-1]))
