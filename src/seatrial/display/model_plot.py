# SPDX-License-Identifier: MIT
"""Plots of a model: how well each parameter is known, curves of thrust and angles, step responses."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from seatrial.boat.model import Model
from seatrial.display.canvas import GREY, SMALL, drawn_on, finished, literal, symbol
from seatrial.report.evidence.actuators import Curve, angle_curves, curves, step_responses
from seatrial.report.figures.actuators import ANGLE, COMMANDS, THRUST
from seatrial.report.figures.base import BLUE, CYCLE, GREEN, ORANGE, PURPLE
from seatrial.report.text.markup import true_minus
from seatrial.util.format import plus_minus
from seatrial.util.frames import AXES
from seatrial.util.statistics import NORMAL_95

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, LEAST_HEIGHT = 10.0, 5.0  # [inch]
ROW_HEIGHT, HEAD_HEIGHT, CURVE_HEIGHT = 0.27, 1.4, 2.5  # [inch]
GROUP_COLOURS = (BLUE, ORANGE, GREEN, PURPLE)  # surge, sway, yaw, thrusters
THRUSTERS = len(AXES)  # group of the chain's constants
LEAST_SHOWN, MOST_SHOWN = 0.1, 1000.0  # [% of the value] ends of the axis
MOST_CURVES = 6  # of one plot
TITLES = {  # of both axes and the plot
    "curve": (COMMANDS, THRUST, "Thrust curve"),
    "angle": (COMMANDS, ANGLE, "Angle"),
    "step": ("time since a full command [s]", "force [share of final value]", "Step response"),
}
DASHES = ("-", "--", ":")


def plot_model(model: Model, figure: "Figure | None" = None) -> "Figure":
    """Half-widths of the 95 % intervals, curves of thrust and angles, and step responses with 95 % bands."""
    rows = _intervals(model)
    found = {"curve": curves(model), "angle": angle_curves(model), "step": step_responses(model)}
    found = {name: own for name, own in found.items() if own}
    mosaic = [["known", name] if rows else [name] for name in found]
    heights = LEAST_HEIGHT, HEAD_HEIGHT + ROW_HEIGHT * len(rows), CURVE_HEIGHT * len(found)
    canvas = drawn_on(figure, WIDTH, max(heights))
    axes = canvas.subplot_mosaic(mosaic)  # type: ignore[arg-type]
    canvas.suptitle(literal(model.name, 80))
    if rows:
        _draw_intervals(axes["known"], rows)
    for name, own in found.items():
        _draw_curves(axes[name], own)
        finished(axes[name], *TITLES[name])
    if "step" in found:
        axes["step"].axvline(0.0, color=GREY, linewidth=0.8)
    return canvas


Row = tuple[str, float, float, int]  # name with value, half-width over the value, value, group


def _intervals(model: Model) -> list[Row]:
    """The parameters that have standard errors, in the order of the equations."""
    groups = {t.coefficient: t.axis for t in reversed(model.structure.terms) if t.coefficient}
    rows = []
    for name, value in model.parameter_values.items():
        error = model.standard_errors[name]
        if error > 0.0:
            share = NORMAL_95 * error / abs(value) if value else np.inf
            label = f"{symbol(name)} = {true_minus(plus_minus(value, error))}"
            rows.append((label, 100.0 * share, value, groups.get(name, THRUSTERS)))
    return rows


def _draw_intervals(axes: "Axes", rows: Sequence[Row]) -> None:
    """A point a parameter on a logarithmic axis; right of 100 % the interval holds zero."""
    places = -np.arange(len(rows), dtype=float)
    shares = np.clip([share for _, share, _, _ in rows], LEAST_SHOWN, MOST_SHOWN)
    group = np.array([row[3] for row in rows])
    low = LEAST_SHOWN if shares.min() < 1.0 else 1.0
    for i, name in enumerate((*AXES, "thrusters")):
        own = group == i
        if own.any():
            axes.hlines(places[own], low, shares[own], color=GROUP_COLOURS[i], linewidth=1.0)
            axes.plot(
                shares[own], places[own], "o", color=GROUP_COLOURS[i], label=name, clip_on=False
            )
    most = max(200.0, 1.3 * float(shares.max()))
    axes.axvspan(100.0, most, color=GREY, alpha=0.12, linewidth=0, label="interval holds zero")
    axes.set(xscale="log", xlim=(low, most), ylim=(-len(rows) + 0.4, 0.6))
    axes.set_yticks(places, [label for label, *_ in rows])
    ticks = [tick for tick in (0.1, 1.0, 10.0, 100.0, 1000.0) if low <= tick <= most]
    axes.set_xticks(ticks, [f"{tick:g} %" for tick in ticks])
    finished(axes, "half-width of the 95 % interval, relative to the value", "", "Parameters")
    axes.legend(fontsize=SMALL, loc="upper left", bbox_to_anchor=(0.0, -0.12), ncols=3)


def _draw_curves(axes: "Axes", found: Sequence[Curve]) -> None:
    for i, one in enumerate(found[:MOST_CURVES]):
        colour, dash = CYCLE[i % len(CYCLE)], DASHES[i % len(DASHES)]
        label = literal(one.label)
        if (one.high > one.low).any():
            axes.fill_between(one.x, one.low, one.high, color=colour, alpha=0.2, linewidth=0)
            label = f"{label}, with 95 % band"
        axes.plot(one.x, one.y, dash, color=colour, label=label)
    axes.legend(fontsize=SMALL)
