# SPDX-License-Identifier: MIT
"""Plots of the report's kind, side by side in one SVG."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from seatrial.report.figures.base import Figure, figure, line
from seatrial.report.figures.svg import HEIGHT, WIDTH, svg
from seatrial.util.frames import Array

DASH = 0.04  # [m] length of the dash that stands for a point


def write(path: Path, plots: Sequence[Sequence[Figure]]) -> None:
    """Plots in rows, into one file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(sheet(plots))


def sheet(plots: Sequence[Sequence[Figure]]) -> str:
    """Plots in rows as one SVG."""
    width, height = WIDTH * max(map(len, plots)), HEIGHT * len(plots)
    parts = []
    for i, row in enumerate(plots):
        for j, plot in enumerate(row):
            text = svg(plot).replace('id="', f'id="p{i}{j}').replace("url(#", f"url(#p{i}{j}")
            parts.append(text.replace("<svg ", f'<svg x="{j * WIDTH:g}" y="{i * HEIGHT:g}" ', 1))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="0 0 {width:g} {height:g}">{"".join(parts)}</svg>\n'
    )


def plan(traces: Sequence[Figure], **layout: object) -> Figure:
    """A chart seen from above, with equal scales along x and y."""
    equal = {"scaleanchor": "x", "scaleratio": 1, **layout.pop("yaxis", {})}  # type: ignore[dict-item]
    return figure(traces, "x [m]", "y [m]", showlegend=True, yaxis=equal, **layout)


def path_of(name: str, points: Array, colour: str, width: float = 1.5) -> Figure:
    """A line through points (n, 2 or more) [m]."""
    return line(name, points[:, 0], points[:, 1], colour, width=width)


def dots(name: str, points: Array, colour: str, length: float = DASH) -> Figure:
    """Points (n, 2) [m] as short dashes: a tenth of the size of as many circles."""
    x = np.column_stack([points[:, 0], points[:, 0] + length, np.full(len(points), np.nan)])
    y = np.column_stack([points[:, 1], points[:, 1], np.full(len(points), np.nan)])
    return line(name, x.ravel(), y.ravel(), colour, width=3.0)


def ring(centre: Array, radius: float) -> Array:
    """Points (40, 2) of a circle."""
    angle = np.linspace(0.0, 2.0 * np.pi, 40)
    return np.asarray(centre + radius * np.column_stack([np.cos(angle), np.sin(angle)]))


def rectangle(length: float, width: float) -> Array:
    """Corners (5, 2) of a closed rectangle around the origin."""
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])
    return np.asarray(0.5 * np.array([length, width]) * corners)
