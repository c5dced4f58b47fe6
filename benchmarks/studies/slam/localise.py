# SPDX-License-Identifier: MIT
"""Scan-to-map SLAM along a drive, with a guess: match, gate, map; all but the guess is the same."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.studies.slam.guesses import Guess
from benchmarks.studies.slam.lidar import Scan, undistorted
from benchmarks.studies.slam.mapping import REACH, Map, Match
from benchmarks.studies.slam.se2 import between
from seatrial.util.frames import Array, Mask

SHARE = 0.5  # of a scan's points that must be on the map; a turn brings up to half into view
FASTEST = np.array([0.6, 2.0])  # [m/s], [rad/s] that a boat may have moved since the last match,
ROOM = np.array([0.1, 0.1])  # [m], [rad] and its error
NEW_VIEW = np.array([0.4, 0.4])  # [m], [rad] from the last scan in the map to the next
BUSY = 0.75  # share of the time between scans that a match takes


@dataclass(frozen=True)
class Track:
    """Scan by scan; the first starts the map and is left out."""

    t: Array  # (n,) [s]
    pose: Array  # (n, 3): the match where it was accepted, the guess where not
    guess: Array  # (n, 3)
    accepted: Mask  # (n,)
    iterations: Array  # (n,)
    map_points: Array  # (m, 2) [m]


def localise(
    scans: Sequence[Scan], guess: Guess, *, undistort: bool = True, reach: float = REACH
) -> Track:
    """Match scan after scan from a map that begins with the first, at the guess's own pose.

    The guess gets the commands up to a scan's end, and a match when the matcher has finished.
    """
    chart, viewed = Map(scans[0].points, guess.pose), guess.pose
    rows: list[tuple[Array, Array, bool, int]] = []
    for scan, following in zip(scans[1:], [*scans[2:], scans[-1]], strict=True):
        guess.commands_until(scan.end)
        start = guess.poses(np.array([scan.stamp]))[0]
        points = undistorted(scan, guess.poses) if undistort else scan.points
        match = chart.match(points, start, reach)
        good = plausible(match, guess, scan.stamp)
        rows.append((match.pose if good else start, start, good, match.iterations))
        if not good:
            continue
        guess.commands_until(scan.end + BUSY * (following.stamp - scan.stamp))
        guess.accepted(scan.stamp, match.pose)
        if np.any(moved(viewed, match.pose) > NEW_VIEW):
            chart.insert(points, match.pose)
            viewed = match.pose
    pose, start_pose, accepted, iterations = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    t = np.array([scan.stamp for scan in scans[1:]])
    return Track(t, pose, start_pose, accepted, iterations, chart.points)


def plausible(match: Match, guess: Guess, t: float) -> bool:
    """Converged, on the map, and not farther from the last match than a boat gets."""
    near = moved(guess.pose, match.pose) <= ROOM + FASTEST * (t - guess.t)
    return match.converged and match.share >= SHARE and bool(near.all())


def moved(a: Array, b: Array) -> Array:
    """Distance [m] and turn [rad] between two poses."""
    step = between(a, b)
    return np.array([np.hypot(step[0], step[1]), abs(step[2])])
