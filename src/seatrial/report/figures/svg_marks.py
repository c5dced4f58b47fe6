# SPDX-License-Identifier: MIT
"""Lines, marks, bars and intervals of an SVG plot, at pixels."""

from typing import Any

import numpy as np

from seatrial.report.figures.base import Figure
from seatrial.report.figures.svg_axes import Axis
from seatrial.util.frames import Array

DASH = {
    "dash": ' stroke-dasharray="8 6"',
    "dot": ' stroke-dasharray="2 3"',
    "dashdot": ' stroke-dasharray="8 3 2 3"',
}
CAP = 3.0  # [px] half of an interval's end


def fmt(value: float) -> str:
    """A coordinate."""
    return f"{value:.1f}".removesuffix(".0")


def line_path(trace: Figure, x: Array, y: Array) -> str:
    """A line that breaks at NaN; filled where the trace says so."""
    look = trace["line"]
    steps = look.get("shape") == "hv"
    parts, drawing = [], False
    for px, py in zip(x.tolist(), y.tolist(), strict=True):
        if not (np.isfinite(px) and np.isfinite(py)):
            drawing = False
            continue
        if not drawing:
            parts.append(f"M{fmt(px)} {fmt(py)}")
        elif steps:
            parts.append(f"H{fmt(px)}V{fmt(py)}")
        else:
            parts.append(f"L{fmt(px)} {fmt(py)}")
        drawing = True
    fill = trace.get("fillcolor", "none") if "fill" in trace else "none"
    stroke = look.get("color", "none") if look.get("width", 1) else "none"
    dash = DASH.get(look.get("dash", "solid"), "")
    return (
        f'<path d="{"".join(parts)}" fill="{fill}" stroke="{stroke}" '
        f'stroke-width="{look.get("width", 1)}" stroke-linejoin="round"{dash}/>'
    )


def bars(x: Array, y: Array, base: float, colour: str) -> str:
    """Bars of a histogram."""
    width = float(np.median(np.diff(x))) if len(x) > 1 else 10.0
    return "".join(
        f'<rect x="{fmt(px - 0.47 * width)}" y="{fmt(min(py, base))}" width="{fmt(0.94 * width)}" '
        f'height="{fmt(abs(base - py))}" fill="{colour}"/>'
        for px, py in zip(x.tolist(), y.tolist(), strict=True)
        if np.isfinite(py)
    )


def symbols(look: dict[str, Any], x: Array, y: Array) -> str:
    """Marks of one kind."""
    sizes = np.broadcast_to(np.asarray(look["size"], dtype=float), x.shape)
    return "".join(
        _symbol(look["symbol"], px, py, 0.5 * size, look["color"])
        for px, py, size in zip(x.tolist(), y.tolist(), sizes.tolist(), strict=True)
        if np.isfinite(px) and np.isfinite(py)
    )


def _symbol(kind: str, x: float, y: float, r: float, colour: str) -> str:
    base = kind.removesuffix("-open").removesuffix("-thin")
    fill = "none" if kind.endswith("open") else colour
    look = f'fill="{fill}" stroke="{colour}" stroke-width="{1.5 if fill == "none" else 0}"'
    if base == "circle":
        return f'<circle cx="{fmt(x)}" cy="{fmt(y)}" r="{fmt(r)}" {look}/>'
    if base == "square":
        return f'<rect x="{fmt(x - r)}" y="{fmt(y - r)}" width="{fmt(2 * r)}" height="{fmt(2 * r)}" {look}/>'
    if base == "diamond":
        path = f"M{fmt(x)} {fmt(y - r)}l{fmt(r)} {fmt(r)}l{fmt(-r)} {fmt(r)}l{fmt(-r)} {fmt(-r)}z"
        return f'<path d="{path}" {look}/>'
    if base == "triangle-up":
        return f'<path d="M{fmt(x)} {fmt(y - r)}l{fmt(r)} {fmt(2 * r)}h{fmt(-2 * r)}z" {look}/>'
    look = f'stroke="{colour}" stroke-width="{2 if base == "x" else max(2.0, 0.6 * r):.1f}"'
    if base == "x":
        falling = f"M{fmt(x - r)} {fmt(y - r)}l{fmt(2 * r)} {fmt(2 * r)}"
        path = f"{falling}M{fmt(x - r)} {fmt(y + r)}l{fmt(2 * r)} {fmt(-2 * r)}"
    else:
        path = f"M{fmt(x - r)} {fmt(y)}h{fmt(2 * r)}M{fmt(x)} {fmt(y - r)}v{fmt(2 * r)}"
    return f'<path d="{path}" {look}/>'


def whiskers(trace: Figure, key: str, x: Axis, y: Axis) -> str:
    """Intervals along one of the axes."""
    look = trace[key]
    along = key[-1]
    values = np.asarray(trace[along], dtype=float)
    low, high = values - np.asarray(look["arrayminus"]), values + np.asarray(look["array"])
    own, other = (x, y) if along == "x" else (y, x)
    ends = zip(
        own.place(low),
        own.place(high),
        other.place(trace["y" if along == "x" else "x"]),
        strict=True,
    )
    parts = []
    for a, b, c in ends:
        if not np.isfinite([b, c]).all():
            continue
        begin = a if np.isfinite(a) else own.low
        if along == "x":
            parts.append(
                f"M{fmt(begin)} {fmt(c)}H{fmt(b)}"
                + "".join(f"M{fmt(e)} {fmt(c - CAP)}v{fmt(2 * CAP)}" for e in (begin, b))
            )
        else:
            parts.append(
                f"M{fmt(c)} {fmt(begin)}V{fmt(b)}"
                + "".join(f"M{fmt(c - CAP)} {fmt(e)}h{fmt(2 * CAP)}" for e in (begin, b))
            )
    return f'<path d="{"".join(parts)}" fill="none" stroke="{look["color"]}" stroke-width="1.5"/>'
