# SPDX-License-Identifier: MIT
"""The last search of a drive that goes on: a warm search from it, and linearised steps along new poses."""

from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.findings import FindingKind
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import present
from seatrial.identification.diagnostics.solution_checks import at_bound_findings
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.growing_filter import GrowingFilter
from seatrial.identification.likelihood.linearised import START_DAMPING, Point, bounded_step
from seatrial.identification.likelihood.optimiser import Outcome, far_from_poses, search
from seatrial.identification.likelihood.problem import Prior, Problem
from seatrial.identification.problem_setup import integration_step
from seatrial.identification.solution import Fit
from seatrial.identification.uncertainty.covariance import with_enough_blocks
from seatrial.identification.uncertainty.estimation_errors import estimation_covariance
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array
from seatrial.util.statistics import inverse_of

MOST_SEARCHED = 120_000  # poses of a search: 40 min at 50 Hz
WARM_PASSES = 12  # full ones of a warm search, at most
RENEWED = (  # findings of every search
    FindingKind.AT_BOUND,
    FindingKind.BEYOND_RANGE,
    FindingKind.SHORT_BLOCKS,
)


@dataclass(frozen=True)
class Solution:
    """The last search, and the filter that goes on from it."""

    fit: Fit
    model: Model
    going: GrowingFilter
    information: Array  # (p, p) of the poses that the search used
    thorough: float  # [s] of the drive at the last thorough search; 0: there was none

    @property
    def first(self) -> int:
        """Stamp [ns] of the first pose that is not condensed."""
        return self.fit.problem.recordings[0].origin


def solution_of(found: Fit, thorough: float, hold: int) -> Solution:
    """The filter goes on at the solution's parameters, from `hold` [ns] before its newest pose."""
    newest = int(found.problem.recordings[0].stamps[-1])
    going = GrowingFilter(found.problem, found.theta, found.noise)
    going.begin(newest - hold)
    return Solution(found, found.model(), going, going.at().runs.information, thorough)


def warm(last: Fit, recording: Recording) -> Fit | None:
    """The maximum from the last one, in its structure; None where the search does not end."""
    problem = replace(last.problem, recordings=(recording,), block=last.settings.block)
    if len(recording.t) > MOST_SEARCHED:
        problem = _condensed(problem, last)
    problem = replace(with_enough_blocks(problem), step=integration_step(problem, last.theta))
    at, outcome = search(
        problem, last.theta, last.noise, least=noise_floor(problem, last.horizon),
        free=present(last.noise), passes=WARM_PASSES,
    )  # fmt: skip
    if outcome not in (Outcome.CONVERGED, Outcome.OUT_OF_STEPS) or far_from_poses(at):
        return None
    covariance = estimation_covariance(at)
    at.runs.drop_linearisation()
    kept = [f for f in last.findings if f.kind not in RENEWED]
    return replace(
        last,
        findings=(*kept, *at_bound_findings(at)),
        problem=problem,
        theta=at.theta,
        noise=at.noise,
        runs=at.runs,
        covariance=covariance,
    )


def _condensed(problem: Problem, last: Fit) -> Problem:
    """The problem of the later half of its recording, with what the earlier half knows as prior."""
    (recording,) = problem.recordings
    middle = float(recording.t[len(recording.t) // 2])
    older = replace(problem, recordings=(recording.cut(None, middle),))
    runs = filter_along(older, last.theta, last.noise, repeatable=False)
    free = list(problem.free)
    mean, precision = last.theta.copy(), np.zeros((len(last.theta),) * 2)
    mean[free] += inverse_of(runs.information) @ runs.gradient
    precision[np.ix_(free, free)] = runs.information
    later = recording.cut(middle, None)
    return replace(problem, recordings=(later,), prior=Prior(mean, precision))


def stepped(last: Solution, at: Point) -> Model:
    """The model a Gauss-Newton step from the last search, with the information of all poses so far."""
    move, _ = bounded_step(at, START_DAMPING)
    problem = last.fit.problem
    theta = problem.clipped(at.theta + move)
    n, m = problem.n_coefficients, problem.n_constants
    covariance = _covariance(last, at.runs.information)
    return replace(
        last.model, coefficients=theta[:n], constants=theta[n : n + m],
        covariance=replace(last.fit, covariance=covariance).model_covariance(),
    )  # fmt: skip


def _covariance(last: Solution, information: Array) -> Array:
    """The covariance (p, p) with more information: the scores of new poses scatter as those of the search did."""
    old = last.fit.covariance
    inside = np.diag(old) > 0.0
    within = np.ix_(inside, inside)
    before, after = last.information[within], information[within]
    factor = scatter_ratio(old, last.information)
    inverse = inverse_of(after)
    scatter = before @ old[within] @ before + factor * (after - before)
    out = np.zeros_like(old)
    out[within] = inverse @ scatter @ inverse
    return out


def scatter_ratio(covariance: Array, information: Array) -> float:
    """Mean ratio of the covariance (p, p) to the inverse information (p, p), of what is estimated."""
    inside = np.diag(covariance) > 0.0
    within = np.ix_(inside, inside)
    return float(np.sum(information[within] * covariance[within])) / max(int(inside.sum()), 1)
