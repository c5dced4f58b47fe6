# SPDX-License-Identifier: MIT
"""Measured and predicted velocity, and errors against the horizon."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.evaluation.scores import Scored, main_start
from seatrial.report.evidence.runs import PICTURE_WINDOW, Run, busy_window
from seatrial.report.figures.base import (
    BLACK,
    BLUE,
    COMMAND,
    FORCE_COLOURS,
    GREEN,
    ORANGE,
    RED,
    Figure,
    driven_axes,
    figure,
    force_name,
    forces_in,
    line,
    room_for,
    speed,
    whiskers,
)
from seatrial.util.frames import ERROR_UNITS, SPEED_UNITS, SYMBOLS, Array

PICTURE_MARGIN = {"l": 52, "r": 10, "t": 24, "b": 38}  # [px]
PANEL_GAP = 0.05  # [share of the height] between panels of a picture
START_KINDS = (
    ("stencil", "measured start", BLUE, "square"),
    ("filter", "filter start", RED, "circle"),
    ("odometry", "odometry", GREEN, "diamond"),
)


def velocity(model: Model, run: Run, axis: int) -> Figure:
    """Measured and predicted velocity above the forces of the axis, Fig. 4."""
    at = run.shown
    traces = [line("measured", run.t[at], run.measured[at, axis], BLACK)]
    if run.tested:
        traces.append(line("predicted", run.t[at], run.predicted[at, axis], RED))
    return above_commands(traces, model, run, axis, FORCE_COLOURS)


def picture(model: Model, run: Run, predictions: Sequence[tuple[str, Array, str]]) -> Figure:
    """Measured and predicted velocity of every driven axis, one above the other, over the busiest minute.

    predictions: of each its name, velocities (n, 3) and colour.
    """
    usable = np.isfinite(np.sum([p[1] for p in predictions], axis=0)[:, 0]) if predictions else (
        np.isfinite(run.measured[:, 0])
    )  # fmt: skip
    begin, end = busy_window(run.t, usable, run.forces, PICTURE_WINDOW)
    at = np.flatnonzero((run.t >= begin) & (run.t <= end))
    axes = driven_axes(model)
    each = 1.0 / len(axes)
    traces, panels = [], {}
    for k, axis in enumerate(axes):
        key = "" if k == 0 else f"{k + 1}"
        low = 1.0 - (k + 1) * each + (PANEL_GAP if k < len(axes) - 1 else 0.0)
        panels[f"yaxis{key}"] = {
            "title": {"text": f"{SYMBOLS[axis]} [{SPEED_UNITS[axis]}]"}, "domain": [low, 1.0 - k * each],
        }  # fmt: skip
        own = [line("measured", run.t[at], run.measured[at, axis], BLACK, width=3.0)]
        own += [line(n, run.t[at], v[at, axis], c, width=1.6) for n, v, c in predictions]
        traces += [
            t | {"yaxis": f"y{key}", "showlegend": k == 0, "legendgroup": t["name"]} for t in own
        ]
    last = f"y{len(axes)}" if len(axes) > 1 else "y"
    return figure(
        traces, "time [s]", "", **panels, hovermode="x", showlegend=True, margin=PICTURE_MARGIN,
        xaxis={"range": [begin, end], "anchor": last},
    )  # fmt: skip


def above_commands(
    traces: Sequence[Figure], model: Model, run: Run, axis: int, colours: Sequence[str]
) -> Figure:
    """Traces of one velocity over time, and below them the forces of the axis."""
    at, below = run.shown, []
    for n, place in enumerate(forces_in(model, axis)):  # none: no panel below
        trace = line("", run.t[at], run.forces[at, place], colours[n % len(colours)])
        trace["line"]["shape"] = "hv"
        below.append(trace | {"yaxis": "y2", "name": force_name(model, place)})
    if not below:
        return figure(
            traces, "time [s]", speed(axis), xaxis={"range": list(run.window)}, hovermode="x", showlegend=True
        )  # fmt: skip
    return figure(
        [*traces, *below], "time [s]", speed(axis), showlegend=True,
        xaxis={"range": list(run.window), "anchor": "y2"}, yaxis={"domain": [0.38, 1.0]},
        yaxis2={"title": {"text": COMMAND}, "domain": [0.0, 0.3]}, hovermode="x",
    )  # fmt: skip


def horizons(rows: Sequence[Scored], axis: int) -> Figure:
    """RMS error against the horizon with 95 % intervals, noise floor, expected RMS, constant velocity."""
    scale, traces = ERROR_UNITS[axis][1], []
    for start, label, colour, sign in START_KINDS:
        own = [row for row in rows if row.start == start]
        if not own:
            continue
        scores = [row.scores[SYMBOLS[axis]] for row in own]
        x = np.array([row.horizon for row in own])
        first = start == main_start(rows)
        traces.append(rms_line(label, own, axis, colour, sign))
        if start == "odometry":  # nearly the filter's floor
            continue
        floor = scale * np.array([s.floor for s in scores])
        traces.append(line("noise floor", x, floor, colour, dash="dot") | {"showlegend": first})
        expected = [s.expected_rms for s in scores if s.expected_rms is not None]
        if len(expected) == len(scores):
            trace = line("expected RMS", x, scale * np.array(expected), colour, dash="dashdot")
            traces.append(trace | {"showlegend": first})
    return over_horizons(traces, [row for row in rows if row.start == main_start(rows)], axis)


def rms_line(label: str, rows: Sequence[Scored], axis: int, colour: str, sign: str) -> Figure:
    """RMS errors of one start against the horizon, with 95 % intervals."""
    scale = ERROR_UNITS[axis][1]
    scores = [row.scores[SYMBOLS[axis]] for row in rows]
    rms = scale * np.array([s.rms for s in scores])
    low, high = scale * np.array([s.rms_interval or (s.rms, s.rms) for s in scores]).T
    look = {"color": colour, "symbol": sign, "size": 8}
    trace = line(label, np.array([row.horizon for row in rows]), rms, colour)
    ends = whiskers(rms, low, high, colour)
    return trace | {"mode": "lines+markers", "marker": look, "error_y": ends}


def over_horizons(traces: Sequence[Figure], still: Sequence[Scored], axis: int) -> Figure:
    """Errors against the horizon, with those of constant velocity by `still`."""
    name, scale = ERROR_UNITS[axis]
    values = scale * np.array([row.scores[SYMBOLS[axis]].stays_constant for row in still])
    x = np.array([row.horizon for row in still])
    traces = [*traces, line("constant velocity", x, values, ORANGE, dash="dash")]
    ticks = x.tolist()
    return figure(
        traces, "horizon [s]", f"RMS error of {SYMBOLS[axis]} [{name}]",
        xaxis={"type": "log", "tickvals": ticks, "ticktext": [f"{t:g}" for t in ticks]},
        yaxis=room_for(traces), showlegend=True,
    )  # fmt: skip
