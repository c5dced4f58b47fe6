# SPDX-License-Identifier: MIT
"""docs/images/mpc.svg: a course that leaves the pool, and what the thrusters did on it."""

from pathlib import Path

import numpy as np

from benchmarks.mpc.study import WALLED, at_walls, controller
from benchmarks.mpc.tables import dead_zone
from benchmarks.paper.figures import sheet
from seatrial.frames import Array
from seatrial.report.draw.base import BLACK, BLUE, RED, SKY, Figure, figure, line

COLOURS = (BLUE, SKY, RED, BLACK)


def draw(path: Path) -> None:
    """Way and commands."""
    run = at_walls()
    found, way, reach = run.outcome, run.way, run.reach
    wanted = np.array([WALLED.at(t).eta for t in found.t.tolist()])
    corners = reach * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])
    ways = [
        _way("wanted", wanted, SKY),
        _way("boat", way, BLUE),
        _way("walls less clearance", corners, RED),
    ]
    plan = figure(
        ways, "x [m]", "y [m]", showlegend=True, yaxis={"scaleanchor": "x", "scaleratio": 1}
    )
    names = controller("hard").model.vehicle.inputs
    commands = [
        line(name, found.t, found.command[:, k], COLOURS[k % len(COLOURS)])
        for k, name in enumerate(names)
    ]
    edge = np.full(2, dead_zone())
    commands.append(line("dead zone's edge", found.t[[0, -1]], edge, BLACK, width=1.0))
    thrusters = figure(commands, "time [s]", "command", showlegend=True)
    path.write_text(sheet([[plan, thrusters]]))


def _way(name: str, points: Array, colour: str) -> Figure:
    return line(name, points[:, 0], points[:, 1], colour)
