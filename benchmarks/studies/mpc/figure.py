# SPDX-License-Identifier: MIT
"""docs/images/mpc.svg: a course that leaves the pool, and what the thrusters did on it."""

from pathlib import Path

import numpy as np

from benchmarks.harness import pictures
from benchmarks.studies.mpc.study import WALLED, at_walls, controller
from benchmarks.studies.mpc.tables import dead_zone
from seatrial.report.figures.base import BLACK, BLUE, RED, SKY, figure, line

COLOURS = (BLUE, SKY, RED, BLACK)


def draw(path: Path) -> None:
    """Path and commands."""
    run = at_walls()
    found, reach = run.outcome, run.reach
    wanted = np.array([WALLED.at(t).eta for t in found.t.tolist()])
    plan = pictures.plan([
        pictures.path_of("reference", wanted, SKY),
        pictures.path_of("boat", run.path, BLUE),
        pictures.path_of("walls less clearance", pictures.rectangle(*(2.0 * reach)), RED),
    ])  # fmt: skip
    names = controller("hard").model.vehicle.inputs
    commands = [
        line(name, found.t, found.command[:, k], COLOURS[k % len(COLOURS)])
        for k, name in enumerate(names)
    ]
    edge = np.full(2, dead_zone())
    commands.append(line("dead zone's edge", found.t[[0, -1]], edge, BLACK, width=1.0))
    thrusters = figure(commands, "time [s]", "command", showlegend=True)
    pictures.write(path, [[plan, thrusters]])
