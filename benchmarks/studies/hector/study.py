# SPDX-License-Identifier: MIT
"""Cases of driving, scans and start estimate; errors of pose, start and map."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import seatrial
from benchmarks.harness.workers import gathered
from benchmarks.studies.hector.ros import Forced, Found, Start, play
from benchmarks.studies.slam.lidar import Scan, scan
from benchmarks.studies.slam.scene import pool_scene
from benchmarks.studies.slam.se2 import between, transform
from benchmarks.studies.slam.study import (
    FAR,
    SEEDS,
    driven,
    error,
    range_errors,
    scans,
    without_drop_outs,
)
from seatrial.util.frames import Array, Mask
from tests import hector_tools
from tests.ros1_node_tools import build
from tests.ros1_tools import Ros1

EARLIER = (46, 47)  # seeds of the gentle drives that the model is identified from
ALONE, VELOCITY, TRUE = "Hector alone", "constant velocity", "true motion"
ODOMETRY, BY_NODE = "odometry, map → odom by Hector", "odometry, map → odom by the node"
UNRELAYED = "the same, not kept current"
STARTS = {
    ALONE: Start(),
    VELOCITY: Start(guess=VELOCITY),
    ODOMETRY: Start(map_to_odom="relay"),
    UNRELAYED: Start(map_to_odom="hector"),
    BY_NODE: Start(map_to_odom="node"),
    TRUE: Start(guess=TRUE),
}
FALSE_START = (1.0, 0.5, 0.7)  # [m], [m], [rad] of the forced false matches
FORCED_AT = 0.5  # of the drive


@dataclass(frozen=True)
class Case:
    """One way to run a drive through Hector."""

    driving: str
    start: str
    every: int = 1  # of the scans that one is given
    drop_outs: bool = False
    forced: bool = False


@dataclass(frozen=True)
class Outcome:
    """One drive, match by match."""

    case: Case
    seed: int
    scans: int  # that were given
    error: Array  # (n, 2) of the pose: distance [m], turn [rad]
    start_error: Array  # (n, 2)
    map_error: Array  # (m,) [m] of every occupied cell to the nearest surface
    map_points: Array  # (m, 2) [m]

    @property
    def false(self) -> Mask:
        """Poses (n,) that are FAR off."""
        return np.asarray((self.error > FAR).any(axis=1))

    @property
    def false_matches(self) -> int:
        """How often a pose becomes false."""
        return int(np.sum(np.diff(self.false.astype(int), prepend=0) == 1))


def run(cases: Sequence[Case], folder: Path, seeds: Sequence[int] = SEEDS) -> list[Outcome]:
    """All cases with every seed, and the model (`folder`/model.yaml) that they run with."""
    model = identified(folder)
    jobs = [(tuple(cases), seed, model) for seed in seeds]
    return [outcome for part in gathered(work, jobs) for outcome in part]


def work(cases: Sequence[Case], seed: int, model: Path) -> list[Outcome]:
    """Cases with one seed."""
    with tempfile.TemporaryDirectory() as name, Ros1(Path(name)) as ros:
        ros.run("rosparam", "set", "use_sim_time", "true")
        return [outcome(ros, case, seed, model) for case in cases]


def identified(folder: Path) -> Path:
    """The model by Hector's poses and the commands of earlier drives; its file."""
    build()
    vehicle = seatrial.load_vehicle(hector_tools.vehicle(folder))
    bags = [folder / f"run{seed}.bag" for seed in EARLIER]
    with tempfile.TemporaryDirectory() as name, Ros1(Path(name)) as ros:
        ros.run("rosparam", "set", "use_sim_time", "true")
        for seed, bag in zip(EARLIER, bags, strict=True):
            play(ros, Start(), driven("gentle", seed), given(Case("gentle", ALONE), seed), bag=bag)
    model = seatrial.identify([seatrial.read(bag, vehicle) for bag in bags], vehicle)
    path = folder / "model.yaml"
    seatrial.save(model, path)
    return path


def outcome(ros: Ros1, case: Case, seed: int, model: Path) -> Outcome:
    """One case with one seed."""
    found, chosen = track(ros, case, seed, model), given(case, seed)
    made, rest = driven(case.driving, seed), at_rest(case.driving, seed)
    true = between(rest, made.poses(found.t))
    points = transform(rest, found.map_points)
    return Outcome(
        case, seed, len(chosen) - 1, error(true, found.pose), error(true, found.start),
        pool_scene().distance(points), points,
    )  # fmt: skip


def track(ros: Ros1, case: Case, seed: int, model: Path) -> Found:
    """One case with one seed, as Hector estimates it."""
    chosen = given(case, seed)
    forced = Forced(round(FORCED_AT * len(chosen)), FALSE_START) if case.forced else None
    return play(ros, STARTS[case.start], driven(case.driving, seed), chosen, model, forced)


def given(case: Case, seed: int) -> list[Scan]:
    """One scan at rest, and those of the drive that Hector gets."""
    chosen = scans(case.driving, seed)[:: case.every]
    if case.drop_outs:
        chosen = without_drop_outs(chosen, seed)
    return [resting(case.driving, seed), *chosen]


@cache
def resting(driving: str, seed: int) -> Scan:
    """A scan before the drive."""
    rest, (rng, bias) = at_rest(driving, seed), range_errors(driving, seed)
    return scan(pool_scene(), lambda t: np.tile(rest, (len(t), 1)), 0.0, bias, rng)


def at_rest(driving: str, seed: int) -> Array:
    """The pose (3,) at the start, from which Hector counts."""
    return driven(driving, seed).poses(np.zeros(1))[0]
