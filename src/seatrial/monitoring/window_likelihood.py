# SPDX-License-Identifier: MIT
"""Likelihood of a window of poses, to second order in the boat's parameters.

Wind and current move a boat and are no change of it. They are constant within a window, with a normal prior, and
integrated out. Gusts are not constant: the likelihood is taken with each of several disturbance forces (`noises`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from seatrial.boat.findings import FindingKind
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import (
    COLOUR,
    COLOUR_MEMORY,
    COLOUR_TURN,
    DISTURBANCES,
    MEMORY,
    NOISE_LEAST,
    OUTLIER,
    earth_fixed,
    equal_in_plane,
    noise_vector,
)
from seatrial.evaluation.comparison.cause_candidates import full_thrust
from seatrial.identification.likelihood.filter_runs import FilterRuns, filter_along
from seatrial.identification.likelihood.problem import Problem
from seatrial.recording.recording import Recording
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array

CURRENT = 0.3  # [m/s] standard deviation
WIND = 0.3  # of full thrust, standard deviation
GUSTS = (0.06, 0.2)  # of full thrust: disturbance force beside the model's process noise
GUST_MEMORY = 2.0  # [s] of it, where the model has no process noise
NUISANCES = ("wind_x", "wind_y", "current_x", "current_y")  # effects that are no change of the boat
SLOW_WIND, SLOW_MEMORY = 0.2, 20.0  # of full thrust, [s]: an earth-fixed disturbance force
WAVES = 0.5  # of full thrust, standard deviation of the acceleration
# [s] each by 1.4: a memory of one period covers those between; by 2 those of 1.5 s gave a false notice.
# With these periods waves of 0.7 to 5 s gave none on other seeds; those of 8 s and 0.14 m did
WAVE_PERIODS = (1.0, 1.4, 2.0, 2.8, 4.0)
SHORTEST_BLOCK = 1.0  # [s]
LEAST_INFORMATION = 1e-12  # of the largest: less is round-off
LEAST_DIRECTION = 1e-6  # of the largest, in standard errors: less shows nothing of scatter
LEAST_SIZE = 1e-300  # against a division by 0


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

    @property
    def most(self) -> float:
        """The largest log L, of any theta."""
        return self.value + 0.5 * float(np.sum(self.whitened[1] ** 2))

    def over(self, dispersion: float) -> "Quadratic":
        """The likelihood to the power 1 / dispersion: of scores that scatter as much more than stated."""
        return Quadratic(
            self.at,
            self.value / dispersion,
            self.gradient / dispersion,
            self.information / dispersion,
        )


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


def dispersion(blocks: Sequence[Sums]) -> float:
    """Scatter of the scores of blocks of poses over that of independent innovations, 1 at least.

    About the maximum of the likelihood over all blocks: a change of the boat is no scatter. With information
    H_b and score g_b of a block, H their sum: sum r_b' H^+ r_b over its expectation, r_b = g_b - H_b H^+ sum g.
    (McCullagh and Nelder, Generalized Linear Models, section 9.2: quasi-likelihood.)
    """
    whole = sum(block.information for block in blocks)
    size = np.sqrt(np.maximum(np.diag(whole), LEAST_SIZE))
    values, vectors = np.linalg.eigh(whole / np.outer(size, size))
    kept = values > LEAST_DIRECTION * values.max(initial=0.0)
    root = (vectors[:, kept] / np.sqrt(values[kept])).T / size  # root' root = H^+
    scores = np.array([root @ block.gradient for block in blocks])
    shares = np.array([root @ block.information @ root.T for block in blocks])
    left = scores - shares @ scores.sum(axis=0)
    degrees = float(kept.sum() - np.sum(shares**2))
    return max(1.0, float(np.sum(left**2)) / degrees) if degrees > 1.0 else 1.0


@dataclass(frozen=True)
class Window:
    """A window of a recording, with the noise that may have been in it."""

    recording: Recording
    noise: Array  # (12,)
    earth_fixed: bool  # of the disturbance force
    dispersion: float = 1.0  # of its scores

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
        runs = filter_along(
            problem, without_nuisances(problem, theta), self.noise, repeatable=False
        )
        if not np.isfinite(runs.cost):
            return None
        found = Sums.of(runs).marginal(theta, nuisance_deviations(problem, boat))
        return found.over(self.dispersion)


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
    """The model's noise (12,). Raises ModelError where none was estimated, or the innovations are not white."""
    if model.findings_of(FindingKind.MODEL_MISMATCH):
        raise ModelError(
            f"{model.name}: innovations are correlated (model mismatch). Terms that the model lacks look like a "
            "change of the boat, so there is no test for one; look for them with 'seatrial select'"
        )
    own = noise_vector(model.noise)
    if own is None:
        raise ModelError(
            f"{model.name}: no noise was estimated, so no change can be told from it; identify by output-error"
        )
    return own


def noises(model: Model) -> list[tuple[Array, bool]]:
    """Noises (12,) that may be in a window, and whether their disturbance force is earth-fixed.

    The model's, with gusts, waves, both, or slow wind beside it, and calm. Raises ModelError as `noise_of`.
    """
    own, earth = noise_of(model), earth_fixed(model.noise)
    thrust = np.array([max(full_thrust(model, 0), full_thrust(model, 1)), full_thrust(model, 2)])
    disturbed = bool(np.any(own[DISTURBANCES] > NOISE_LEAST[DISTURBANCES]))
    memory = own[MEMORY] if disturbed else GUST_MEMORY
    some, strong = (
        _with_disturbance(own, np.hypot(own[DISTURBANCES], share * thrust), memory)
        for share in GUSTS
    )
    waves = [
        _with_waves(noise, WAVES * thrust, period)
        for period in WAVE_PERIODS
        for noise in (own, strong)
    ]
    found = [(noise, earth) for noise in (own, some, strong, *waves)]
    slow = _with_disturbance(own, SLOW_WIND * thrust, SLOW_MEMORY)
    found.append((equal_in_plane(slow), True))
    if disturbed:
        # at a quay, or in calm water, nothing moves a boat that is identified in gusts
        found.append((_with_disturbance(own, NOISE_LEAST[DISTURBANCES], memory), earth))
    return found


def _with_disturbance(noise: Array, sizes: Array, memory: float) -> Array:
    """The noise (12,) with a disturbance of these sizes (2,) [m/s^2, rad/s^2] and memory [s]."""
    out = noise.copy()
    out[DISTURBANCES], out[MEMORY] = sizes, memory
    return out


def _with_waves(noise: Array, accelerations: Array, period: float) -> Array:
    """The noise (12,) with wave-frequency motion of accelerations (2,) [m/s^2, rad/s^2].

    It adds to the motion of the boat (Fossen, Handbook of Marine Craft, 2nd ed., section 8.1), as an oscillating
    error of the poses. It takes the place of correlated noise, which counts as white.
    """
    out, turn = noise.copy(), 2.0 * np.pi / period
    out[:2] = np.hypot(noise[:2], noise[COLOUR])
    out[COLOUR], out[COLOUR_MEMORY], out[COLOUR_TURN] = accelerations / turn**2, period, turn
    return out


def windows(model: Model, recording: Recording, dispersion: float = 1.0) -> list[Window]:
    """The recording with each of the noises. Raises ModelError as `noise_of`."""
    return [Window(recording, noise, earth, dispersion) for noise, earth in noises(model)]
