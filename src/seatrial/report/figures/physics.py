# SPDX-License-Identifier: MIT
"""Start from rest and stop."""

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import RUN, driven
from seatrial.report.evidence.physics import Spread
from seatrial.report.figures.base import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    Figure,
    figure,
    line,
    speed,
    upright,
)

RISE_TIMES_SHOWN = 6.0  # of start and of stop


def start_and_stop(model: Model, found: Spread) -> Figure:
    """Speed from rest under the largest command, then without any; top speed, 63 % of it."""
    t, v = driven(model, found.axis)
    one = found.found
    shown = float(np.clip(RISE_TIMES_SHOWN * one.rise_time, 2.0, RUN))
    first, second = t <= shown, (t >= RUN) & (t <= RUN + 2.0 * shown)
    traces = [
        line("command on at 0 s", t[first], v[first], BLUE, width=2.0),
        line("command off at 0 s", t[second] - RUN, v[second], GREEN, dash="dash", width=2.0),
        line(
            "top speed", np.array([0.0, 2.0 * shown]), np.full(2, one.top_speed), ORANGE, dash="dot"
        ),
    ]
    return figure(
        traces, "time [s]", speed(found.axis), shapes=[upright(one.rise_time, BLACK)],
        showlegend=True, yaxis={"rangemode": "tozero"},
    )  # fmt: skip
