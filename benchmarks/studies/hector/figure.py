# SPDX-License-Identifier: MIT
"""The pool and Hector's maps of one drive, side by side."""

from pathlib import Path

from benchmarks.harness import pictures
from benchmarks.studies.hector.study import ALONE, BY_NODE, TRUE, Case, Outcome
from benchmarks.studies.slam.drives import STICKS
from benchmarks.studies.slam.figure import outline, plan
from benchmarks.studies.slam.scene import pool_scene
from benchmarks.studies.slam.study import OFF, SEEDS, driven
from seatrial.report.figures.base import BLACK, BLUE, RED, SKY

SHOWN = (ALONE, BY_NODE, TRUE)
DRIVING, SEED = list(STICKS)[-1], SEEDS[0]
CELL = 0.05  # [m]


def draw(outcomes: list[Outcome], path: Path) -> None:
    """Truth, and maps by start estimate, of the first seed's aggressive drive with all scans."""
    truth = [
        pictures.path_of("pool", outline(pool_scene()), BLACK),
        pictures.path_of("path of the boat", driven(DRIVING, SEED).truth[::20, :2], SKY),
    ]
    plots = [plan(truth)]
    for start in SHOWN:
        (found,) = (o for o in outcomes if o.case == Case(DRIVING, start) and o.seed == SEED)
        off = found.map_error > OFF
        dots = [pictures.dots(f"map, {start}", found.map_points[~off], BLUE, CELL)]
        plots.append(
            plan([*dots, pictures.dots(f"{OFF:g} m off or more", found.map_points[off], RED, CELL)])
        )
    pictures.write(path, [plots[:2], plots[2:]])
