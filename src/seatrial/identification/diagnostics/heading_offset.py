# SPDX-License-Identifier: MIT
"""A heading that is off by a constant: a compass' deviation, a tracker's frame that stands askew on the boat.

Poses stay where they are, but the boat seems to drift: surge is taken for sway. Whether another heading is
likelier is seen from two passes with the poses turned, the free parameters taking up what they can.
"""

from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.schema import TO_SI
from seatrial.boat.vehicle import Vehicle, as_column
from seatrial.identification.likelihood.optimiser import Point, maximise_likelihood
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.score_test import LARGE_GAIN
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Axes

STEP = 0.05  # [rad] by which poses are turned to see what it does
MOST = 0.15  # [rad] at once: further off the parabola is none
SHARP = 0.05  # [rad] standard error above which the data say nothing of it
ROUNDS = 8  # of turning and searching
SETTLED = 0.01  # [rad]
LEAST = 0.02  # [rad] less is not worth a word


@dataclass(frozen=True)
class Askew:
    """A heading that is likelier."""

    gain: float  # fall of -2 log likelihood that it promises
    by: float  # [rad] recorded less true, forward-left-up
    problem: Problem  # with the poses turned back


def askew_said(at: Point, first: Askew, least: Array) -> list[Finding]:
    """How far the heading is off, and what to write; none where there is no solution about it.

    least: noise that the search does not go below.
    """
    vehicle, found, total = at.runs.problem.vehicle, first, first.by
    there = at
    for _ in range(ROUNDS):
        try:
            there = maximise_likelihood(found.problem, there.theta, there.noise, least=least)
        except IdentificationError:
            return []
        again = askew(there)
        if again is None:
            return []
        total, found = total + again.by, again
        if abs(again.by) < SETTLED:
            break
    if abs(total) < LEAST or there.runs.cost > at.runs.cost - LARGE_GAIN:
        return []
    offset = psi_offset(vehicle, total)
    return [finding_of(FindingKind.HEADING_OFFSET, size=abs(total), psi_offset=offset)]


def askew(at: Point) -> Askew | None:
    """The heading that is likelier than the recorded one, by a parabola; None where the data don't tell one."""
    problem = at.runs.problem
    back, ahead = (_cost(_turned(problem, by), at) for by in (-STEP, STEP))
    slope, bend = (ahead - back) / (2.0 * STEP), (ahead + back - 2.0 * at.runs.cost) / STEP**2
    if not (np.isfinite(slope) and bend > 2.0 / SHARP**2):
        return None
    by = float(np.clip(-slope / bend, -MOST, MOST))
    gain = -(slope * by + 0.5 * bend * by**2)
    return Askew(float(gain), by, _turned(problem, by))


def psi_offset(vehicle: Vehicle, by: float) -> float:
    """The `offset` of a vehicle file's psi, in its own unit, that takes an error [rad] off."""
    column = as_column(vehicle.file.pose.psi)
    own = -by if vehicle.axes is Axes.FRD else by
    return column.offset + column.sign * own * column.scale / TO_SI[column.unit or "rad"]


def _turned(problem: Problem, by: float) -> Problem:
    return replace(problem, recordings=tuple(without_offset(r, by) for r in problem.recordings))


def without_offset(recording: Recording, by: float) -> Recording:
    """The recording with headings less by so much [rad]."""
    less = np.array([0.0, 0.0, by])
    return replace(recording, eta=recording.eta - less, raw=recording.raw - less)


def _cost(problem: Problem, at: Point) -> float:
    """-2 log likelihood there once the free parameters have taken one step of Gauss and Newton."""
    runs = problem.run_filter(at.theta, at.noise, repeatable=False)
    taken = runs.gradient @ np.linalg.pinv(runs.information, hermitian=True) @ runs.gradient
    return float(runs.cost - taken)
