# SPDX-License-Identifier: MIT
"""The tables of docs/mpc.md."""

from collections.abc import Callable

import numpy as np

from benchmarks.harness.markdown import table
from benchmarks.studies.guidance.study import SHAPES as GUIDED_SHAPES
from benchmarks.studies.guidance.study import SPEEDS
from benchmarks.studies.guidance.tables import WEAK, cell
from benchmarks.studies.mpc.guided import followed
from benchmarks.studies.mpc.study import WALLED, at_walls, both, chosen, compiled, controller, timed
from benchmarks.studies.tracking.scenes import SCHEMES, SHAPES, truth
from benchmarks.studies.tracking.study import SEEDS
from benchmarks.studies.tracking.tables import heading_error, position
from seatrial.util.frames import Array

WEATHER = ("hard", "paper-like, current")


def dead_zone() -> float:
    """The true one."""
    names = truth("MP").vehicle.constants.names
    return float(truth("MP").constants[names.index("edge_forward")])


def crossings(command: Array) -> int:
    """Entries of thrusters into their dead zone, or leaps over it."""
    side = np.where(np.abs(command) > dead_zone(), np.sign(command), 0.0)
    return int(np.count_nonzero(np.diff(side, axis=0)))


def courses() -> str:
    """RMS distance from the reference and of heading, predictive and tuned."""
    rows = []
    for hurry in (False, True):
        for conditions in WEATHER:
            for shape in SHAPES:
                found = both(conditions, shape, hurry)
                every = [*found.tuned.values(), found.predictive]
                rows.append(
                    [f"{shape}, {chosen(shape, hurry).duration:.0f} s", conditions,
                     *(f"{position(one)}, {heading_error(one)}" for one in every),
                     str(sum(crossings(one.command) for one in found.predictive)), str(found.unsolved)]
                )  # fmt: skip
    pids = [f"PID, {scheme} [mm, mrad]" for scheme in SCHEMES]
    return table(
        [
            "course",
            "SLAM",
            *pids,
            "NMPC [mm, mrad]",
            "dead zones entered by NMPC",
            "programmes unsolved",
        ],
        rows,
        text=2,
    )


def times() -> str:
    """Of a command: up to three quadratic programmes."""
    rows = []
    for kind, made in (("CasADi's functions", controller), ("generated C, gcc -O2", compiled)):
        for hurry in (False, True):
            took = timed(made("hard"), hurry)
            middle, late, worst = 1e3 * np.quantile(took, [0.5, 0.99, 1.0])
            course = f"eight, {chosen('eight', hurry).duration:.0f} s"
            rows.append(
                [kind, course, str(len(took)), f"{middle:.1f}", f"{late:.1f}", f"{worst:.1f}"]
            )
    return table(["step", "course", "commands", "median [ms]", "99 %", "worst"], rows, text=2)


def walls() -> str:
    """How far the boat went at most, over all seeds."""
    runs = [at_walls(seed) for seed in SEEDS]
    reach = runs[0].reach
    far = max(abs(WALLED.at(t).eta[0]) for t in np.linspace(0.0, WALLED.duration, 400))
    over = 1e3 * (np.max([np.abs(one.path).max(axis=0) for one in runs], axis=0) - reach)
    unsolved = str(sum(one.unsolved for one in runs))
    rows = [
        [axis, f"{reach[i]:.2f}", f"{far:.2f}", f"{over[i]:+.1f}", unsolved]
        for i, axis in enumerate("xy")
    ]
    heads = ["", "wall less clearance [m]", "path goes to [m]", "boat beyond it, most [mm]"]
    return table([*heads, "programmes unsolved"], rows)


def paths() -> str:
    """A boat without sway thrust: RMS and 95 % of the distance from the path."""
    rows = []
    for shape in GUIDED_SHAPES:
        for speed in SPEEDS:
            own, weak = (followed(shape, speed, left=left) for left in (1.0, WEAK))
            late = 1e3 * np.quantile(own.took, [0.5, 0.99])
            rows.append(
                [shape, f"{speed:g}", cell([own.outcome]), cell([weak.outcome]),
                 f"{late[0]:.0f}, {late[1]:.0f}", str(own.unsolved + weak.unsolved)]
            )  # fmt: skip
    heads = ["NMPC [m]", f"left thruster at {WEAK:.0%} [m]", "a command: median, 99 % [ms]"]
    return table(["course", "speed [m/s]", *heads, "programmes unsolved"], rows)


MAKERS: dict[str, Callable[[], str]] = {
    "courses": courses, "times": times, "walls": walls, "paths": paths,
}  # fmt: skip
