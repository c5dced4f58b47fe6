# SPDX-License-Identifier: MIT
"""A current that differs between parts of the recordings: sheared, behind a quay, turning with the tide.

The effect `current` is one velocity for each recording. Here it has a gradient in the plane, the same in all
recordings: the scores of the current in each block, times where the boat was, are those of the gradient.
"""

from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.score_information import score_information
from seatrial.identification.selection.score_test import LARGE_GAIN, score_test
from seatrial.util.frames import Array


@dataclass(frozen=True)
class UnevenCurrent:
    """A gradient of the current that is likelier than none."""

    gain: float  # expected fall of -2 log L
    size: float  # [m/s] the largest difference from the recording's mean current

    @property
    def findings(self) -> list[Finding]:
        """What is reported of it."""
        return [finding_of(FindingKind.UNEVEN_CURRENT, size=self.size)]


def uneven_current(at: Point) -> UnevenCurrent | None:
    """The gradient of the current by its score test; None where it is not significant."""
    problem = at.runs.problem
    axes = [_places(problem, name) for name in ("current_x", "current_y")]
    new = [i for own in axes for i in own if i not in problem.free]
    wider = replace(problem, free=(*problem.free, *new))
    known = score_information(wider, at.theta, at.noise)
    where, p = _places_of_blocks(problem), len(wider.free)
    for own in axes:
        weights = np.zeros(len(known.names))
        weights[[wider.free.index(i) for i in own]] = 1.0
        known = known.with_courses(weights, where)
    test = score_test(known, list(range(p, len(known.names))), after_step=True)
    if not (test.gain > LARGE_GAIN and test.likely):
        return None
    differences = where @ test.step.reshape(2, 2).T
    return UnevenCurrent(test.gain, float(np.hypot(*differences.T).max()))


def _places(problem: Problem, name: str) -> list[int]:
    """Where the parameters of this name, one of each recording, stand among all."""
    return [i for i, n in enumerate(problem.names) if n.partition(".")[0] == name]


def _places_of_blocks(problem: Problem) -> Array:
    """Mean position (blocks, 2) [m] in each block, from the mean of its recording."""
    found = []
    for recording, block in zip(problem.recordings, problem.blocks, strict=True):
        sums = [np.bincount(block, z) for z in recording.eta[:, :2].T]
        own = np.column_stack(sums) / np.bincount(block)[:, None]
        found.append(own - own.mean(axis=0))
    return np.concatenate(found)
