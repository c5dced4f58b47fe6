# SPDX-License-Identifier: MIT
"""Plots of allocation: attainable wrenches, and thruster commands along a recording."""

import numpy as np

from seatrial.control.allocation import AllocationComparison, Allocator
from seatrial.control.allocation.schemes import PLAIN, Drive
from seatrial.report.figures.base import ORANGE, Figure, colour_of, figure, level, line
from seatrial.util.frames import AXES, Array

OUTLINE_POINTS = 241  # of an attainable set's outline
COMMANDS_WINDOW = 30.0  # [s] of commands that are drawn
MOST_COMMANDS = 1500  # drawn of a curve of commands


def slices(found: AllocationComparison, first: int, second: int) -> Figure:
    """Attainable wrenches with the third axis at rest, of every scheme."""
    outlines: list[tuple[list[str], tuple[Array, Array]]] = []
    for name, allocator in shown(found):
        new = outline(allocator, first, second)
        same = next((names for names, old in outlines if np.allclose(old, new, atol=1e-6)), None)
        if same is None:
            outlines.append(([name], new))
        else:
            same.append(name)
    traces = []
    for place, (names, (x, y)) in enumerate(outlines):
        colour, dash = colour_of(place)
        traces.append(line(", ".join(names), x, y, colour, dash=dash))
    return figure(
        traces, _wrench(first), _wrench(second),
        yaxis={"scaleanchor": "x"}, showlegend=True,
    )  # fmt: skip


def outline(allocator: Allocator, first: int, second: int) -> tuple[Array, Array]:
    """The largest attainable wrench in every direction of a plane through zero."""
    angle = np.linspace(0.0, 2.0 * np.pi, OUTLINE_POINTS)
    directions = np.zeros((OUTLINE_POINTS, 3))
    directions[:, first], directions[:, second] = np.cos(angle), np.sin(angle)
    ends = allocator.reach(directions)[:, None] * directions
    return ends[:, first], ends[:, second]


def shown(found: AllocationComparison) -> list[tuple[str, Allocator]]:
    """Schemes that are possible, without the one that ignores the curves."""
    return [
        (row.name, row.allocator)
        for row in found.rows
        if row.allocator is not None and row.name != PLAIN
    ]


def commands(found: AllocationComparison, place: int, thruster: int) -> Figure:
    """A thruster's commands by every scheme, with the edges of its dead zone."""
    traces = []
    drives = [(row.name, row.drives[place]) for row in found.rows if row.drives]
    start = busiest(drives[0][1], thruster)
    for number, (name, drive) in enumerate(drives):
        colour, dash = colour_of(number)
        t, c = _stairs(drive, thruster, start)
        traces.append(line(name, t, c, colour, dash=dash))
    edges = found.allocator.edges[:, thruster]
    shapes = [level(edges[0], ORANGE), level(-edges[1], ORANGE)] if edges.any() else []
    return figure(
        traces, "time [s]", "command [command units]", shapes=shapes, showlegend=True,
        xaxis={"range": [start, start + COMMANDS_WINDOW]},
    )  # fmt: skip


def busiest(drive: Drive, thruster: int) -> float:
    """Start [s] of the window in which a thruster's command changes its sign most often."""
    turned = np.diff(np.sign(drive.commands[:, thruster])) != 0
    count = np.concatenate([[0], np.cumsum(turned)])
    ends = np.searchsorted(drive.t, drive.t + COMMANDS_WINDOW) - 1
    return float(drive.t[int(np.argmax(count[ends] - count))])


def _stairs(drive: Drive, thruster: int, start: float) -> tuple[Array, Array]:
    """Commands within the window, each held until the next."""
    inside = np.flatnonzero((drive.t >= start) & (drive.t <= start + COMMANDS_WINDOW))
    inside = inside[:: max(1, len(inside) // MOST_COMMANDS)]
    t, c = drive.t[inside], drive.commands[inside, thruster]
    return np.repeat(t, 2)[1:], np.repeat(c, 2)[:-1]


def _wrench(axis: int) -> str:
    return f"{AXES[axis]} [command units]"
