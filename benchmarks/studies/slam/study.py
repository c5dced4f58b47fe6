# SPDX-License-Identifier: MIT
"""Cases of driving, scans and guess; errors of pose, guess and map."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.harness.workers import gathered
from benchmarks.studies.slam.drives import DURATION, PUSHED, STICKS, Drive, drive
from benchmarks.studies.slam.guesses import (
    ConstantPose,
    ConstantVelocity,
    Guess,
    ModelOdometry,
    TrueMotion,
)
from benchmarks.studies.slam.lidar import BIAS, RATE, Scan, scan
from benchmarks.studies.slam.localise import Track, localise
from benchmarks.studies.slam.mapping import REACH
from benchmarks.studies.slam.scene import pool_scene
from benchmarks.studies.slam.se2 import between
from seatrial.simulation.plan import DropOuts
from seatrial.util.frames import Array, Mask
from tests.boats.drives import model

SEEDS = range(51, 56)
GUESSES = (
    "constant pose", "constant velocity", "predictor, the paper's model", "predictor", "true motion",
)  # fmt: skip
DROP_OUTS = DropOuts(per_minute=4.0, shortest=0.5, longest=2.0)
FAR = np.array([0.2, 0.1])  # [m], [rad] from the truth: a pose that far off is false
OFF = 0.15  # [m] from any surface: more than the sensor's own error


@dataclass(frozen=True)
class Case:
    """One way to run a drive through the SLAM."""

    driving: str
    guess: str
    every: int = 1  # of the scans that one is matched
    drop_outs: bool = False
    undistort: bool = True
    reach: float = REACH  # [m] farthest correspondence of the matcher


@dataclass(frozen=True)
class Outcome:
    """One drive, scan by scan."""

    case: Case
    seed: int
    error: Array  # (n, 2) of the pose: distance [m], turn [rad]
    guess_error: Array  # (n, 2)
    accepted: Mask  # (n,)
    iterations: Array  # (n,)
    map_error: Array  # (m,) [m] of every point of the map to the nearest surface

    @property
    def false(self) -> Mask:
        """Poses (n,) that are FAR off."""
        return np.asarray((self.error > FAR).any(axis=1))


def run(cases: Sequence[Case], seeds: Sequence[int] = SEEDS) -> list[Outcome]:
    """All cases with every seed; a process has one drive at a time."""
    jobs = [
        (tuple(case for case in cases if case.driving == driving), seed)
        for seed in seeds for driving in STICKS if any(case.driving == driving for case in cases)
    ]  # fmt: skip
    return [outcome for part in gathered(work, jobs) for outcome in part]


def work(cases: Sequence[Case], seed: int) -> list[Outcome]:
    """Cases with one seed."""
    return [outcome(case, seed) for case in cases]


def outcome(case: Case, seed: int) -> Outcome:
    """One case with one seed."""
    found = track(case, seed)
    true = driven(case.driving, seed).poses(found.t)
    return Outcome(
        case, seed, error(true, found.pose), error(true, found.guess), found.accepted,
        found.iterations, pool_scene().distance(found.map_points),
    )  # fmt: skip


def track(case: Case, seed: int) -> Track:
    """One case with one seed, as the SLAM estimates it."""
    used = chosen(case.driving, seed, case.every, case.drop_outs)
    start = guess(case, seed, used[0].stamp)
    return localise(used, start, undistort=case.undistort, reach=case.reach)


def guess(case: Case, seed: int, t: float) -> Guess:
    """The case's guess, which knows the true pose at the start t [s]."""
    made = driven(case.driving, seed)
    pose = made.poses(np.array([t]))[0]
    if case.guess == "constant pose":
        return ConstantPose(t, pose)
    if case.guess == "constant velocity":
        return ConstantVelocity(t, pose)
    if case.guess == "true motion":
        return TrueMotion(t, pose, made.poses)
    method = "output-error" if case.guess == "predictor" else "equation-error"
    return ModelOdometry(t, pose, model(PUSHED, seed, method), made)


@cache
def driven(driving: str, seed: int) -> Drive:
    """The drive."""
    return drive(driving, seed)


@cache
def scans(driving: str, seed: int) -> list[Scan]:
    """All scans of a drive."""
    rng, bias = range_errors(driving, seed)
    made, scene = driven(driving, seed), pool_scene()
    stamps = np.arange(1, round(DURATION * RATE)) / RATE
    return [scan(scene, made.poses, stamp, bias, rng) for stamp in stamps.tolist()]


def chosen(driving: str, seed: int, every: int, drop_outs: bool) -> list[Scan]:
    """The scans of a drive that a case uses."""
    kept = scans(driving, seed)[::every]
    return without_drop_outs(kept, seed) if drop_outs else kept


def range_errors(driving: str, seed: int) -> tuple[np.random.Generator, float]:
    """Statistical errors of a drive's scans, and the systematic one [m], which all have."""
    rng = np.random.default_rng([seed, list(STICKS).index(driving), 1])
    return rng, float(rng.uniform(-BIAS, BIAS))


def without_drop_outs(given: Sequence[Scan], seed: int) -> list[Scan]:
    """Scans but those in DROP_OUTS; the first stays."""
    rng = np.random.default_rng([seed, 2])
    begins = rng.uniform(0.0, DURATION, rng.poisson(DROP_OUTS.per_minute * DURATION / 60.0))
    ends = begins + rng.uniform(DROP_OUTS.shortest, DROP_OUTS.longest, len(begins))
    gone = [bool(np.any((begins <= s.stamp) & (s.stamp < ends))) for s in given]
    return [given[0], *(s for s, out in zip(given[1:], gone[1:], strict=True) if not out)]


def error(true: Array, pose: Array) -> Array:
    """Distance [m] and turn [rad] (n, 2) between poses (n, 3)."""
    off = between(true, pose)
    return np.column_stack([np.hypot(off[:, 0], off[:, 1]), np.abs(off[:, 2])])
