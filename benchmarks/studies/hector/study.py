# SPDX-License-Identifier: MIT
"""Cases of driving, scans and start estimate; errors of pose, start and map."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import seatrial
from benchmarks.harness.workers import Workers, gathered
from benchmarks.studies.hector.ros import Forced, Start, play
from benchmarks.studies.slam.drives import STICKS
from benchmarks.studies.slam.lidar import Scan, scan
from benchmarks.studies.slam.scene import pool_scene
from benchmarks.studies.slam.se2 import between, transform
from benchmarks.studies.slam.study import SEEDS, chosen, driven, error, range_errors
from seatrial.util.frames import Array, Mask
from tests import hector_tools
from tests.ros1_node_tools import build
from tests.ros1_tools import Ros1

EARLIER = (46, 47)  # seeds of the drives that the models are identified from
ALONE, VELOCITY, TRUE = "Hector alone", "constant velocity", "true motion"
ODOMETRY, BY_NODE = "odometry, map → odom by Hector", "odometry, map → odom by the node"
UNRELAYED, GENTLE = "by Hector, not kept current", "by the node, model of gentle drives"
SECOND = "by Hector, model of gentle drives"
STARTS = {
    ALONE: Start(),
    VELOCITY: Start(guess=VELOCITY),
    ODOMETRY: Start(map_to_odom="relay"),
    UNRELAYED: Start(map_to_odom="hector"),
    BY_NODE: Start(map_to_odom="node"),
    GENTLE: Start(map_to_odom="node", model="gentle"),
    SECOND: Start(map_to_odom="relay", model="gentle"),
    TRUE: Start(guess=TRUE),
}
# beyond which a pose is false [m], [rad]: Hector does not undistort scans, and is up to 0.2 m off when driven hard
FALSE = np.array([0.5, 0.3])
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
    used: int  # and answered with a pose
    error: Array  # (n, 2) of the pose: distance [m], turn [rad]
    start_error: Array  # (n, 2)
    map_error: Array  # (m,) [m] of every occupied cell to the nearest surface
    map_points: Array  # (m, 2) [m]

    @property
    def false(self) -> Mask:
        """Poses (n,) that are FALSE."""
        return np.asarray((self.error > FALSE).any(axis=1))

    @property
    def after(self) -> Mask:
        """False poses after the forced match."""
        return self.false[forced_scan(self.scans + 1) - 1 :]  # the scan at rest has no match

    @property
    def false_matches(self) -> int:
        """How often a pose becomes false."""
        return int(np.sum(np.diff(self.false.astype(int), prepend=0) == 1))


@dataclass(frozen=True)
class Study:
    """All that the tables show."""

    earlier: list[Outcome]
    models: dict[str, seatrial.Model]
    outcomes: list[Outcome]


def run(
    cases: Sequence[Case], folder: Path, seeds: Sequence[int] = SEEDS, workers: Workers = None
) -> Study:
    """All cases with every seed; the models are kept in the folder."""
    build()
    earlier, models = identified(folder)
    jobs = [
        (tuple(case for case in cases if case.driving == driving), seed, folder)
        for seed in seeds for driving in STICKS if any(case.driving == driving for case in cases)
    ]  # fmt: skip
    parts = gathered(work, jobs, workers)
    return Study(earlier, models, [outcome for part in parts for outcome in part])


def work(cases: Sequence[Case], seed: int, models: Path) -> list[Outcome]:
    """Cases with one seed."""
    with tempfile.TemporaryDirectory() as name, Ros1(Path(name)) as ros:
        ros.run("rosparam", "set", "use_sim_time", "true")
        return [outcome(ros, case, seed, models) for case in cases]


def identified(folder: Path) -> tuple[list[Outcome], dict[str, seatrial.Model]]:
    """Models by Hector's poses of earlier drives, nothing else.

    First of gentle ones with Hector alone; with that model in the loop hard ones; of all.
    """
    vehicle = seatrial.load_vehicle(hector_tools.vehicle(folder))
    earlier, models, bags = [], {}, []
    stages = (("gentle", Case("gentle", ALONE)), ("model", Case("aggressive", SECOND)))
    with tempfile.TemporaryDirectory() as name, Ros1(Path(name)) as ros:
        ros.run("rosparam", "set", "use_sim_time", "true")
        for model, case in stages:
            for seed in EARLIER:
                bags.append(folder / f"{model}-{seed}.bag")
                earlier.append(outcome(ros, case, seed, folder, bags[-1]))
            models[model] = seatrial.identify([seatrial.read(b, vehicle) for b in bags], vehicle)
            seatrial.save(models[model], folder / f"{model}.yaml")
    return earlier, models


def outcome(ros: Ros1, case: Case, seed: int, models: Path, bag: Path | None = None) -> Outcome:
    """One case with one seed."""
    made, rest, used = driven(case.driving, seed), at_rest(case.driving, seed), given(case, seed)
    forced = Forced(forced_scan(len(used)), FALSE_START) if case.forced else None
    found = play(ros, STARTS[case.start], made, used, models, forced=forced, bag=bag)
    t, pose, start = found.t, found.pose, found.start
    if STARTS[case.start].lock_step:  # where Hector gives no more poses, the last one holds
        t = np.array([scan.stamp for scan in used[1:]])
        held = np.maximum(np.searchsorted(found.t, t + 1e-3) - 1, 0)
        pose, start = pose[held], start[held]
    true = between(rest, made.poses(t))
    points = transform(rest, found.map_points)
    return Outcome(
        case, seed, len(used) - 1, len(found.t), error(true, pose), error(true, start),
        pool_scene().distance(points), points,
    )  # fmt: skip


def forced_scan(scans: int) -> int:
    """Which of the scans, the one at rest included, gets a false start estimate."""
    return round(FORCED_AT * scans)


def given(case: Case, seed: int) -> list[Scan]:
    """One scan at rest, and those of the drive that Hector gets."""
    used = chosen(case.driving, seed, case.every, case.drop_outs)
    return [resting(case.driving, seed), *used]


@cache
def resting(driving: str, seed: int) -> Scan:
    """A scan before the drive."""
    rest, (rng, bias) = at_rest(driving, seed), range_errors(driving, seed)
    return scan(pool_scene(), lambda t: np.tile(rest, (len(t), 1)), 0.0, bias, rng)


def at_rest(driving: str, seed: int) -> Array:
    """The pose (3,) at the start, from which Hector counts."""
    return driven(driving, seed).poses(np.zeros(1))[0]
