# SPDX-License-Identifier: MIT
"""Homogeneity across recordings: scores and own estimates of each."""

from collections.abc import Sequence

import numpy as np

from seatrial.report.evidence.homogeneity import Homogeneity
from seatrial.report.evidence.runs import Run
from seatrial.report.figures.base import (
    BLACK,
    SIGNS,
    Figure,
    colour_of,
    figure,
    level,
    marks,
    named_rows,
    shortened,
    upright,
    whiskers,
)
from seatrial.util.frames import AXES, SYMBOLS

LABEL_LETTERS = 48  # that fit below a plot
ROW_SHARE = 0.7  # of a row that its marks take
AXIS_COLOURS = (0, 1, 2)  # of surge, sway and yaw


def scores(runs: Sequence[Run]) -> Figure:
    """RMS error over that of constant velocity, by recording and axis, with 95 % intervals."""
    tested = [run for run in runs if run.tested]
    most = max(16, LABEL_LETTERS // max(1, len(tested)))
    traces = []
    for axis, symbol in enumerate(SYMBOLS):
        found = [run.score.scores[symbol] for run in tested]
        y = np.array([s.ratio for s in found])
        ends = [s.ratio_interval or (s.ratio, s.ratio) for s in found]
        x = np.arange(len(tested)) + 0.2 * (axis - 1)
        colour, _ = colour_of(AXIS_COLOURS[axis])
        low, high = np.array(ends).reshape(-1, 2).T
        trace = marks(AXES[axis], np.column_stack([x, y]), colour, SIGNS[axis], size=9)
        traces.append(trace | {"opacity": 1.0, "error_y": whiskers(y, low, high, colour)})
    return figure(
        traces, "", "RMS error / constant velocity's [–]",
        xaxis={
            "tickvals": list(range(len(tested))), "ticktext": [shortened(run.name, most) for run in tested],
            "range": [-0.6, len(tested) - 0.4],
        },
        yaxis={"rangemode": "tozero"}, shapes=[level(1.0, BLACK, "dash")], showlegend=True,
    )  # fmt: skip


def parameters(found: Homogeneity) -> Figure:
    """Each recording's own estimate of each parameter, relative to the model's value [%]."""
    count = len(found.recordings)
    traces = []
    for i, recording in enumerate(found.recordings):
        rows = [(k, row.shifts[i], row.errors[i]) for k, row in enumerate(found.rows)]
        shown = np.array([r for r in rows if np.isfinite(r[2])]).reshape(-1, 3)
        if not len(shown):
            continue
        offset = ROW_SHARE * ((i + 0.5) / count - 0.5)
        colour, _ = colour_of(i)
        y, x, half = -shown[:, 0] - offset, 100.0 * shown[:, 1], 196.0 * shown[:, 2]
        trace = marks(recording, np.column_stack([x, y]), colour, SIGNS[i % len(SIGNS)], size=7)
        traces.append(trace | {"opacity": 1.0, "error_x": whiskers(x, x - half, x + half, colour)})
    return figure(
        traces, "difference from the model's value [%]", "", yaxis=named_rows([row.name for row in found.rows])[1],
        shapes=[upright(0.0, BLACK, "dash")], showlegend=True,
    )  # fmt: skip
