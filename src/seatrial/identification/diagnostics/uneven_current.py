# SPDX-License-Identifier: MIT
"""A current that differs between parts of the recordings: sheared, behind a quay, turning with the tide.

The effect `current` is one velocity for each recording. Here it has a gradient in the plane, the same in all
recordings: the scores of the current in each block, times where the boat was, are those of the gradient. Or it has
a course in time in one of the recordings, a polynomial.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.identification.likelihood.filter_runs import FilterRuns
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.score_information import score_information_in
from seatrial.identification.selection.score_test import LARGE_GAIN, score_test
from seatrial.util.frames import Array

TIME_DEGREE = 4  # of the polynomial in time: a turn of the current, roughly


@dataclass(frozen=True)
class UnevenCurrent:
    """A gradient or a course of the current that is likelier than none."""

    gain: float  # expected fall of -2 log L
    size: float  # [m/s] the largest difference from the recording's mean current

    @property
    def findings(self) -> list[Finding]:
        """What is reported of it."""
        return [finding_of(FindingKind.UNEVEN_CURRENT, size=self.size)]


def uneven_current(runs: FilterRuns) -> UnevenCurrent | None:
    """The likelier of gradient and course of the current by their score tests; None where neither is significant.

    runs: at the solution, with `shares`, and with the current among the free parameters.
    """
    courses = [_places_of_blocks(runs.problem), *_times_of_blocks(runs.problem)]
    found = [one for course in courses if (one := _uneven(runs, course)) is not None]
    return max(found, key=lambda one: one.gain, default=None)


def _uneven(runs: FilterRuns, where: Array) -> UnevenCurrent | None:
    """A current that is linear in columns (blocks, k), if significant."""
    known, p = score_information_in(runs), len(runs.problem.free)
    for axis in ("current_x", "current_y"):
        own = [name.partition(".")[0] == axis for name in known.names]
        known = known.with_courses(np.array(own, dtype=float), where)
    test = score_test(known, list(range(p, len(known.names))), after_step=True)
    if not (test.gain > LARGE_GAIN and test.likely):
        return None
    differences = where @ test.step.reshape(2, -1).T
    return UnevenCurrent(test.gain, float(np.hypot(*differences.T).max()))


def _times_of_blocks(problem: Problem) -> Iterator[Array]:
    """For each recording polynomials (blocks, TIME_DEGREE) of the time in it, 0 in the others."""
    counts = [int(block[-1]) + 1 for block in problem.blocks]
    for first, count in zip(np.cumsum([0, *counts]).tolist(), counts, strict=False):
        course = np.zeros((sum(counts), TIME_DEGREE))
        t = np.linspace(-1.0, 1.0, count)
        course[first : first + count] = np.polynomial.legendre.legvander(t, TIME_DEGREE)[:, 1:]
        yield course


def _places_of_blocks(problem: Problem) -> Array:
    """Mean usable position (blocks, 2) [m] in each block, from the mean of its recording; 0 without one."""
    found = []
    for recording, block in zip(problem.recordings, problem.blocks, strict=True):
        used = recording.valid
        place = recording.eta[used, :2] - recording.eta[used, :2].mean(axis=0)
        count = np.bincount(block[used], minlength=int(block[-1]) + 1)
        sums = [np.bincount(block[used], z, minlength=len(count)) for z in place.T]
        found.append(np.column_stack(sums) / np.maximum(count, 1)[:, None])
    return np.concatenate(found)
