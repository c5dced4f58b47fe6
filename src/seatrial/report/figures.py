# SPDX-License-Identifier: MIT
"""The report's plots as plain Plotly figures; `report.js` adds fonts, grids and dark colours."""

from html import escape
from typing import Any

import numpy as np

from seatrial.faults import FaultKind
from seatrial.frames import AXES, SYMBOLS, Array
from seatrial.model import Model
from seatrial.report.runs import Run
from seatrial.report.words import UNITS
from seatrial.statistics import autocorrelation, moving_average_band, white_band

Figure = dict[str, Any]

BLACK, ORANGE, SKY, GREEN, BLUE, RED, PURPLE = (
    "#000000", "#e69f00", "#56b4e9", "#009e73", "#0072b2", "#d55e00", "#cc79a7",
)  # Okabe and Ito (2008): told apart by colour-blind readers  # fmt: skip
SHADE = "rgba(0,114,178,0.15)"
FORCE_COLOURS = (BLUE, GREEN, PURPLE, ORANGE, SKY)
FORCE_SIGNS = ("circle", "cross", "diamond", "square", "triangle-up")
COMMAND = "F [command units]"
SPEED_UNITS = ("m/s", "m/s", "rad/s")
BINS = 41  # of a histogram
BIN_RANGE = 4.0  # standard deviations to either side that a histogram shows
SCATTER = 1500  # points of a scatter at most
LAGS = 3  # horizons that an autocorrelation reaches over


def forces_in(model: Model, axis: int) -> list[int]:
    """Places of the forces in an axis' equation, those along the axis first."""
    used = {f for t in model.structure.terms if t.axis == axis for f in t.factors}
    forces = model.structure.forces
    places = [i for i, f in enumerate(forces) if f.name in used]
    return sorted(places, key=lambda i: forces[i].axis != axis)


def figures(model: Model, run: Run) -> dict[str, Figure]:
    """All plots of one recording by name: `track`, and three or four for each axis."""
    found = {"track": track(run)}
    for axis, sign in enumerate(SYMBOLS):
        found[f"coverage-{sign}"] = coverage(model, run, axis)
        found[f"velocity-{sign}"] = velocity(model, run, axis)
        found[f"histogram-{sign}"] = histogram(run, axis)
        found[f"autocorrelation-{sign}"] = correlation(run, axis)
    return found


def track(run: Run) -> Figure:
    """Where the boat was [m], with left-out poses and jumps."""
    recording = run.recording
    left_out = recording.eta[~recording.valid, :2]
    left_out = left_out[np.isfinite(left_out).all(axis=1)]
    traces = [
        _line("track", run.position[:, 0], run.position[:, 1], BLUE),
        _marks("left out", left_out, ORANGE, "x-thin-open"),
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
            _marks("jump", jumps, RED, "diamond-open") | {"mode": "lines+markers", "line": look}
        )
    first = recording.eta[recording.valid][:1, :2]
    traces.append(_marks("start", first, GREEN, "circle", size=10))
    layout = {
        "xaxis": {"title": {"text": "x [m]"}},
        "yaxis": {"title": {"text": "y [m]"}, "scaleanchor": "x", "scaleratio": 1},
    }
    return {"data": traces, "layout": layout}


