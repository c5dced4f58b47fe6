# SPDX-License-Identifier: MIT
"""Plots of residuals: histogram, autocorrelation, correlation with commands and forces."""

import numpy as np

from seatrial.boat.model import Model
from seatrial.evaluation.residuals import REACH
from seatrial.report.evidence.runs import Run
from seatrial.report.figures.base import (
    BLACK,
    BLUE,
    FORCE_COLOURS,
    GREEN,
    ORANGE,
    RED,
    SIGNS,
    SKY,
    Figure,
    area,
    figure,
    force_name,
    forces_in,
    level,
    line,
    upright,
    whiskers,
)
from seatrial.report.text.names import plotly_symbol
from seatrial.util.frames import ERROR_UNITS, SYMBOLS
from seatrial.util.statistics import NORMAL_95, autocorrelation, moving_average_band, white_band

BINS = 41  # of a histogram
BIN_RANGE = 4.0  # standard deviations to either side that a histogram shows
LAGS = 3  # horizons that an autocorrelation reaches over
GROUPS = 9  # of a command, in each of which errors are averaged
FEWEST_INDEPENDENT = 3  # predictions without overlap in a mean


def histogram(run: Run, axis: int) -> Figure:
    """Errors over the whole run beside a normal curve of the same mean and spread."""
    name, scale = ERROR_UNITS[axis]
    errors = run.prediction.errors[:, axis] * scale
    spread, mean = float(np.std(errors)), float(np.mean(errors))
    titles = f"error in {SYMBOLS[axis]} [{name}]", "share of errors [%]"
    layout: Figure = {"yaxis": {"rangemode": "tozero"}, "bargap": 0.06, "showlegend": True}
    if not (np.isfinite(spread) and spread > 0):
        return figure([], *titles, **layout)
    edges = mean + np.linspace(-BIN_RANGE, BIN_RANGE, BINS + 1) * spread
    share = 100.0 * np.histogram(errors, edges)[0] / len(errors)
    middle = 0.5 * (edges[1:] + edges[:-1])
    x = mean + np.linspace(-BIN_RANGE, BIN_RANGE, 161) * spread
    density = np.exp(-0.5 * ((x - mean) / spread) ** 2) / (spread * np.sqrt(2 * np.pi))
    bars = {"type": "bar", "name": "errors", "x": middle, "y": share, "marker": {"color": SKY}}
    curve = line("normal", x, 100.0 * (edges[1] - edges[0]) * density, RED)
    return figure([bars, curve], *titles, **layout)


def outline(run: Run, axis: int) -> Figure:
    """Errors over the whole run as a line, for two models in one plot."""
    name, scale = ERROR_UNITS[axis]
    errors = run.prediction.errors[:, axis] * scale
    reach = BIN_RANGE * float(np.sqrt(np.mean(errors**2)))
    share, edges = np.histogram(errors, np.linspace(-reach, reach, BINS + 1) if reach > 0 else BINS)
    middle = 0.5 * (edges[1:] + edges[:-1])
    density = share / (len(errors) * (edges[1] - edges[0]))
    unit = f"density of errors [1/({name})]"
    return figure(
        [line("errors", middle, density, RED)],
        f"error in {SYMBOLS[axis]} [{name}]",
        unit,
        showlegend=True,
    )


def correlation(run: Run, axis: int) -> Figure:
    """Autocorrelation of the errors with the bands of white and of overlapping ones, Fig. 7."""
    found = run.prediction
    errors, steps, samples = found.errors[:, axis], found.steps, len(found.t)
    titles = "lag [s]", f"autocorrelation of {SYMBOLS[axis]} [–]"
    layout: Figure = {"xaxis": {"rangemode": "tozero"}, "showlegend": True}
    if not np.isfinite(errors).all():
        return figure([], *titles, **layout)
    index = found.index
    lags = min(LAGS * steps, int(index.max() - index.min()))
    rho = autocorrelation(errors, index, lags)
    lag = np.arange(lags + 1.0) * run.recording.period
    band = moving_average_band(rho, steps, samples)
    white = np.full(2, white_band(samples))
    ends = lag[[0, -1]]
    upper = line("white", ends, white, GREEN, dash="dash") | {"legendgroup": "white"}
    lower = upper | {"y": -white, "showlegend": False}
    reach = upright(steps * run.recording.period, ORANGE)
    traces = [line("errors", lag, rho, RED), area("overlap", lag, -band, band, BLUE), upper, lower]
    return figure(traces, *titles, **layout, shapes=[reach])


def residual_correlations(run: Run, axis: int) -> Figure:
    """Correlation of the filter's innovations with every force, over lags."""
    own = [c for c in run.correlations if c.residual == SYMBOLS[axis]]
    traces, shapes = [], []
    for i, found in enumerate(own):
        values = np.array(found.values)
        lag = found.step * np.arange(-(len(values) // 2), len(values) // 2 + 1.0)
        colour = FORCE_COLOURS[i % len(FORCE_COLOURS)]
        traces.append(line("", lag, values, colour) | {"name": plotly_symbol(found.force)})
    if own:
        limit = max(c.limit for c in own)
        shapes = [level(side * limit, BLACK, "dash") for side in (1.0, -1.0)]
        shapes += [level(side * max(c.band for c in own), GREEN) for side in (1.0, -1.0)]
    return figure(
        traces, "lag behind the force [s]", f"correlation of {SYMBOLS[axis]} residual [–]",
        xaxis={"range": [-REACH, REACH]}, shapes=shapes, showlegend=True,
    )  # fmt: skip


def against_command(model: Model, run: Run, axis: int) -> Figure:
    """Mean error in groups of the commands that drive the axis, with 95 % intervals.

    Overlapping predictions count as one per horizon.
    """
    name, scale = ERROR_UNITS[axis]
    found = run.prediction
    errors = scale * found.errors[:, axis]
    traces = []
    for n, place in enumerate(forces_in(model, axis)):
        command = np.interp(found.t, run.t, run.forces[:, place])
        edges = np.unique(np.quantile(command, np.linspace(0.0, 1.0, GROUPS + 1)))
        if len(edges) < FEWEST_INDEPENDENT:
            continue
        group = np.clip(np.searchsorted(edges, command, side="right") - 1, 0, len(edges) - 2)
        rows = []
        for g in range(len(edges) - 1):
            mine = errors[group == g]
            independent = len(mine) / found.steps
            if independent >= FEWEST_INDEPENDENT:
                half = NORMAL_95 * float(np.std(mine)) / np.sqrt(independent)
                rows.append((float(command[group == g].mean()), float(mine.mean()), half))
        if not rows:
            continue
        x, mean, half = np.array(rows).T
        colour = FORCE_COLOURS[n % len(FORCE_COLOURS)]
        trace = line("", x, mean, colour) | {
            "mode": "lines+markers",
            "name": force_name(model, place),
        }
        mark = {"color": colour, "symbol": SIGNS[n % len(SIGNS)], "size": 7}
        traces.append(
            trace | {"marker": mark, "error_y": whiskers(mean, mean - half, mean + half, colour)}
        )
    return figure(
        traces, "command [command units]", f"mean error in {SYMBOLS[axis]} [{name}]",
        shapes=[level(0.0, BLACK, "solid")], showlegend=True,
    )  # fmt: skip
