# SPDX-License-Identifier: MIT
"""A plot as SVG without a browser: the part of Plotly's figures that the report uses."""

from collections.abc import Mapping, Sequence
from html import escape, unescape
from typing import Any

import numpy as np

from seatrial.report.figures.base import Figure
from seatrial.report.figures.svg_axes import Axis, axis_of
from seatrial.report.figures.svg_marks import DASH, bars, fmt, line_path, symbols, whiskers
from seatrial.util.frames import Array

WIDTH, HEIGHT, PLOT_ROW = 640.0, 420.0, 18.0  # [px] of a plot, and a row of one that has rows
LEFT, RIGHT, TOP, BOTTOM = 66.0, 12.0, 12.0, 46.0  # [px] around the plot
LEGEND_ROW, LETTER_WIDTH = 18.0, 6.3  # [px] a row of the legend, a letter
TEXT, GRID = "#1a1d21", "#dfe3e7"


def svg(figure: Figure) -> str:
    """The figure on white, as text of an SVG file."""
    layout = figure["layout"]
    traces = [t for t in figure["data"] if len(np.atleast_1d(np.asarray(t["x"])))]
    entries, rows = _legend(traces, layout)
    top = TOP + LEGEND_ROW * rows
    wide = _longest(layout.get("yaxis", {})) * LETTER_WIDTH
    height = max(HEIGHT, top + BOTTOM + PLOT_ROW * len(layout.get("yaxis", {}).get("ticktext", [])))
    box = (max(LEFT, wide + 20.0), top, WIDTH - RIGHT, height - BOTTOM)
    x, panels = _axes(traces, layout, box)
    parts = [_frame(x, y, title) for y, title in panels.values()]
    names = layout.get("shapes", [])
    parts += [_shape(s, x, panels["y"][0]) for s in names]
    for trace in traces:
        parts.append(_trace(trace, x, panels[trace.get("yaxis", "y")][0]))
    last = list(panels.values())[-1][0]
    parts.append(_bottom(x, last, layout))
    clip = "".join(
        f'<clipPath id="{name}"><rect x="{fmt(x.low)}" y="{fmt(y.high)}" width="{fmt(x.high - x.low)}" '
        f'height="{fmt(y.low - y.high)}"/></clipPath>'
        for name, (y, _) in panels.items()
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH:g}" height="{height:g}" '
        f'viewBox="0 0 {WIDTH:g} {height:g}" font-family="DejaVu Sans, Arial, sans-serif" font-size="11" '
        f'fill="{TEXT}"><defs>{clip}</defs><rect width="100%" height="100%" fill="#ffffff"/>'
        f"{''.join(parts)}{entries}</svg>\n"
    )


def _axes(
    traces: Sequence[Figure], layout: Figure, box: tuple[float, float, float, float]
) -> tuple[Axis, dict[str, tuple[Axis, str]]]:
    """The horizontal axis, and each vertical one with its title."""
    left, top, right, bottom = box
    x = axis_of(layout.get("xaxis", {}), _values(traces, "x"), left, right)
    panels = {}
    for name, key in (("y", "yaxis"), ("y2", "yaxis2"), ("y3", "yaxis3")):
        if key not in layout:
            continue
        own = layout[key]
        begin, end = own.get("domain", (0.0, 1.0))
        mine = [t for t in traces if t.get("yaxis", "y") == name]
        low, high = bottom - begin * (bottom - top), bottom - end * (bottom - top)
        levels = [s["y0"] for s in layout.get("shapes", []) if s.get("xref") == "paper"]
        values = np.concatenate([_values(mine, "y"), levels if name == "y" else []])
        axis = axis_of(own, values, low, high)
        panels[name] = axis, own["title"]["text"]
    if "scaleanchor" in layout.get("yaxis", {}):
        x, y = _alike(x, panels["y"][0])
        panels["y"] = y, panels["y"][1]
    return x, panels


def _alike(x: Axis, y: Axis) -> tuple[Axis, Axis]:
    """Both with as many metres a pixel."""
    each = max((x.end - x.begin) / abs(x.high - x.low), (y.end - y.begin) / abs(y.high - y.low))
    return x.widened(each), y.widened(each)


def _values(traces: Sequence[Figure], key: str) -> Array:
    """All values, with the ends of intervals."""
    parts = [np.zeros(0)]
    for trace in traces:
        value = np.asarray(trace[key], dtype=float)
        parts.append(value)
        ends = trace.get(f"error_{key}")
        if ends is not None:
            parts += [value + np.asarray(ends["array"]), value - np.asarray(ends["arrayminus"])]
        if trace["type"] == "bar" and key == "y":
            parts.append(np.zeros(1))
    every = np.concatenate(parts)
    return every[np.isfinite(every)]