def coverage(model: Model, run: Run, axis: int) -> Figure:
    """Which speeds met which commands: where the model knows the boat."""
    good = np.flatnonzero(np.isfinite(run.measured[:, axis]))
    good = good[:: max(1, -(-len(good) // SCATTER))]
    traces = []
    for n, place in enumerate(forces_in(model, axis)):
        points = np.column_stack([run.forces[good, place], run.measured[good, axis]])
        colour = FORCE_COLOURS[n % len(FORCE_COLOURS)]
        name = _force(model, place)
        traces.append(_marks(name, points, colour, FORCE_SIGNS[n % len(FORCE_SIGNS)], size=4))
    layout = {
        "xaxis": {"title": {"text": COMMAND}},
        "yaxis": {"title": {"text": _speed(axis)}},
        "showlegend": True,
    }
    return {"data": traces, "layout": layout}


def velocity(model: Model, run: Run, axis: int) -> Figure:
    """Measured and predicted velocity above what drives the axis, Fig. 4."""
    traces = [
        _line("measured", run.t, run.measured[:, axis], BLACK),
        _line("predicted", run.t, run.predicted[:, axis], RED),
    ]
    for n, place in enumerate(forces_in(model, axis)):
        colour = FORCE_COLOURS[n % len(FORCE_COLOURS)]
        trace = _line(_force(model, place), run.t, run.forces[:, place], colour)
        trace["line"]["shape"] = "hv"
        traces.append(trace | {"yaxis": "y2"})
    layout = {
        "xaxis": {
            "title": {"text": "time [s]"},
            "range": list(run.window),
            "anchor": "y2",
        },
        "yaxis": {"title": {"text": _speed(axis)}, "domain": [0.38, 1.0]},
        "yaxis2": {"title": {"text": COMMAND}, "domain": [0.0, 0.3]},
        "hovermode": "x",
    }
    return {"data": traces, "layout": layout}


def histogram(run: Run, axis: int) -> Figure:
    """Errors over the whole run beside a normal curve of the same mean and spread."""
    name, scale = UNITS[axis]
    errors = run.prediction.errors[:, axis] * scale
    spread, mean = float(np.std(errors)), float(np.mean(errors))
    title = {"text": f"error in {SYMBOLS[axis]} [{name}]"}
    layout: Figure = {
        "xaxis": {"title": title},
        "yaxis": {"title": {"text": "share of errors [%]"}, "rangemode": "tozero"},
        "bargap": 0.06,
    }
    if not (np.isfinite(spread) and spread > 0):
        return {"data": [], "layout": layout}
    edges = mean + np.linspace(-BIN_RANGE, BIN_RANGE, BINS + 1) * spread
    share = 100.0 * np.histogram(errors, edges)[0] / len(errors)
    middle = 0.5 * (edges[1:] + edges[:-1])
    x = mean + np.linspace(-BIN_RANGE, BIN_RANGE, 161) * spread
    density = np.exp(-0.5 * ((x - mean) / spread) ** 2) / (spread * np.sqrt(2 * np.pi))
    bars = {"type": "bar", "name": "errors", "x": middle, "y": share, "marker": {"color": SKY}}
    curve = _line("normal", x, 100.0 * (edges[1] - edges[0]) * density, RED)
    return {"data": [bars, curve], "layout": layout}


def correlation(run: Run, axis: int) -> Figure:
    """Autocorrelation of the errors with the bands of white and of overlapping ones, Fig. 7."""
    found = run.prediction
    errors, steps, samples = found.errors[:, axis], found.steps, len(found.t)
    layout: Figure = {
        "xaxis": {"title": {"text": "lag [s]"}, "rangemode": "tozero"},
        "yaxis": {"title": {"text": "autocorrelation [–]"}},
    }
    if not np.isfinite(errors).all():
        return {"data": [], "layout": layout}
    index = found.index
    lags = min(LAGS * steps, int(index.max() - index.min()))
    rho = autocorrelation(errors, index, lags)
    lag = np.arange(lags + 1.0) * run.recording.period
    band = moving_average_band(rho, steps, samples)
    white = np.full(2, white_band(samples))
    ends = lag[[0, -1]]
    outline = np.concatenate([band, -band[::-1]])
    area = _line("overlapping", np.concatenate([lag, lag[::-1]]), outline, BLUE)
    area |= {"fill": "toself", "fillcolor": SHADE, "line": {"width": 0}, "hoverinfo": "skip"}
    dashed = {"color": GREEN, "width": 1.5, "dash": "dash"}
    upper = _line("white", ends, white, GREEN) | {"line": dashed, "legendgroup": "white"}
    lower = upper | {"y": -white, "showlegend": False}
    reach = steps * run.recording.period
    dotted = {"color": ORANGE, "width": 1.5, "dash": "dot"}
    layout["shapes"] = [
        {
            "type": "line",
            "x0": reach,
            "x1": reach,
            "yref": "paper",
            "y0": 0,
            "y1": 1,
            "line": dotted,
        }
    ]
    curve = _line("errors", lag, rho, RED)
    return {"data": [curve, area, upper, lower], "layout": layout}


def _line(name: str, x: Array, y: Array, colour: str) -> Figure:
    look = {"color": colour, "width": 1.5}
    return {"type": "scatter", "mode": "lines", "name": name, "x": x, "y": y, "line": look}


def _marks(name: str, points: Array, colour: str, sign: str, size: int = 7) -> Figure:
    look = {"color": colour, "symbol": sign, "size": size}
    if sign.endswith("open"):
        look["line"] = {"color": colour, "width": 1.5}
    return {
        "type": "scatter", "mode": "markers", "name": name,
        "x": points[:, 0], "y": points[:, 1], "marker": look, "opacity": 0.8,
    }  # fmt: skip


def _force(model: Model, place: int) -> str:
    """A force's name with Plotly's subscripts; what the user wrote stays text."""
    head, _, tail = model.structure.forces[place].name.partition("_")
    return escape(head) + (f"<sub>{escape(tail)}</sub>" if tail else "")


def _speed(axis: int) -> str:
    return f"{AXES[axis]} {SYMBOLS[axis]} [{SPEED_UNITS[axis]}]"
