# SPDX-License-Identifier: MIT
"""The pool and the maps of one drive, side by side."""

from pathlib import Path

import numpy as np

from benchmarks.paper.figures import sheet
from benchmarks.slam.scene import POOL, pool_scene
from benchmarks.slam.study import OFF, SEEDS, Case, driven, track
from benchmarks.slam.tables import MIDDLE
from seatrial.frames import Array
from seatrial.report.draw.base import BLACK, BLUE, RED, SKY, Figure, figure, line
from seatrial.sim.scene import Scene

SHOWN = ("constant pose", "constant velocity", "predictor")
SEED = SEEDS[0]
DOT = 0.04  # [m] length of the dash that stands for a point
ROOM = 1.0  # [m] around the pool


def draw(path: Path) -> None:
    """Truth, and maps by guess, of the first seed's aggressive drive with drop-outs."""
    scene = pool_scene()
    way = driven("aggressive", SEED).truth[::20, :2]
    truth = [
        line("pool", *columns(outline(scene)), BLACK),
        line("way of the boat", *columns(way), SKY),
    ]
    plots = [_plan(truth)]
    for guess in SHOWN:
        points = track(Case("aggressive", guess, MIDDLE, drop_outs=True), SEED).map_points
        off = scene.distance(points) > OFF
        found = [_dots(f"map, {guess}", points[~off], BLUE)]
        plots.append(_plan([*found, _dots(f"{OFF:g} m off or more", points[off], RED)]))
    path.write_text(sheet([plots[:2], plots[2:]]))


def outline(scene: Scene) -> Array:
    """Surfaces as one line (n, 2) that breaks at NaN."""
    gap = np.full((1, 2), np.nan)
    angle = np.linspace(0.0, 2.0 * np.pi, 40)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    parts = [part for s in scene.segments for part in (s.reshape(2, 2), gap)]
    parts += [part for c in scene.circles for part in (c[:2] + c[2] * ring, gap)]
    return np.vstack(parts)


def columns(points: Array) -> tuple[Array, Array]:
    """x and y (n,)."""
    return points[:, 0], points[:, 1]


def _dots(name: str, points: Array, colour: str) -> Figure:
    """Short dashes: a tenth of the size of as many circles."""
    x = np.column_stack([points[:, 0], points[:, 0] + DOT, np.full(len(points), np.nan)])
    y = np.column_stack([points[:, 1], points[:, 1], np.full(len(points), np.nan)])
    return line(name, x.ravel(), y.ravel(), colour, width=3.0)


def _plan(traces: list[Figure]) -> Figure:
    length, width = 0.5 * POOL.length + ROOM, 0.5 * POOL.width + ROOM
    return figure(
        traces, "x [m]", "y [m]", showlegend=True, xaxis={"range": [-length, length]},
        yaxis={"range": [-width, width], "scaleanchor": "x", "scaleratio": 1},
    )  # fmt: skip
