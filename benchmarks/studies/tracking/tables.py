# SPDX-License-Identifier: MIT
"""The tables of docs/tune.md."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import get_args

import numpy as np

from benchmarks.harness.markdown import table
from benchmarks.studies.tracking.hand import by_hand
from benchmarks.studies.tracking.loop import Outcome
from benchmarks.studies.tracking.scenes import CONDITIONS, SCHEMES, SHAPES, course, truth
from benchmarks.studies.tracking.study import (
    CURRENTS,
    EASY,
    FOLLOWING,
    KNOBS,
    PILOTS,
    STANDING,
    allocated,
    at_knob,
    by_allocator,
    keeping_still,
    outcomes,
    tuned,
)
from seatrial.boat.model import Model
from seatrial.control import Tuning
from seatrial.control.mpc import by_thrusters
from seatrial.control.tuning.dead_zone import dead_zone
from seatrial.control.tuning.design import Action


def tracking() -> str:
    """RMS distance from the reference."""
    rows = []
    for scheme in SCHEMES:
        for conditions in CONDITIONS:
            for shape in SHAPES:
                cells = [position(outcomes(scheme, conditions, shape, pilot)) for pilot in PILOTS]
                rows.append(
                    [scheme, conditions, f"{shape}, {course(shape).duration:.0f} s", *cells]
                )
    return table(["", "SLAM", "course", *(f"{p} [mm]" for p in PILOTS)], rows, text=3)


def position(found: Sequence[Outcome]) -> str:
    """Over all seeds."""
    if any(one.lost for one in found):
        return f"lost {sum(one.lost for one in found)} of {len(found)}"
    return f"{1e3 * np.sqrt(np.mean([one.position**2 for one in found])):.1f}"


def heading() -> str:
    """RMS of heading and of the commands' changes, on the figure of eight."""
    rows = []
    for scheme in SCHEMES:
        for conditions in CONDITIONS:
            found = [outcomes(scheme, conditions, "eight", pilot) for pilot in PILOTS]
            cells = [f"{heading_error(each)}, {_unrest(each)}" for each in found]
            rows.append([scheme, conditions, *cells])
    return table(["", "SLAM", *PILOTS], rows, text=2)


def knobs() -> str:
    """What the knob does."""
    rows = []
    for knob in KNOBS:
        cells = []
        for conditions in ("paper-like", "hard", "paper-like, current"):
            found = at_knob("AF", conditions, knob)
            cells += [position(found), f"{np.mean([one.unrest for one in found]):.3f}"]
        worst = tuned("AF", "paper-like", knob).worst
        rows.append(
            [f"{knob:g}", f"{worst.sensitivity.max():.2f}", f"{np.degrees(worst.phase.min()):.0f}", *cells]
        )  # fmt: skip
    head = ["knob [s]", "sensitivity", "phase [deg]"]
    for conditions in ("paper-like", "hard", "current"):
        head += [f"{conditions} [mm]", "command change"]
    return table(head, rows)


def still() -> str:
    """Keeping still: what the dead zone leaves."""
    boats: dict[str, tuple[Model, Callable[..., Tuning]]] = {
        s: (truth(s), partial(tuned, s, EASY)) for s in SCHEMES
    }
    for name in STANDING:
        boats[f"MP, {name}"] = (by_thrusters(truth("MP")), partial(allocated, name))
    rows = []
    for boat, (plant, tuning_for) in boats.items():
        for action in get_args(Action):
            tuning = tuning_for(action=action)
            dead = dead_zone(tuning.model, tuning.boat, tuning.allocator)[0]
            cells = []
            for current in CURRENTS:
                swing, offset = keeping_still(plant, tuning, current)
                cells += [f"{1e3 * swing:.1f}", f"{1e3 * offset:.1f}"]
            reach = 1e3 * dead / tuning.table()[0, 0]
            rows.append([boat, action.upper(), f"{reach:.1f}", *cells])
    head = ["", "", "dead zone / P [mm]"]
    for current in CURRENTS:
        head += [f"swing [mm], {100 * current[0]:g} cm/s", "offset [mm]"]
    return table(head, rows, text=2)


def allocators() -> str:
    """Tuned PID with feed-forward by an allocator: RMS distance, heading, and the commands' changes."""
    rows = []
    for shape in SHAPES:
        found = [by_allocator(name, shape) for name in FOLLOWING]
        rows.append([shape, *(f"{position(f)}, {heading_error(f)}, {_unrest(f)}" for f in found)])
    return table(["course", *FOLLOWING], rows)


def heading_error(found: Sequence[Outcome]) -> str:
    """RMS over all seeds [mrad]."""
    return f"{1e3 * np.sqrt(np.mean([o.heading**2 for o in found])):.1f}"


def _unrest(found: Sequence[Outcome]) -> str:
    return f"{np.sqrt(np.mean([o.unrest**2 for o in found])):.3f}"


def gains() -> str:
    """Command units per m and m/s; per rad and rad/s."""
    rows = []
    for scheme in SCHEMES:
        for plan in ("paper-like", "hard"):
            for name, odometry in (("by hand", False), ("by hand, our odometry", True)):
                g = by_hand(scheme, plan, odometry)
                rows.append(
                    [scheme, plan, name, *(f"{x:g}" for x in (*g.plane, *g.plane, *g.turn))]
                )
            t = tuned(scheme, plan).table()
            rows.append(
                [scheme, plan, "tuned", *(f"{t[a, k]:.1f}" for a in range(3) for k in (0, 2))]
            )
    head = ["", "SLAM", "", "surge P", "D", "sway P", "D", "yaw P", "D"]
    return table(head, rows, text=3)


MAKERS: dict[str, Callable[[], str]] = {
    "tracking": tracking, "heading": heading, "gains": gains, "knobs": knobs, "still": still,
    "allocators": allocators,
}  # fmt: skip