def _frame(x: Axis, y: Axis, title: str) -> str:
    """Grid, ticks and title of one panel."""
    lines = [
        f'<path d="M{fmt(at)} {fmt(y.low)}V{fmt(y.high)}" stroke="{GRID}"/>' for at, _ in x.ticks()
    ]
    for at, text in y.ticks():
        lines.append(f'<path d="M{fmt(x.low)} {fmt(at)}H{fmt(x.high)}" stroke="{GRID}"/>')
        lines.append(
            f'<text x="{fmt(x.low - 5)}" y="{fmt(at + 4)}" text-anchor="end">{_words(text)}</text>'
        )
    middle = 0.5 * (y.low + y.high)
    lines.append(
        f'<text transform="translate(14 {fmt(middle)}) rotate(-90)" text-anchor="middle">{_words(title)}</text>'
    )
    return "".join(lines)


def _bottom(x: Axis, y: Axis, layout: Figure) -> str:
    """Ticks and title below the last panel."""
    ticks = "".join(
        f'<text x="{fmt(at)}" y="{fmt(y.low + 15)}" text-anchor="middle">{_words(text)}</text>'
        for at, text in x.ticks()
    )
    title = layout.get("xaxis", {}).get("title", {}).get("text", "")
    middle = 0.5 * (x.low + x.high)
    return f'{ticks}<text x="{fmt(middle)}" y="{fmt(y.low + 36)}" text-anchor="middle">{_words(title)}</text>'


def _trace(trace: Figure, x: Axis, y: Axis) -> str:
    """Line, marks, intervals or bars of one trace."""
    px, py = x.place(trace["x"]), y.place(trace["y"])
    inside = f'<g clip-path="url(#{trace.get("yaxis", "y")})" opacity="{trace.get("opacity", 1)}">'
    if trace["type"] == "bar":
        return (
            inside + bars(px, py, float(y.place(np.zeros(1))[0]), trace["marker"]["color"]) + "</g>"
        )
    drawn = ""
    if "lines" in trace["mode"]:
        drawn += line_path(trace, px, py)
    for key in ("error_x", "error_y"):
        if key in trace:
            drawn += whiskers(trace, key, x, y)
    if "markers" in trace["mode"]:
        drawn += symbols(trace["marker"], px, py)
    return f"{inside}{drawn}</g>"


def _shape(shape: Mapping[str, Any], x: Axis, y: Axis) -> str:
    """A line over the whole plot."""
    look = shape["line"]
    if shape.get("yref") == "paper":
        at = x.place(np.array([shape["x0"]]))[0]
        path = f"M{fmt(at)} {fmt(y.low)}V{fmt(y.high)}"
    else:
        at = y.place(np.array([shape["y0"]]))[0]
        path = f"M{fmt(x.low)} {fmt(at)}H{fmt(x.high)}"
    if not np.isfinite(at):
        return ""
    dash = DASH.get(look.get("dash", "solid"), "")
    return (
        f'<path clip-path="url(#y)" d="{path}" fill="none" stroke="{look["color"]}" '
        f'stroke-width="{look["width"]}"{dash}/>'
    )


def _legend(traces: Sequence[Figure], layout: Figure) -> tuple[str, int]:
    """Names with their symbols in rows above the plot, and the number of rows."""
    named = [t for t in traces if t.get("showlegend", True) and t.get("name")]
    if not named or (len(named) == 1 and not layout.get("showlegend")):
        return "", 0
    parts, at, row = [], LEFT, 0
    for trace in named:
        width = 34.0 + LETTER_WIDTH * len(unescape(_plain(trace["name"])))
        if at + width > WIDTH - RIGHT and at > LEFT:
            at, row = LEFT, row + 1
        y = TOP + LEGEND_ROW * row + 4
        parts.append(_key(trace, at, y))
        parts.append(f'<text x="{fmt(at + 24)}" y="{fmt(y + 4)}">{_words(trace["name"])}</text>')
        at += width
    return "".join(parts), row + 1


def _key(trace: Figure, x: float, y: float) -> str:
    ends = np.array([x, x + 18.0]), np.array([y, y])
    if trace["type"] == "bar" or "fill" in trace:
        colour = trace.get("fillcolor") or trace["marker"]["color"]
        return f'<rect x="{fmt(x)}" y="{fmt(y - 5)}" width="18" height="10" fill="{colour}"/>'
    drawn = line_path(trace, *ends) if "lines" in trace["mode"] else ""
    if "markers" in trace["mode"]:
        look = trace["marker"] | {"size": 8}
        drawn += symbols(look, np.array([x + 9.0]), np.array([y]))
    return drawn


def _longest(axis: Mapping[str, Any]) -> int:
    return max((len(_plain(str(text))) for text in axis.get("ticktext", [])), default=0)


def _plain(text: str) -> str:
    return text.replace("<sub>", "").replace("</sub>", "")


def _words(text: str) -> str:
    """Text with lowered subscripts; it is escaped already, except Plotly's own tags."""
    safe = escape(unescape(text), quote=False)
    safe = safe.replace("&lt;sub&gt;", '<tspan dy="3" font-size="8">')
    return safe.replace("&lt;/sub&gt;", '</tspan><tspan dy="-3">\u200b</tspan>')
