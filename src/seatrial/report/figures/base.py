# SPDX-License-Identifier: MIT
"""Common to all plots: colours, lines, marks, intervals, axes."""

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from seatrial.boat.model import Model
from seatrial.report.text.names import plotly_symbol
from seatrial.util.frames import AXES, SPEED_UNITS, SYMBOLS, Array

Figure = dict[str, Any]

BLACK, ORANGE, SKY, GREEN, BLUE, RED, PURPLE = (
    "#000000", "#e69f00", "#56b4e9", "#009e73", "#0072b2", "#d55e00", "#cc79a7",
)  # Okabe and Ito (2008): distinct for colour-blind readers  # fmt: skip
SHADE = "rgba(0,114,178,0.15)"
WARM = "rgba(230,159,0,0.18)"
CYCLE = (BLUE, RED, GREEN, PURPLE, ORANGE, SKY, BLACK)
LEAST_SHOWN = 1e-5  # of the largest value, on a logarithmic axis
FEW_DECADES = 2.6  # of a logarithmic axis: below it 2 and 5 are ticks, too
DASHES = ("solid", "dash", "dot")  # the next dash after each cycle of colours
SIGNS = ("circle", "square", "diamond", "cross", "triangle-up")
FORCE_COLOURS = (BLUE, GREEN, PURPLE, ORANGE, SKY)
COMMAND = "F [command units]"


def forces_in(model: Model, axis: int) -> list[int]:
    """Places of the forces in an axis' equation, those along the axis first."""
    used = {f for t in model.structure.terms if t.axis == axis for f in t.factors}
    forces = model.structure.forces
    places = [i for i, f in enumerate(forces) if f.name in used]
    return sorted(places, key=lambda i: forces[i].axis != axis)


def driven_axes(model: Model) -> list[int]:
    """The axes with a force in their equation; all where there is none."""
    found = [axis for axis in range(3) if forces_in(model, axis)]
    return found or [0, 1, 2]


def line(
    name: str, x: Array, y: Array, colour: str, *, dash: str = "", width: float = 1.5
) -> Figure:
    """A line; it breaks at NaN."""
    look: Figure = {"color": colour, "width": width}
    if dash:
        look["dash"] = dash
    return {"type": "scatter", "mode": "lines", "name": escape(name), "x": x, "y": y, "line": look}


def marks(name: str, points: Array, colour: str, sign: str, size: int = 7) -> Figure:
    """Points (n, 2)."""
    look: Figure = {"color": colour, "symbol": sign, "size": size}
    if sign.endswith("open"):
        look["line"] = {"color": colour, "width": 1.5}
    return {
        "type": "scatter", "mode": "markers", "name": escape(name),
        "x": points[:, 0], "y": points[:, 1], "marker": look, "opacity": 0.8,
    }  # fmt: skip


def area(
    name: str, x: Array, low: Array, high: Array, colour: str, *, shade: str = SHADE
) -> Figure:
    """The area between two curves."""
    found = line(name, np.concatenate([x, x[::-1]]), np.concatenate([high, low[::-1]]), colour)
    return found | {"fill": "toself", "fillcolor": shade, "line": {"width": 0, "color": colour},
                    "hoverinfo": "skip"}  # fmt: skip


def whiskers(values: Array, low: Array, high: Array, colour: str) -> Figure:
    """Error bars from `low` to `high` around values."""
    up, down = np.maximum(high - values, 0.0), np.maximum(values - low, 0.0)
    return {"type": "data", "symmetric": False, "array": up, "arrayminus": down,
            "color": colour, "thickness": 1.5, "width": 4}  # fmt: skip


def named_rows(names: Sequence[str]) -> tuple[Array, Figure]:
    """Places (n,) of names down the side of a plot, and its vertical axis."""
    place = -np.arange(len(names), dtype=float)
    text = [plotly_symbol(name) for name in names]
    return place, {"tickvals": place.tolist(), "ticktext": text, "range": [-len(names) + 0.3, 0.7]}


def upright(x: float, colour: str, dash: str = "dot") -> Figure:
    """A line over the whole height."""
    return _across({"x0": x, "x1": x, "yref": "paper", "y0": 0, "y1": 1}, colour, dash)


def level(y: float, colour: str, dash: str = "dot") -> Figure:
    """A line over the whole width."""
    return _across({"y0": y, "y1": y, "xref": "paper", "x0": 0, "x1": 1}, colour, dash)


def _across(ends: Figure, colour: str, dash: str) -> Figure:
    return {"type": "line", **ends, "line": {"color": colour, "width": 1.5, "dash": dash}}


def figure(traces: Sequence[Figure], x: str, y: str, **layout: Any) -> Figure:  # noqa: ANN401
    """A figure with titles on its axes; `xaxis`, `yaxis` and the like extend them."""
    whole: Figure = {"xaxis": {"title": {"text": x}}, "yaxis": {"title": {"text": y}}}
    for name, value in layout.items():
        whole[name] = whole[name] | value if name in whole else value
    return {"data": list(traces), "layout": whole}


def logarithmic(low: float, high: float) -> Figure:
    """A logarithmic axis from `low` to `high` with ticks that are whole numbers: 0.1, 0.2, 0.5, 1."""
    ticks = log_ticks(low, high)
    ends = [float(np.log10(low)), float(np.log10(high))]
    text = [f"{t:.6g}" for t in ticks]
    return {"type": "log", "range": ends, "tickvals": ticks, "ticktext": text}


def log_ticks(low: float, high: float) -> list[float]:
    """Ticks of a logarithmic axis: 1, 2, 5 where it spans few decades; a decade beyond each end, too."""
    begin, end = float(np.log10(low)), float(np.log10(high))
    factors = (1.0, 2.0, 5.0) if end - begin < FEW_DECADES else (1.0,)
    powers = range(int(np.floor(begin)) - 1, int(np.ceil(end)) + 2)
    return [f * 10.0**p for p in powers for f in factors]


def room_for(traces: Sequence[Figure]) -> Figure:
    """`logarithmic` over the positive heights of some traces, and the ends of their intervals."""
    parts = [np.ones(0)]
    for trace in traces:
        y = np.asarray(trace["y"], dtype=float)
        ends = trace.get("error_y", {"array": 0.0, "arrayminus": 0.0})
        parts += [y, y + np.asarray(ends["array"]), y - np.asarray(ends["arrayminus"])]
    every = np.concatenate(parts)
    every = every[np.isfinite(every) & (every > 0)]
    if not len(every):
        return {"type": "log"}
    return logarithmic(
        0.9 * max(float(every.min()), LEAST_SHOWN * float(every.max())), 1.1 * float(every.max())
    )


def colour_of(place: int) -> tuple[str, str]:
    """Colour and dash of the curve at `place`."""
    return CYCLE[place % len(CYCLE)], DASHES[place // len(CYCLE) % len(DASHES)]


def force_name(model: Model, place: int) -> str:
    """A force's name with Plotly's subscripts; markup in it is escaped."""
    return plotly_symbol(model.structure.forces[place].name)


def shortened(name: str, most: int = 26) -> str:
    """A recording's name for an axis."""
    whole = name if len(name) <= most else f"{name[: most // 2 - 2]}…{name[2 - most // 2 :]}"
    return escape(whole)


def speed(axis: int) -> str:
    """Title of an axis of velocities."""
    return f"{AXES[axis]} {SYMBOLS[axis]} [{SPEED_UNITS[axis]}]"
