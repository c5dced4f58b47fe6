# SPDX-License-Identifier: MIT
"""What is run: the tracking benchmark's boat, courses, SLAM and current."""

import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.studies.mpc.pilot import Predictive
from benchmarks.studies.tracking.loop import Outcome, run
from benchmarks.studies.tracking.scenes import (
    CONDITIONS,
    SCHEMES,
    SHAPES,
    course,
    identified,
    truth,
)
from benchmarks.studies.tracking.study import PILOTS, SEEDS
from seatrial.control import Course, Shape, fitted
from seatrial.control.mpc import Nmpc, by_thrusters
from seatrial.simulation.plan import load_plan
from seatrial.util.frames import Array

PID = "tuned PID, feed-forward"
OWN = "MP"  # allocation of the trials that the predictive controller's model is of: it has the dead zone
QUICK = 1.5  # times what always-forward can give at most, for the courses that leave no room
FREE = 100.0  # [m] of water


@cache
def controller(plan: str, pool: tuple[float, float] = (FREE, FREE)) -> Nmpc:
    """By the identified model."""
    return Nmpc(identified(OWN, plan), pool=pool)


@cache
def compiled(plan: str) -> Nmpc:
    """The same with its step as generated C."""
    found, folder = Nmpc(identified(OWN, plan), pool=(FREE, FREE)), Path(tempfile.mkdtemp())
    library = folder / "step.so"
    source = str(found.generate(folder))
    subprocess.run(["gcc", "-O2", "-shared", "-fPIC", source, "-o", library, "-lm"], check=True)
    found.use(library)
    return found


def timed(controller: Nmpc, hurry: bool) -> Array:
    """[s] each command on the figure of eight, hard SLAM, but for the first."""
    pilot = Predictive(controller)
    path, given = chosen("eight", hurry), CONDITIONS["hard"]
    run(by_thrusters(truth(OWN)), pilot, path, given, SEEDS[0])
    return np.array(pilot.took[1:])


@cache
def quick(shape: str) -> Course:
    """A course at some places of which always-forward falls short."""
    return fitted(SHAPES[shape], truth("AF"), QUICK)


def chosen(shape: str, hurry: bool) -> Course:
    """The tracking benchmark's course, or the quick one."""
    return quick(shape) if hurry else course(shape)


@dataclass(frozen=True)
class Both:
    """The controllers on one course, a run a seed."""

    predictive: tuple[Outcome, ...]
    unsolved: int  # programmes of all of these
    tuned: dict[str, tuple[Outcome, ...]]  # by allocation


@cache
def both(conditions: str, shape: str, hurry: bool) -> Both:
    """Same courses, poses, and current."""
    given, path = CONDITIONS[conditions], chosen(shape, hurry)
    kept, ours, unsolved = controller(given.plan), [], 0
    for seed in SEEDS:
        ours.append(run(by_thrusters(truth(OWN)), Predictive(kept), path, given, seed))
        unsolved += kept.unsolved
    tuned = {
        scheme: tuple(
            run(truth(scheme), PILOTS[PID](scheme, conditions), path, given, seed) for seed in SEEDS
        )
        for scheme in SCHEMES
    }
    return Both(tuple(ours), unsolved, tuned)


@dataclass(frozen=True)
class Beyond(Shape):
    """A circle about the origin that a heading along x is kept on."""

    radius: float  # [m]

    @property
    def length(self) -> float:
        """Radians."""
        return 2.0 * np.pi

    def at(self, s: float) -> Array:
        """From (radius, 0) on, counter-clockwise."""
        c, k = self.radius * np.cos(s), self.radius * np.sin(s)
        return np.array([[c, k, 0.0], [-k, c, 0.0], [-c, -k, 0.0]])


WALLED = Course(Beyond(1.2), 90.0)
CLEARANCE = 0.5  # [m] from the plan's pool


@dataclass(frozen=True)
class Walled:
    """A run on a course that leaves the pool."""

    outcome: Outcome
    path: Array  # (n, 2) [m]
    reach: Array  # (2,) [m] how far |x|, |y| may go
    unsolved: int  # programmes


@cache
def at_walls(seed: int = SEEDS[0]) -> Walled:
    """Hard SLAM."""
    given = CONDITIONS["hard"]
    pool = load_plan(given.plan).pool
    kept = Nmpc(identified(OWN, given.plan), pool=(pool.length, pool.width), clearance=CLEARANCE)
    found = run(by_thrusters(truth(OWN)), Predictive(kept), WALLED, given, seed)
    wanted = np.array([WALLED.at(t).eta[:2] for t in found.t])
    return Walled(found, wanted + found.error[:, :2], kept.reach, kept.unsolved)
