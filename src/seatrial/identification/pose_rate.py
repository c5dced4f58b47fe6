# SPDX-License-Identifier: MIT
"""Searches on part of the poses, and the same solution with all of them.

A boat answers its thrusters in tenths of a second or more, so poses at 10 Hz show the noise structure, the fit
horizon and the stages of the actuator chain as well as those of a motion capture at 100 Hz do. The last search
takes all poses, from near its end.
"""

from collections.abc import Sequence
from dataclasses import replace

from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.linearised import Point, by_linearisation
from seatrial.identification.likelihood.noise_structures import refined
from seatrial.identification.likelihood.optimiser import full_pass, maximise_likelihood
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.problem_setup import with_start
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import MOTION_RATE

SEARCH_RATE = MOTION_RATE  # [Hz] of the poses


def with_fewer_poses(problem: Problem) -> Problem:
    """The problem with poses at about `SEARCH_RATE`, or itself where no recording has more."""
    fewer = tuple(r.thinned(SEARCH_RATE) for r in problem.recordings)
    if _same(fewer, problem.recordings):
        return problem
    return replace(problem, recordings=fewer, whole_period=problem.period)


def with_all_poses(at: Point, whole: Problem, horizon: float, *, hold: bool) -> Point:
    """The solution with the poses of the whole problem, at a fit horizon [s].

    hold: the noise stays. Raises IdentificationError where the search does not converge.
    """
    if _same(at.runs.problem.recordings, whole.recordings):
        return at
    problem = _problem_with(at, whole.recordings)
    least = noise_floor(problem, horizon)
    found = maximise_likelihood(problem, at.theta, at.noise, hold=hold, least=least)
    return found if hold or horizon else refined(found)


def near_with_all_poses(at: Point, whole: Problem) -> Point:
    """The same at the likelihood's maximum, by the linearisation of one pass."""
    if _same(at.runs.problem.recordings, whole.recordings):
        return at
    problem = _problem_with(at, whole.recordings)
    best = by_linearisation(full_pass(problem, at.theta, at.noise))
    return full_pass(problem, best.theta, best.noise)


def near_with_fewer_poses(at: Point) -> Point:
    """A solution with the poses of a search, by the linearisation of one pass."""
    problem = with_fewer_poses(at.runs.problem)
    if problem is at.runs.problem:
        return at
    return by_linearisation(full_pass(problem, at.theta, at.noise))


def _problem_with(at: Point, recordings: tuple[Recording, ...]) -> Problem:
    """The problem of a solution, with all poses of its recordings."""
    problem = replace(at.runs.problem, recordings=recordings, whole_period=0.0)
    return with_start(problem, at.theta)


def _same(some: Sequence[Recording], others: Sequence[Recording]) -> bool:
    return all(a is b for a, b in zip(some, others, strict=True))
