# SPDX-License-Identifier: MIT
"""Headings that are the course over ground: where the boat moves to, not where it points."""

import numpy as np

from seatrial.recording.pose_noise import known_pose_noise
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

# [s] in which the boat moves on, the shortest that resolves its direction
SPANS = (0.5, 1.0, 2.0, 4.0)
RESOLVED = 0.05  # [rad] standard deviation of a direction that is resolved
LEAST_SHARE = 0.3  # of the spans whose direction is
MOST_HEADINGS = (5.0, 95.0)  # [percentiles] the range of the heading
LEAST_TURNED = 1.5  # [rad] of that range: on a straight track a boat hardly drifts sideways
BY_NOISE = 3.0  # times the noise of direction and heading: below it the two do not differ
FEWEST = 20  # spans


def course_doubt(recording: Recording) -> list[str]:
    """The doubt whether headings are headings, of a boat that seems not to drift sideways where it turns."""
    if (noise := known_pose_noise(recording)) is None:
        return []
    for span in SPANS:
        moved, heading = _displacements(recording, span)
        distance = np.hypot(*moved.T)
        resolved = (distance > np.sqrt(2.0) * noise.position / RESOLVED) & (distance > 0.0)
        if resolved.sum() < max(FEWEST, LEAST_SHARE * len(distance)):
            continue
        course = np.arctan2(moved[resolved, 1], moved[resolved, 0])
        apart = np.angle(np.exp(1j * (course - heading[resolved])))
        sideways = float(np.sqrt(np.mean(apart**2)))
        of_course = np.mean(2.0 * (noise.position / distance[resolved]) ** 2)
        expected = np.sqrt(of_course + noise.heading**2)
        turned = float(np.ptp(np.percentile(heading[resolved], MOST_HEADINGS)))
        if turned < LEAST_TURNED or sideways > BY_NOISE * expected:
            return []
        return [
            f"heading: within {np.degrees(sideways):.2g} degrees (RMS) of the direction of motion, also in turns. "
            "Is it the course over ground? A boat drifts sideways in turns; with the course the model is wrong. "
            "Give the heading of a compass, of two antennas or of SLAM"
        ]
    return []


def _displacements(recording: Recording, span: float) -> tuple[Array, Array]:
    """Displacements (n, 2) [m] from each usable pose in about `span` [s], and the mean headings (n,) [rad]."""
    used = recording.valid
    t, eta, segment = recording.t[used], recording.eta[used], recording.segment[used]
    ends = np.searchsorted(t, t + span)
    start = np.flatnonzero(ends < len(t))
    end = ends[start]
    near = (segment[start] == segment[end]) & (t[end] - t[start] < 1.5 * span)
    start, end = start[near], end[near]
    sums = np.concatenate([[0.0], np.cumsum(eta[:, 2])])
    heading = (sums[end + 1] - sums[start]) / (end + 1 - start)
    return eta[end, :2] - eta[start, :2], heading
