# SPDX-License-Identifier: MIT
"""Plots of two models."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import driven
from seatrial.evaluation.comparison.parameters import Pair
from seatrial.evaluation.scores import Scored, main_start
from seatrial.identification.uncertainty.identifiability import Identifiability
from seatrial.identification.uncertainty.parameter_verdict import SHARP_ERROR, USABLE_ERROR
from seatrial.report.comparison.two_models import LETTERS, MODEL_COLOURS, MODEL_DASHES, MODEL_SIGNS
from seatrial.report.evidence.actuators import Curve
from seatrial.report.evidence.runs import Run
from seatrial.report.figures.base import (
    BLACK,
    GREEN,
    ORANGE,
    PURPLE,
    Figure,
    area,
    figure,
    line,
    logarithmic,
    marks,
    named_rows,
    speed,
    upright,
    whiskers,
)
from seatrial.report.figures.known import LARGEST_ERROR_SHOWN, LEAST_ERROR_SHOWN, reach
from seatrial.report.figures.prediction import above_commands, over_horizons, rms_line
from seatrial.util.frames import ERROR_UNITS, SYMBOLS
from seatrial.util.statistics import NORMAL_95

COMMAND_COLOURS = (GREEN, PURPLE, ORANGE, BLACK)  # other than those of the models
LARGEST_CHANGE_SHOWN = 120.0  # [%]


def estimated_names(known: tuple[Identifiability, Identifiability]) -> list[str]:
    """Parameters that either has estimated."""
    return list(dict.fromkeys(f.name for one in known for f in one.findings if f.verdict.estimated))


def relative_errors(known: tuple[Identifiability, Identifiability]) -> Figure:
    """Relative standard errors [%] of the parameters of either."""
    names = estimated_names(known)
    place, rows = named_rows(names)
    traces, shares = [], [np.zeros(0)]
    for one, letter, colour, sign in zip(known, LETTERS, MODEL_COLOURS, MODEL_SIGNS, strict=True):
        own = {f.name: 100.0 * f.relative for f in one.findings if f.verdict.estimated}
        points = [
            (np.clip(own[n], LEAST_ERROR_SHOWN, LARGEST_ERROR_SHOWN), y)
            for n, y in zip(names, place, strict=True)
            if n in own
        ]
        if points:
            shares.append(np.array(points)[:, 0])
            traces.append(marks(letter, np.array(points), colour, sign, size=9) | {"opacity": 1.0})
    return figure(
        traces, "relative error [%]", "",
        xaxis=logarithmic(*reach(np.concatenate(shares))), yaxis=rows, showlegend=True,
        shapes=[upright(100 * SHARP_ERROR, BLACK, "dash"), upright(100 * USABLE_ERROR, BLACK)],
    )  # fmt: skip


def differences(found: Sequence[Pair]) -> Figure:
    """B less A in standard errors of the difference, with the 95 % limits of one test."""
    tested = [pair for pair in found if pair.z is not None]
    place, rows = named_rows([pair.name for pair in tested])
    points = np.column_stack([np.array([pair.z for pair in tested], dtype=float), place])
    changed = np.array([pair.differs for pair in tested], dtype=bool)
    traces = [
        marks("not significant", points[~changed], MODEL_COLOURS[0], "circle", size=9),
        marks("significant (Holm)", points[changed], MODEL_COLOURS[1], "diamond", size=11),
    ]
    reach = 1.1 * max(4.0, float(np.abs(points[:, 0]).max(initial=0.0)))
    return figure(
        traces, "(B − A) / its standard error [–]", "", yaxis=rows,
        xaxis={"range": [-reach, reach]}, showlegend=True,
        shapes=[upright(0.0, BLACK, "solid"), upright(NORMAL_95, BLACK), upright(-NORMAL_95, BLACK)],
    )  # fmt: skip


def changes(found: Sequence[Pair]) -> Figure:
    """Change of each parameter from A to B relative to A's value [%], with 95 % intervals."""
    tested = [pair for pair in found if pair.z is not None and pair.a]
    place, rows = named_rows([pair.name for pair in tested])
    size = np.array([abs(pair.a) for pair in tested])
    x = 100.0 * np.array([abs(pair.b) - abs(pair.a) for pair in tested]) / size
    half = 100.0 * NORMAL_95 * np.array([pair.error for pair in tested]) / size
    changed = np.array([pair.differs for pair in tested], dtype=bool)
    reach = min(1.15 * float(np.max(np.abs(x) + half, initial=10.0)), LARGEST_CHANGE_SHOWN)
    within, traces = np.abs(x) < reach, []
    for name, mine, colour, sign in (
        ("not significant", ~changed & within, MODEL_COLOURS[0], "circle"),
        ("significant (Holm)", changed & within, MODEL_COLOURS[1], "diamond"),
        ("beyond the axis", ~within, PURPLE, "cross"),
    ):
        if mine.any():
            shown = np.clip(x[mine], -0.97 * reach, 0.97 * reach)
            trace = marks(name, np.column_stack([shown, place[mine]]), colour, sign, size=9)
            ends = whiskers(x[mine], (x - half)[mine], (x + half)[mine], colour)
            traces.append(trace | {"opacity": 1.0} | ({"error_x": ends} if sign != "cross" else {}))
    return figure(
        traces, "change of its size from A to B [%]", "", yaxis=rows, xaxis={"range": [-reach, reach]},
        showlegend=True, shapes=[upright(0.0, BLACK, "solid")],
    )  # fmt: skip


