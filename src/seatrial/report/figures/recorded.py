# SPDX-License-Identifier: MIT
"""Plots of recordings: tracks, usable intervals, coverage of speeds and commands."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.report.evidence.runs import Run
from seatrial.report.figures.base import (
    BLUE,
    COMMAND,
    FORCE_COLOURS,
    GREEN,
    ORANGE,
    PURPLE,
    RED,
    SIGNS,
    SKY,
    Figure,
    colour_of,
    figure,
    force_name,
    forces_in,
    line,
    marks,
    shortened,
    speed,
)
from seatrial.util.frames import Array

SCATTER = 1000  # points of a scatter at most
# part of the longest recording to which shorter gaps are widened, to be visible
SHORTEST_GAP = 150.0
MARGIN = 0.05  # of the tracks, left and right of them
TRACKS = 6000  # points of all tracks together
COVERAGE_CELLS = 12  # of the coverage, each way
LARGEST, SMALLEST = 17.0, 3.5  # [px] mark of the cell with most and with least time
MARK_POWER = 0.3  # of the time, so that marks of short times stay visible
MISSING = (  # kinds of missing data, and their colours
    ("excluded poses", {FaultKind.MARKED, FaultKind.NOT_FINITE, FaultKind.STAMP, FaultKind.FROZEN}, ORANGE),
    ("jumps", {FaultKind.EXCURSION, FaultKind.JUMP}, RED),
    ("no poses", {FaultKind.GAP}, PURPLE),
    ("excluded (--without)", {FaultKind.EXCLUDED}, GREEN),
    ("no commands", {FaultKind.SILENT, FaultKind.NO_NUMBER, FaultKind.PAUSED}, SKY),
)  # fmt: skip


def track(run: Run) -> Figure:
    """Track [m], with excluded poses and jumps."""
    recording = run.recording
    excluded = recording.eta[~recording.valid, :2]
    excluded = excluded[np.isfinite(excluded).all(axis=1)]
    traces = [
        line("track", run.position[run.shown, 0], run.position[run.shown, 1], BLUE),
        marks("excluded", excluded, ORANGE, "x-thin-open"),
    ]
    ends = [(f.start, f.end) for f in recording.faults if f.kind is FaultKind.JUMP]
    if ends:
        place = np.searchsorted(recording.t, np.array(ends) - 1e-9)
        place = np.minimum(place, len(recording.t) - 1)
        corners = np.full((len(ends), 3, 2), np.nan)
        corners[:, :2] = recording.eta[place, :2]
        jumps = corners.reshape(-1, 2)
        look = {"color": RED, "width": 1, "dash": "dot"}
        traces.append(
            marks("jump", jumps, RED, "diamond-open") | {"mode": "lines+markers", "line": look}
        )
    first = recording.eta[recording.valid][:1, :2]
    traces.append(marks("start", first, GREEN, "circle", size=10))
    return _plan(traces)


def tracks(runs: Sequence[Run]) -> Figure:
    """All recordings in one plan [m]."""
    traces = []
    for i, run in enumerate(runs):
        colour, dash = colour_of(i)
        thin = run.position[:: max(1, -(-len(run.position) * len(runs) // TRACKS))]
        traces.append(line(run.name, thin[:, 0], thin[:, 1], colour, dash=dash, width=1.2))
    return _plan(traces)


def _plan(traces: Sequence[Figure]) -> Figure:
    every = np.concatenate(
        [np.zeros(0), *(np.asarray(trace["x"], dtype=float) for trace in traces)]
    )
    every = every[np.isfinite(every)]
    room = MARGIN * float(np.ptp(every)) if len(every) else 0.0
    wide: Figure = {"range": [every.min() - room, every.max() + room]} if room > 0 else {}
    return figure(
        traces,
        "x [m]",
        "y [m]",
        xaxis=wide,
        yaxis={"scaleanchor": "x", "scaleratio": 1},
        showlegend=True,
    )


def timeline(runs: Sequence[Run]) -> Figure:
    """When poses and commands were usable, recording by recording."""
    places = -np.arange(len(runs), dtype=float)
    spans = [np.array([0.0, run.recording.duration, np.nan]) for run in runs]
    rows = np.repeat(places, 3)
    longest = max(run.recording.duration for run in runs)
    traces = [line("recorded", np.concatenate(spans), rows, BLUE, width=8.0)]
    for name, kinds, colour in MISSING:
        found = [
            (f.start, max(f.end, f.start + longest / SHORTEST_GAP), place)
            for run, place in zip(runs, places.tolist(), strict=True)
            for f in run.recording.faults
            if f.kind in kinds
        ]
        if found:
            x = np.array([[a, b, np.nan] for a, b, _ in found]).ravel()
            y = np.array([[p, p, np.nan] for _, _, p in found]).ravel()
            trace = line(name, x, y, colour, width=14.0)
            trace["line"]["simplify"] = False  # Plotly would drop the short ones
            traces.append(trace)
    ticks = {"tickvals": places.tolist(), "ticktext": [shortened(run.name, 18) for run in runs]}
    return figure(
        traces, "time [s]", "recording []",
        yaxis={**ticks, "range": [-len(runs) + 0.4, 0.6], "zeroline": False, "title": {"text": ""}},
        showlegend=True,
    )  # fmt: skip


def cells(model: Model, runs: Sequence[Run], axis: int) -> Figure:
    """Time [s] at each speed and command of the axis' own force, as the size of marks."""
    places = forces_in(model, axis)
    layout: Figure = {"showlegend": True, "legend": {"itemsizing": "constant"}}
    if not places:
        return figure([], COMMAND, speed(axis), **layout)
    own = [np.column_stack([run.forces[:, places[0]], run.measured[:, axis]]) for run in runs]
    every = np.concatenate(own)
    every = every[np.isfinite(every).all(axis=1)]
    if not len(every):
        return figure([], COMMAND, speed(axis), **layout)
    reach = np.maximum(np.abs(every).max(axis=0), 1e-9)
    edges = [np.linspace(-r, r, COVERAGE_CELLS + 1) for r in reach]
    counts = [_seconds(points, run, edges) for points, run in zip(own, runs, strict=True)]
    most = float(np.sum(counts, axis=0).max())
    middle = [0.5 * (e[1:] + e[:-1]) for e in edges]
    x, y = (part.ravel() for part in np.meshgrid(*middle, indexing="ij"))
    traces = []
    for name, unseen, colour, sign in (
        ("identified from", False, BLUE, "square"), ("not seen", True, RED, "circle-open"),
    ):  # fmt: skip
        mine = [c for c, run in zip(counts, runs, strict=True) if run.unseen is unseen]
        if not mine:
            continue
        seconds = np.sum(mine, axis=0).ravel()
        visited = seconds > 0
        size = np.maximum(LARGEST * (seconds[visited] / most) ** MARK_POWER, SMALLEST)
        trace = marks(name, np.column_stack([x[visited], y[visited]]), colour, sign)
        trace["marker"] |= {"size": size.round(1).tolist()}
        trace["text"] = [f"{s:.1f} s" for s in seconds[visited].tolist()]
        traces.append(trace)
    return figure(traces, f"{force_name(model, places[0])} [command units]", speed(axis), **layout)


def _seconds(points: Array, run: Run, edges: Sequence[Array]) -> Array:
    good = points[np.isfinite(points).all(axis=1)]
    return np.asarray(np.histogram2d(good[:, 0], good[:, 1], list(edges))[0] * run.recording.period)


def coverage(model: Model, run: Run, axis: int) -> Figure:
    """Coverage: speed against command."""
    good = np.flatnonzero(np.isfinite(run.measured[:, axis]))
    good = good[:: max(1, -(-len(good) // SCATTER))]
    traces = []
    for n, place in enumerate(forces_in(model, axis)):
        points = np.column_stack([run.forces[good, place], run.measured[good, axis]])
        colour = FORCE_COLOURS[n % len(FORCE_COLOURS)]
        trace = marks("", points, colour, SIGNS[n % len(SIGNS)], size=4)
        traces.append(trace | {"name": force_name(model, place)})
    return figure(traces, COMMAND, speed(axis), showlegend=True)
