# SPDX-License-Identifier: MIT
"""The pool and the maps of one drive, side by side."""

from pathlib import Path

import numpy as np

from benchmarks.harness import pictures
from benchmarks.studies.slam.scene import POOL, pool_scene
from benchmarks.studies.slam.study import OFF, SEEDS, Case, driven, track
from benchmarks.studies.slam.tables import MIDDLE
from seatrial.report.figures.base import BLACK, BLUE, RED, SKY, Figure
from seatrial.simulation.scene import Scene
from seatrial.util.frames import Array

SHOWN = ("constant pose", "constant velocity", "predictor")
SEED = SEEDS[0]
ROOM = 1.0  # [m] around the pool


def draw(path: Path) -> None:
    """Truth, and maps by guess, of the first seed's aggressive drive with drop-outs."""
    scene = pool_scene()
    way = driven("aggressive", SEED).truth[::20, :2]
    truth = [
        pictures.path_of("pool", outline(scene), BLACK),
        pictures.path_of("path of the boat", way, SKY),
    ]
    plots = [plan(truth)]
    for guess in SHOWN:
        points = track(Case("aggressive", guess, MIDDLE, drop_outs=True), SEED).map_points
        off = scene.distance(points) > OFF
        found = [pictures.dots(f"map, {guess}", points[~off], BLUE)]
        plots.append(plan([*found, pictures.dots(f"{OFF:g} m off or more", points[off], RED)]))
    pictures.write(path, [plots[:2], plots[2:]])


def outline(scene: Scene) -> Array:
    """Surfaces as one line (n, 2) that breaks at NaN."""
    gap = np.full((1, 2), np.nan)
    parts = [part for s in scene.segments for part in (s.reshape(2, 2), gap)]
    parts += [part for c in scene.circles for part in (pictures.ring(c[:2], c[2]), gap)]
    return np.vstack(parts)


def plan(traces: list[Figure]) -> Figure:
    """The pool from above, with room around it."""
    length, width = 0.5 * POOL.length + ROOM, 0.5 * POOL.width + ROOM
    return pictures.plan(
        traces, xaxis={"range": [-length, length]}, yaxis={"range": [-width, width]}
    )
