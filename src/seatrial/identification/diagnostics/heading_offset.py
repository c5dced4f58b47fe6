# SPDX-License-Identifier: MIT
"""Errors of the heading: a tracker's frame that is turned on the boat, a compass' deviation by iron near it.

Positions are right, but surge shows as sway. Two linearised runs with turned headings give a parabola of the
log likelihood, in which the free parameters take one Gauss-Newton step. A compass' deviation has a period of a
turn (hard iron) or half a turn (soft iron).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.schema import TO_SI, as_column
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.disturbed_intervals import squared_innovations
from seatrial.identification.likelihood.filter_runs import FilterRuns
from seatrial.identification.likelihood.linearised import Point, boxed_step
from seatrial.identification.likelihood.optimiser import maximise_likelihood
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.score_test import LARGE_GAIN, beyond_chance
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Stamps

TRIAL_TURN = 0.05  # [rad] of the two runs for the parabola
MOST_TURN = 0.15  # [rad] in one step: further away the parabola does not hold
LARGEST_HEADING_ERROR = 0.05  # [rad] standard error above which the offset is not identifiable
# share of the spread of even headings, below which the standard error of a deviation is over twice theirs
LEAST_SPREAD = 0.25
LEAST_HEADING_OFFSET = 0.02  # [rad] reported: less hardly biases a coefficient
HeadingError = Callable[[Array], Array]  # [rad] by heading [rad], recorded less true
Correction = Callable[[Recording], Recording]  # of headings


@dataclass(frozen=True)
class HeadingOffset:
    """A heading offset that is likelier than none."""

    gain: float  # expected fall of -2 log L
    by: float  # [rad] recorded less true, forward-left-up
    problem: Problem  # with the headings corrected


def heading_findings(at: Point, first: HeadingOffset, least: Array) -> list[Finding]:
    """The heading offset after fits with corrected headings; none where it is small or the fit hardly better.

    least: (12,) floor of the noise.
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
    found = likelier_size(at, lambda by: by_heading(lambda psi: np.full_like(psi, by)))
    if found is None:
        return None
    by, gain = found
    corrected = _corrected(at.runs.problem, by_heading(lambda psi: np.full_like(psi, by)))
    return HeadingOffset(gain, by, corrected)


@dataclass(frozen=True)
class Deviation:
    """A compass' deviation that is likelier than none."""

    gain: float  # expected fall of -2 log L
    size: float  # [rad] the largest error
    turns: str  # periods in a turn of the boat, in a finding's words

    @property
    def findings(self) -> list[Finding]:
        """What is reported of it."""
        return [finding_of(FindingKind.COMPASS_DEVIATION, size=self.size, turns=self.turns)]


def likelier_deviation(at: Point) -> Deviation | None:
    """The likelier deviation of the two periods; None where neither gains much."""
    found = [one for number in (1, 2) if (one := _deviation(at, number)) is not None]
    return max(found, key=lambda one: one.gain, default=None)


def _deviation(at: Point, number: int) -> Deviation | None:
    """The deviation with so many periods in a turn; sine and cosine have a parabola each."""
    if _spread(at.runs.problem, number) < LEAST_SPREAD:
        return None
    parts = [likelier_size(at, partial(_wave, wave, number)) for wave in (np.sin, np.cos)]
    sine, cosine = (0.0 if part is None else part[0] for part in parts)
    size = float(np.hypot(sine, cosine))
    if size < LEAST_HEADING_OFFSET:
        return None

    def error(psi: Array) -> Array:
        return np.asarray(sine * np.sin(number * psi) + cosine * np.cos(number * psi))

    gain = at.runs.cost - cost_with(at, by_heading(error))
    if not (gain > LARGE_GAIN and in_most_blocks(at, by_heading(error))):
        return None
    return Deviation(gain, size, ("once", "twice")[number - 1])


def _spread(problem: Problem, number: int) -> float:
    """How evenly headings lie in a period, from 0 to 1; in a part of it a deviation looks like an offset."""
    turned = number * np.concatenate([r.eta[r.valid, 2] for r in problem.recordings])
    return float(2.0 * np.linalg.eigvalsh(np.cov(np.sin(turned), np.cos(turned)))[0])


