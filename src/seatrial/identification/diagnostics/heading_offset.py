# SPDX-License-Identifier: MIT
"""A constant offset of the heading: a compass' deviation, a tracker's frame that is turned on the boat.

Positions are right, but surge shows as sway. Two filter runs with turned headings give a parabola of the
log likelihood, in which the free parameters take one Gauss-Newton step.
"""

from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.schema import TO_SI, as_column
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import maximise_likelihood
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.score_test import LARGE_GAIN
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

TRIAL_TURN = 0.05  # [rad] of the two runs for the parabola
MOST_TURN = 0.15  # [rad] in one step: further away the parabola does not hold
LARGEST_HEADING_ERROR = 0.05  # [rad] standard error above which the offset is not identifiable
LEAST_HEADING_OFFSET = 0.02  # [rad] reported: less hardly biases a coefficient


@dataclass(frozen=True)
class HeadingOffset:
    """A heading offset that is likelier than none."""

    gain: float  # expected fall of -2 log L
    by: float  # [rad] recorded less true, forward-left-up
    problem: Problem  # with the headings corrected


def heading_findings(at: Point, first: HeadingOffset, least: Array) -> list[Finding]:
    """The heading offset after fits with corrected headings; none where it is small or the fit hardly better.

    least: (11,) floor of the noise.
    """
    vehicle, found, total = at.runs.problem.vehicle, first, first.by
    there = at
    for _ in range(8):  # fits at most
        try:
            there = maximise_likelihood(found.problem, there.theta, there.noise, least=least)
        except IdentificationError:
            return []
        again = likelier_heading(there)
        if again is None:
            return []
        total, found = total + again.by, again
        if abs(again.by) < 0.01:  # [rad]
            break
    if abs(total) < LEAST_HEADING_OFFSET or there.runs.cost > at.runs.cost - LARGE_GAIN:
        return []
    offset = psi_offset(vehicle, total)
    return [finding_of(FindingKind.HEADING_OFFSET, size=abs(total), psi_offset=offset)]


def likelier_heading(at: Point) -> HeadingOffset | None:
    """The maximum of the parabola over the heading offset; None where the offset is not identifiable."""
    problem = at.runs.problem
    back, ahead = (_cost(_turned(problem, by), at) for by in (-TRIAL_TURN, TRIAL_TURN))
    slope, bend = (
        (ahead - back) / (2.0 * TRIAL_TURN),
        (ahead + back - 2.0 * at.runs.cost) / TRIAL_TURN**2,
    )
    if not (np.isfinite(slope) and bend > 2.0 / LARGEST_HEADING_ERROR**2):
        return None
    by = float(np.clip(-slope / bend, -MOST_TURN, MOST_TURN))
    gain = -(slope * by + 0.5 * bend * by**2)
    return HeadingOffset(float(gain), by, _turned(problem, by))


def psi_offset(vehicle: Vehicle, by: float) -> float:
    """The `offset` of a vehicle file's psi, in its own unit, that takes an error [rad] off."""
    column = as_column(vehicle.file.pose.psi)
    own = vehicle.axes.lateral_sign * by
    return column.offset + column.sign * own * column.scale / TO_SI[column.unit or "rad"]


def _turned(problem: Problem, by: float) -> Problem:
    return replace(problem, recordings=tuple(without_offset(r, by) for r in problem.recordings))


def without_offset(recording: Recording, by: float) -> Recording:
    """The recording with headings less by so much [rad]."""
    less = np.array([0.0, 0.0, by])
    asynchronous = None if recording.asynchronous is None else recording.asynchronous.turned(-by)
    return replace(
        recording, eta=recording.eta - less, raw=recording.raw - less, asynchronous=asynchronous
    )


def _cost(problem: Problem, at: Point) -> float:
    """-2 log L after one Gauss-Newton step of the free parameters."""
    runs = filter_along(problem, at.theta, at.noise, repeatable=False)
    taken = runs.gradient @ np.linalg.pinv(runs.information, hermitian=True) @ runs.gradient
    return float(runs.cost - taken)
