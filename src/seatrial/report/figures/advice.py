# SPDX-License-Identifier: MIT
"""Time that further driving needs to halve an interval."""

from collections.abc import Sequence

import numpy as np

from seatrial.identification.experiment_design import ManoeuvreGain
from seatrial.report.figures.base import BLUE, ORANGE, Figure, figure, marks, named_rows

SHORTEST_SHOWN, LONGEST_SHOWN = 1.0, 36000.0  # [s]


def halving(found: Sequence[ManoeuvreGain]) -> Figure:
    """Seconds of the best manoeuvre until each parameter's interval is half as wide."""
    times = np.array([g.seconds for g in found])
    place, rows = named_rows([g.parameter for g in found])
    beyond = ~(times < LONGEST_SHOWN)
    near = np.column_stack([np.clip(times, SHORTEST_SHOWN, LONGEST_SHOWN), place])
    traces = [marks("halves the interval", near[~beyond], BLUE, "circle", size=9)]
    if beyond.any():
        traces.append(marks("not within 10 h", near[beyond], ORANGE, "x-thin-open", size=9))
    ticks = [1, 10, 60, 600, 3600, 36000]
    text = ["1 s", "10 s", "1 min", "10 min", "1 h", "10 h"]
    return figure(
        traces, "further driving [s, min, h]", "",
        xaxis={"type": "log", "tickvals": ticks, "ticktext": text, "range": [0.0, 4.7]},
        yaxis=rows, showlegend=True,
    )  # fmt: skip