def in_most_blocks(at: Point, correct: Correction) -> bool:
    """Whether poses fit better with corrected headings beyond the scatter of this over blocks (Vuong's test)."""
    still = np.zeros(len(at.theta))
    first = _with(at, correct, still)
    runs = _with(at, correct, boxed_step(at, first.gradient, first.information))
    falls = _squares(at.runs.relinearised(at.noise, still)) - _squares(runs)
    fall, scatter = float(falls.sum()), float(np.sum((falls - falls.mean()) ** 2))
    return fall > 0.0 and scatter > 0.0 and beyond_chance(fall**2 / scatter, 2)


def _squares(runs: FilterRuns) -> Array:
    """Normalised innovations squared, summed in each block (blocks,)."""
    pairs = zip(runs.by_recording, runs.problem.blocks, strict=True)
    return np.concatenate(
        [np.bincount(b, np.nan_to_num(squared_innovations(run))) for run, b in pairs]
    )


def likelier_size(
    at: Point, of: Callable[[float], Correction], cost: float | None = None
) -> tuple[float, float] | None:
    """The size [rad] of a heading error at the parabola's maximum, and its gain in -2 log L.

    of: the correction by a size; cost: -2 log L at size 0, by default the solution's. None where the size is not
    identifiable.
    """
    here = at.runs.cost if cost is None else cost
    back, ahead = cost_with(at, of(-TRIAL_TURN)), cost_with(at, of(TRIAL_TURN))
    slope, bend = (
        (ahead - back) / (2.0 * TRIAL_TURN),
        (ahead + back - 2.0 * here) / TRIAL_TURN**2,
    )
    if not (np.isfinite(slope) and bend > 2.0 / LARGEST_HEADING_ERROR**2):
        return None
    by = float(np.clip(-slope / bend, -MOST_TURN, MOST_TURN))
    return by, float(-(slope * by + 0.5 * bend * by**2))


def psi_offset(vehicle: Vehicle, by: float) -> float:
    """The `offset` of a vehicle file's psi, in its own unit, that takes an error [rad] off."""
    column = as_column(vehicle.file.pose.psi)
    own = vehicle.axes.lateral_sign * by
    return column.offset + column.sign * own * column.scale / TO_SI[column.unit or "rad"]


def _wave(wave: HeadingError, number: int, size: float) -> Correction:
    """The correction of an error with so many periods in a turn."""
    return by_heading(lambda psi: size * wave(number * psi))


def by_heading(error: HeadingError) -> Correction:
    """The correction of an error that depends on the heading."""
    return lambda recording: without_error(recording, error)


def _corrected(problem: Problem, correct: Correction) -> Problem:
    return replace(problem, recordings=tuple(map(correct, problem.recordings)))


def without_error(recording: Recording, error: HeadingError) -> Recording:
    """The recording with headings less by an error that depends on them."""
    return with_headings_less(recording, lambda psi, _: error(psi))


def with_headings_less(recording: Recording, error: Callable[[Array, Stamps], Array]) -> Recording:
    """The recording with headings less by an error that depends on them and on their stamps [ns]."""
    eta, raw, others = recording.eta.copy(), recording.raw.copy(), recording.asynchronous
    for poses in (eta, raw):
        poses[:, 2] -= error(poses[:, 2], recording.stamps)
    turned = None if others is None else others.turned(-error(others.values, others.stamps))
    return replace(recording, eta=eta, raw=raw, asynchronous=turned)


def _with(at: Point, correct: Correction, move: Array) -> FilterRuns:
    """The solution's runs on corrected headings, linearised, a step (names,) of the parameters away."""
    turned = replace(at.runs, problem=_corrected(at.runs.problem, correct))
    return turned.relinearised(at.noise, move)


def cost_with(at: Point, correct: Correction) -> float:
    """-2 log L with corrected headings, after one Gauss-Newton step of the free parameters."""
    return cost_of(at, _corrected(at.runs.problem, correct))


def cost_of(at: Point, there: Problem) -> float:
    """-2 log L of the problem with other poses, after one Gauss-Newton step of the free parameters.

    Infinite where the model diverges along them.
    """
    runs = replace(at.runs, problem=there).relinearised(at.noise, np.zeros(len(at.theta)))
    if not (np.isfinite(runs.cost) and np.isfinite(runs.information).all()):
        return np.inf
    taken = runs.gradient @ np.linalg.pinv(runs.information, hermitian=True) @ runs.gradient
    return float(runs.cost - taken)
