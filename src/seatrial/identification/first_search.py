# SPDX-License-Identifier: MIT
"""The first maximum of the likelihood, from start values; and why there is none."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.identification.diagnostics.external_disturbances import disturbance_hint
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import (
    MOST_PASSES,
    converged,
    maximise_likelihood,
    search,
)
from seatrial.identification.likelihood.parameters import LEVER_NAMES
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.pose_rate import with_fewer_poses
from seatrial.identification.problem_setup import problem_with, start_of, with_start
from seatrial.identification.selection.actuator_stages import with_estimated_stages
from seatrial.identification.solution import OutputErrorSettings, StartValues
from seatrial.identification.uncertainty.covariance import with_enough_blocks
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError

FIRST_PASSES = 9  # of the first search, at most
LEAST_LEVER_ARM = 0.02  # [m] a shorter one does not explain why there is no solution


def first_maximum(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    effects: Sequence[str] = (),
    *,
    start: StartValues | None = None,
) -> Point:
    """The maximum of the likelihood that the search from start values finds, with poses at `SEARCH_RATE`.

    No fit horizon, no further stages.
    """
    problem = first_problem(recordings, vehicle, effects)
    return maximised(with_fewer_poses(problem), recordings, start, hold=False)


def first_problem(
    recordings: Sequence[Recording], vehicle: Vehicle, effects: Sequence[str] = ()
) -> Problem:
    """The problem before any search. Raises IdentificationError where recordings are too short for it."""
    whole, _ = with_estimated_stages(vehicle, recordings)
    settings = OutputErrorSettings(effects=tuple(effects))
    return with_enough_blocks(problem_with(whole, vehicle, recordings, settings))


def maximised(
    problem: Problem, recordings: Sequence[Recording], start: StartValues | None, *, hold: bool
) -> Point:
    """The maximum of the likelihood, or a point near it where the search is slow, as under model mismatch.

    If the search from given start values fails, as the boat has changed, it starts again without one.
    """
    theta, noise = start_of(problem, recordings, start)
    own = with_start(problem, theta)
    try:
        found = search(own, theta, noise, hold=hold, passes=MOST_PASSES if hold else FIRST_PASSES)
        return converged(found, or_near=not hold)
    except IdentificationError as error:
        if start is not None and not hold:
            return maximised(problem, recordings, None, hold=False)
        hint = disturbance_hint(problem, _from_start_values) or _lever_arm_hint(problem, recordings)
        raise IdentificationError(f"{error}{hint}") from error


def _from_start_values(problem: Problem) -> Point:
    """The maximum of the likelihood from start values; no further attempts."""
    theta, noise = start_of(problem, problem.recordings, None)
    return maximise_likelihood(with_start(problem, theta), theta, noise)


def _lever_arm_hint(problem: Problem, recordings: Sequence[Recording]) -> str:
    """Text for a refusal: the lever arm with which there is a solution; empty without one."""
    lever = tuple(i for i, name in enumerate(problem.names) if name in LEVER_NAMES)
    if set(lever) & set(problem.free):
        return ""
    wider = replace(problem, free=(*problem.free, *lever))
    theta, noise = start_of(wider, recordings, None)
    try:
        found = maximise_likelihood(with_start(wider, theta), theta, noise).theta[list(lever)]
    except IdentificationError:
        return ""
    if np.hypot(*found) < LEAST_LEVER_ARM:
        return ""
    return (
        f". There is a solution with poses of a point about {np.hypot(*found):.2g} m off the origin, a lever arm. "
        "If it is plausible, identify with --effect lever"
    )
