# SPDX-License-Identifier: MIT
"""Likelihood of a window of poses, to second order in the boat's parameters.

Wind and current move a boat and are no change of it. They are constant within a window, with a normal prior, and
integrated out. Gusts are not constant: the likelihood is taken with each of several disturbance forces (`noises`).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from seatrial.boat.findings import FindingKind
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import (
    DISTURBANCES,
    MEMORY,
    NOISE_LEAST,
    OUTLIER,
    earth_fixed,
    noise_vector,
)
from seatrial.evaluation.comparison.cause_candidates import full_thrust
from seatrial.identification.likelihood.problem import FilterRuns, Problem
from seatrial.recording.recording import Recording
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array

CURRENT = 0.3  # [m/s] standard deviation
WIND = 0.3  # of full thrust, standard deviation
GUSTS = (0.0, 0.06, 0.2)  # of full thrust: disturbance force beside the model's process noise
GUST_MEMORY = 2.0  # [s] of it, where the model has no process noise
NUISANCES = ("wind_x", "wind_y", "current_x", "current_y")  # effects that are no change of the boat
SHORTEST_BLOCK = 1.0  # [s]
LEAST_INFORMATION = 1e-12  # of the largest: less is round-off


@dataclass(frozen=True)
class Quadratic:
    """log L about `at` (n,): value + gradient' d - d' information d / 2, d = theta - at."""

    at: Array
    value: float
    gradient: Array  # (n,)
    information: Array  # (n, n)

    @cached_property
    def whitened(self) -> tuple[Array, Array]:
        """R (m, n) and c (m,): log L = value + |c|^2 / 2 - |R d - c|^2 / 2."""
        values, vectors = np.linalg.eigh(0.5 * (self.information + self.information.T))
        kept = values > LEAST_INFORMATION * values.max(initial=0.0)
        root = (vectors[:, kept] * np.sqrt(values[kept])).T
        return root, (vectors[:, kept].T @ self.gradient) / np.sqrt(values[kept])


@dataclass(frozen=True)
class Sums:
    """A filter's sums over the poses of a window, of n parameters and m nuisances."""

    cost: float  # -2 log likelihood
    gradient: Array  # (n + m,) of the log likelihood
    information: Array  # (n + m, n + m)

    @classmethod
    def of(cls, runs: FilterRuns) -> "Sums":
        """Of all poses of a run; the cost is infinite where the boat diverges."""
        return cls(runs.cost, runs.gradient, runs.information)

    def since(self, earlier: "Sums") -> "Sums":
        """Of the poses after those of `earlier`."""
        return Sums(
            self.cost - earlier.cost,
            self.gradient - earlier.gradient,
            self.information - earlier.information,
        )

    def marginal(self, at: Array, deviations: Array) -> Quadratic:
        """The nuisances, of mean 0 and these standard deviations (m,), integrated out."""
        k, precision = len(at), deviations**-2.0
        own, across = self.information[:k, :k], self.information[:k, k:]
        other, rest = self.information[k:, k:] + np.diag(precision), self.gradient[k:]
        gain = np.linalg.solve(other, across.T).T
        value = 0.5 * rest @ np.linalg.solve(other, rest) - 0.5 * self.cost
        value -= 0.5 * (np.linalg.slogdet(other)[1] - np.sum(np.log(precision)))
        return Quadratic(at, float(value), self.gradient[:k] - gain @ rest, own - gain @ across.T)


@dataclass(frozen=True)
class Window:
    """A window of a recording, with the noise that may have been in it."""

    recording: Recording
    noise: Array  # (11,)
    earth_fixed: bool  # of the disturbance force

    def problem(self, boat: Model) -> Problem:
        """The filter's problem with all parameters of the boat free, then wind and current."""
        n = len(boat.coefficients) + len(boat.constants)
        problem = Problem(
            boat.vehicle, (self.recording,), tuple(range(n)), boat.integration.step, OUTLIER,
            SHORTEST_BLOCK, earth_fixed=self.earth_fixed,
        )  # fmt: skip
        nuisances = [int(i) for i in problem.effects(0) if _kind(problem, int(i)) in NUISANCES]
        return replace(problem, free=(*problem.free, *nuisances))

    def quadratic(self, boat: Model, theta: Array) -> Quadratic | None:
        """About parameters theta (n,) of a boat; wind and current integrated out. None: it diverges."""
        problem = self.problem(boat)
        runs = problem.run_filter(without_nuisances(problem, theta), self.noise, repeatable=False)
        if not np.isfinite(runs.cost):
            return None
        return Sums.of(runs).marginal(theta, nuisance_deviations(problem, boat))


def _kind(problem: Problem, parameter: int) -> str:
    """The name of an effect, whatever the recording."""
    return problem.names[parameter].partition(".")[0]


def without_nuisances(problem: Problem, theta: Array) -> Array:
    """All parameters of a problem from those (n,) of its boat; effects are 0."""
    whole = np.zeros(len(problem.names))
    whole[: len(theta)] = theta
    return whole


def nuisance_deviations(problem: Problem, boat: Model) -> Array:
    """Standard deviations (m,) of the nuisances of a problem: wind [m/s^2] and current [m/s]."""
    wind = WIND * max(full_thrust(boat, 0), full_thrust(boat, 1))
    kinds = [_kind(problem, i) for i in problem.free]
    found = [wind if kind.startswith("wind") else CURRENT for kind in kinds if kind in NUISANCES]
    return np.array(found)


def noise_of(model: Model) -> Array:
    """The model's noise (11,). Raises ModelError where none was estimated, or the innovations are not white."""
    if model.findings_of(FindingKind.MODEL_MISMATCH):
        raise ModelError(
            f"{model.name}: innovations are correlated (model mismatch), so a change of the boat can't be told "
            "from terms that the model lacks; look for them with 'seatrial select'"
        )
    own = noise_vector(model.noise)
    if own is None:
        raise ModelError(
            f"{model.name}: no noise was estimated, so no change can be told from it; identify by output-error"
        )
    return own


def noises(model: Model) -> list[Array]:
    """The model's noise (11,), the same with gusts beside it, and calm. Raises ModelError as `noise_of`."""
    own = noise_of(model)
    linear, yaw = max(full_thrust(model, 0), full_thrust(model, 1)), full_thrust(model, 2)
    disturbed = bool(np.any(own[DISTURBANCES] > NOISE_LEAST[DISTURBANCES]))
    found = []
    for share in GUSTS:
        noise = own.copy()
        if share and not disturbed:
            noise[MEMORY] = GUST_MEMORY
        noise[DISTURBANCES] = np.hypot(own[DISTURBANCES], share * np.array([linear, yaw]))
        found.append(noise)
    if disturbed:
        # at a quay, or in calm water, nothing moves a boat that is identified in gusts
        calm = own.copy()
        calm[DISTURBANCES] = NOISE_LEAST[DISTURBANCES]
        found.append(calm)
    return found


def windows(model: Model, recording: Recording) -> list[Window]:
    """The recording with each of the noises. Raises ModelError as `noise_of`."""
    earth = earth_fixed(model.noise)
    return [Window(recording, noise, earth) for noise in noises(model)]