def curves(found: Sequence[Sequence[Curve]], x: str, y: str, limits: Figure) -> Figure:
    """Curves of the thrusters of both; a colour for each model, a dash for each curve."""
    traces = []
    for own, letter, colour in zip(found, LETTERS, MODEL_COLOURS, strict=True):
        for i, one in enumerate(own[:4]):
            name = f"{letter}: {one.label}"
            if (one.high > one.low).any():
                band = area(name, one.x, one.low, one.high, colour)
                traces.append(band | {"showlegend": False})
            dash = ("solid", "dash", "dot", "solid")[i]
            traces.append(line(name, one.x, one.y, colour, dash=dash, width=2.0 if i < 3 else 1.0))
    return figure(traces, x, y, showlegend=True, **limits)


def horizons(rows: tuple[Sequence[Scored], Sequence[Scored]], axis: int) -> Figure:
    """RMS errors of both against the horizon, with intervals."""
    scale, symbol = ERROR_UNITS[axis][1], SYMBOLS[axis]
    traces = []
    kinds = [main_start(own) for own in rows]
    start = kinds[0] if kinds[0] == kinds[1] else "stencil"
    every = [[row for row in own if row.start == start] for own in rows]
    for own, letter, colour, sign in zip(every, LETTERS, MODEL_COLOURS, MODEL_SIGNS, strict=True):
        if not own:
            continue
        x = np.array([row.horizon for row in own])
        traces.append(rms_line(letter, own, axis, colour, sign))
        floor = scale * np.array([row.scores[symbol].floor for row in own])
        traces.append(line(f"noise floor of {letter}", x, floor, colour, dash="dot"))
    return over_horizons(traces, every[0] or every[1], axis)


def velocity(model: Model, runs: tuple[Run, Run], axis: int) -> Figure:
    """Measured velocity, predicted by both, above the forces of the axis."""
    run = runs[0]
    at = run.shown
    traces = [line("measured", run.t[at], run.measured[at, axis], BLACK)]
    for own, letter, colour in zip(runs, LETTERS, MODEL_COLOURS, strict=True):
        if own.tested:
            traces.append(line(letter, own.t[at], own.predicted[at, axis], colour))
    return above_commands(traces, model, run, axis, COMMAND_COLOURS)


def overlaid(figures: Sequence[Figure]) -> Figure:
    """The same plot of both models in one: of each the trace `errors`, and A's bands."""
    traces: list[Figure] = []
    for i, (one, letter) in enumerate(zip(figures, LETTERS, strict=False)):
        for trace in one["data"]:
            own = trace["name"] == "errors"
            if own:
                look = {"color": MODEL_COLOURS[i], "width": 2.0, "dash": MODEL_DASHES[i]}
                more = {"type": "scatter", "mode": "lines", "name": letter, "line": look}
                traces.append({k: trace[k] for k in ("x", "y")} | more)
            elif i == 0:
                traces.append(trace)
    return {"data": traces, "layout": figures[0]["layout"] | {"showlegend": True}}


def start_and_stop(models: tuple[Model, Model], axis: int, until: float) -> Figure:
    """Speed from rest under the largest command of each, then without any, until [s]."""
    traces = []
    for model, letter, colour in zip(models, LETTERS, MODEL_COLOURS, strict=True):
        t, v = driven(model, axis)
        half = float(t[-1]) / 2.0
        first, second = t <= until, (t >= half) & (t <= half + 2.0 * until)
        traces.append(line(f"{letter}: command on at 0 s", t[first], v[first], colour, width=2.0))
        trace = line(f"{letter}: off", t[second] - half, v[second], colour, dash="dash", width=2.0)
        traces.append(trace)
    return figure(traces, "time [s]", speed(axis), showlegend=True, yaxis={"rangemode": "tozero"})
