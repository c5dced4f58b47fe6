# SPDX-License-Identifier: MIT
"""Grids of numbers with colours, as an SVG."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

CELL, LEFT, TOP, BETWEEN = (92, 34), 70, 62, 50  # [px]
# distinct for colour-blind readers
BLUE, WHITE, ORANGE = ((33, 102, 172), (255, 255, 255), (214, 96, 40))
MOST = np.log(2.5)  # a ratio whose colour is full


@dataclass(frozen=True)
class Grid:
    """Ratios by row and column."""

    title: str
    rows: list[str]
    columns: list[str]
    cells: list[list[float]]


def draw(grids: Sequence[Grid], path: Path) -> None:
    """Write them side by side."""
    wide = LEFT + sum(len(g.columns) * CELL[0] + BETWEEN for g in grids)
    high = TOP + max(len(g.rows) for g in grids) * CELL[1] + 34
    body, x = [], LEFT
    for grid in grids:
        body.append(_panel(grid, x))
        x += len(grid.columns) * CELL[0] + BETWEEN
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" '
        f'font-family="sans-serif" font-size="12" fill="#1f2328">\n'
        f'<rect width="{wide}" height="{high}" fill="#ffffff"/>\n' + "\n".join(body) + "\n</svg>\n"
    )


def _panel(grid: Grid, x0: int) -> str:
    out = [f'<text x="{x0}" y="20" font-weight="bold">{grid.title}</text>']
    for j, name in enumerate(grid.columns):
        x = x0 + (j + 0.5) * CELL[0]
        out.append(f'<text x="{x:.0f}" y="{TOP - 8}" text-anchor="middle">{name}</text>')
    for i, (name, line) in enumerate(zip(grid.rows, grid.cells, strict=True)):
        y = TOP + i * CELL[1]
        out.append(f'<text x="{x0 - 8}" y="{y + 21}" text-anchor="end">{name}</text>')
        for j, value in enumerate(line):
            x = x0 + j * CELL[0]
            fill, ink = _colour(value)
            out.append(
                f'<rect x="{x}" y="{y}" width="{CELL[0]}" height="{CELL[1]}" fill="{fill}"/>'
            )
            out.append(
                f'<text x="{x + CELL[0] / 2:.0f}" y="{y + 21}" text-anchor="middle" fill="{ink}">'
                f"{f'{value:.2f}' if np.isfinite(value) else 'no model'}</text>"
            )
    bottom = TOP + len(grid.rows) * CELL[1] + 20
    out.append(f'<text x="{x0}" y="{bottom}">dead zone (rows) by size of the commands</text>')
    return "\n".join(out)


def _colour(value: float) -> tuple[str, str]:
    """Fill and ink: white at 1, orange where MP is worse, blue where AF is."""
    if not np.isfinite(value):
        return "#d0d7de", "#1f2328"
    share = float(np.clip(np.log(value) / MOST, -1.0, 1.0))
    end = ORANGE if share > 0 else BLUE
    mixed = [round(w + abs(share) * (c - w)) for w, c in zip(WHITE, end, strict=True)]
    return f"rgb({mixed[0]},{mixed[1]},{mixed[2]})", "#ffffff" if abs(share) > 0.75 else "#1f2328"
