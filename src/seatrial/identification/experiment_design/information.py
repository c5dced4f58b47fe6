# SPDX-License-Identifier: MIT
"""The information of each recording about a model's parameters, and the estimates from it alone.

The likelihood of the innovations along one recording has a known gradient and Fisher information. A few steps of
Fisher scoring from the model's values, at its noise, give the estimates from this recording alone; parameters
that it does not determine stay near the model's.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.model import FIT_HORIZON, Model
from seatrial.boat.noise_parameters import OUTLIER, earth_fixed
from seatrial.evaluation.filtering import filter_noise
from seatrial.evaluation.input_errors import input_errors
from seatrial.identification.likelihood.filter_runs import FilterRuns, filter_along
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.parameters import typical_size
from seatrial.identification.likelihood.problem import Problem
from seatrial.recording.recording import Recording
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array
from seatrial.util.parallel import spread
from seatrial.util.statistics import BLOCK, pseudo_inverse

SCORING_CONVERGED = 0.1  # fall of -2 log likelihood: a step that gains less is the last


@dataclass(frozen=True)
class ReferencePoint:
    """A model's estimated parameters and noise, at which information is evaluated."""

    model: Model
    names: tuple[str, ...]  # (p,) of what was estimated
    theta: Array  # (p,) their values
    noise: Array  # (12,) of the filter

    def problem(self, recordings: Sequence[Recording]) -> Problem:
        """The estimation problem of some recordings."""
        return _problem(self.model, recordings)

    def run_filter(
        self, recordings: Sequence[Recording], start_velocities: Sequence[Array] = ()
    ) -> FilterRuns:
        """The filter along some recordings, at the model's values.

        start_velocities: (3,) at their first poses, where they are simulated.
        """
        problem = replace(self.problem(recordings), start_velocities=tuple(start_velocities))
        return filter_along(problem, _values(self.model, problem), self.noise, repeatable=False)


@dataclass(frozen=True)
class RecordingInformation:
    """The information of one recording, and the estimates from it alone."""

    recording: str
    minutes: float
    information: Array  # (p, p) Fisher information at the model's values
    gradient: Array  # (p,) of the log likelihood, at the model's values
    values: Array  # (p,) estimates from it alone
    errors: Array  # (p,) their standard errors; infinite where not identifiable


def reference_point(
    model: Model, recordings: Sequence[Recording], noise: Array | None = None
) -> ReferencePoint:
    """The model's estimated parameters, and the noise (12,) that they were estimated with.

    A model without process noise gets `noise`, or that under which `recordings` are most likely.
    Raises ModelError where nothing was estimated, or where the model diverges.
    """
    values = np.concatenate([model.coefficients, model.constants])
    estimated = np.flatnonzero(np.diag(model.covariance) > 0)
    if not len(estimated):
        raise ModelError("nothing was estimated: the model's values were given")
    noise = filter_noise(model, recordings) if noise is None else noise
    horizon = float(model.estimator.settings.get(FIT_HORIZON) or 0.0)
    if horizon > 0.0:
        noise = np.maximum(noise, noise_floor(_problem(model, recordings), horizon))
    return ReferencePoint(
        model, tuple(model.parameters[i] for i in estimated), values[estimated], noise
    )


def information_by_recording(
    point: ReferencePoint, recordings: Sequence[Recording]
) -> list[RecordingInformation]:
    """Information and estimates of each recording. Raises ModelError where the model diverges in one."""
    return spread(lambda recording: _alone(point, recording), recordings, "recording")


def _alone(point: ReferencePoint, recording: Recording) -> RecordingInformation:
    first = here = point.run_filter([recording])
    if not here.by_recording[0].good:
        raise ModelError(f"{recording.name}: the model diverges in its own filter")
    free = list(here.problem.free)
    # keeps undetermined parameters near the model's
    weak_prior = np.diag(1.0 / np.square(_sizes(point)))
    for _ in range(6):  # steps at most
        off = here.theta[free] - point.theta
        slope = here.gradient - weak_prior @ off
        move = np.asarray(np.linalg.solve(here.information + weak_prior, slope))
        if slope @ move < SCORING_CONVERGED:  # the promised fall
            break
        better = _better(here, move, point, weak_prior)
        if better is None:
            break
        here = better
    information = here.information_of(0)
    inverse, known = pseudo_inverse(information)
    excess = _excess(information, here.scores)
    return RecordingInformation(
        recording.name, recording.duration / 60.0, first.information, first.gradient,
        here.theta[free], np.where(known, np.sqrt(excess * np.diag(inverse)), np.inf),
    )  # fmt: skip


def _better(
    here: FilterRuns, move: Array, point: ReferencePoint, weak_prior: Array
) -> FilterRuns | None:
    """The filter run after a step, or part of it; None where none gains."""
    problem, free = here.problem, list(here.problem.free)

    def cost(runs: FilterRuns) -> float:
        off = runs.theta[free] - point.theta
        return runs.cost + float(off @ weak_prior @ off)

    for part in (1.0, 0.3, 0.05):  # of the step
        theta = here.theta.copy()
        theta[free] += part * np.clip(move, -problem.step_limits, problem.step_limits)
        found = filter_along(problem, problem.clipped(theta), point.noise, repeatable=False)
        if cost(found) < cost(here) - SCORING_CONVERGED:
            return found
    return None


def _sizes(point: ReferencePoint) -> Array:
    """Widths (p,) of the weak prior: a parameter's own size, or the typical one of such a constant."""
    typical = [typical_size(name) for name in point.names]
    return np.maximum(np.maximum(np.abs(point.theta), typical), 1e-3)


def _problem(model: Model, recordings: Sequence[Recording]) -> Problem:
    estimated = tuple(int(i) for i in np.flatnonzero(np.diag(model.covariance) > 0))
    outlier = float(model.estimator.settings.get("outlier") or OUTLIER)
    block = float(model.estimator.settings.get("block") or BLOCK)
    step = model.integration.step
    errors = tuple(input_errors(model.vehicle, model.coefficients, r) for r in recordings)
    return Problem(
        model.vehicle, tuple(recordings), estimated, step, outlier, block,
        input_errors=errors, earth_fixed=earth_fixed(model.noise),
    )  # fmt: skip


def _values(model: Model, problem: Problem) -> Array:
    """All parameters (names,) in the problem's order; effects of a recording are 0."""
    theta = np.zeros(len(problem.names))
    theta[: len(model.parameters)] = np.concatenate([model.coefficients, model.constants])
    return theta


def _excess(information: Array, scores: Array) -> float:
    """Ratio of the scatter of the scores (blocks, p) to the information; at least 1."""
    inverse, known = pseudo_inverse(information)
    sums = scores - scores.mean(axis=0)
    rank = max(1, int(known.sum()))
    return max(1.0, float(np.trace(inverse @ (sums.T @ sums))) / rank)
