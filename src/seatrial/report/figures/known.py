# SPDX-License-Identifier: MIT
"""Relative error of each parameter."""

import numpy as np

from seatrial.identification.uncertainty.identifiability import Identifiability
from seatrial.identification.uncertainty.parameter_verdict import (
    SHARP_ERROR,
    USABLE_ERROR,
    ParameterVerdict,
)
from seatrial.report.figures.base import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    RED,
    Figure,
    figure,
    logarithmic,
    marks,
    named_rows,
    upright,
)
from seatrial.util.frames import Array

LOOKS = {  # of a verdict
    ParameterVerdict.SHARP: (BLUE, "circle"),
    ParameterVerdict.USABLE: (GREEN, "square"),
    ParameterVerdict.WEAK: (ORANGE, "diamond"),
    ParameterVerdict.ZERO: (PURPLE, "cross"),
    ParameterVerdict.LOST: (RED, "x-thin-open"),
}
LEAST_ERROR_SHOWN, LARGEST_ERROR_SHOWN = 0.01, 1000.0  # [%] of relative errors


def errors(found: Identifiability) -> Figure:
    """Relative standard errors [%], a row for each parameter, with the limits of the verdicts."""
    rows = [f for f in found.findings if f.verdict.estimated]
    share = np.clip([100.0 * f.relative for f in rows], LEAST_ERROR_SHOWN, LARGEST_ERROR_SHOWN)
    place, axis = named_rows([f.name for f in rows])
    traces = []
    for verdict, (colour, sign) in LOOKS.items():
        mine = np.array([f.verdict is verdict for f in rows])
        if mine.any():
            points = np.column_stack([share[mine], place[mine]])
            traces.append(marks(verdict.value, points, colour, sign, size=10) | {"opacity": 1.0})
    return figure(
        traces, "relative error [%]", "", xaxis=logarithmic(*reach(share)), yaxis=axis,
        shapes=[upright(100 * SHARP_ERROR, BLACK, "dash"), upright(100 * USABLE_ERROR, BLACK)],
        showlegend=True,
    )  # fmt: skip


def reach(share: Array) -> tuple[float, float]:
    """Range of an axis of relative errors [%]: all of them, and the limits of the verdicts."""
    if not len(share):
        return 1.0, 100.0
    low, high = float(share.min()), float(share.max())
    return max(LEAST_ERROR_SHOWN, 0.5 * min(low, 100 * SHARP_ERROR)), max(
        200 * USABLE_ERROR, 1.6 * high
    )
