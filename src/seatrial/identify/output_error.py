# SPDX-License-Identifier: MIT
"""Prediction-error estimation of boat and thrusters together, on the raw poses.

An extended Kalman filter, driven by the model, predicts every pose from those before it; what is
maximised is the likelihood of its errors, over coefficients, constants of the actuator chain, and
the noise of poses and process alike (Ljung, System Identification, 2nd ed., section 7.4). Without
process noise this is the simulation error of whole recordings, with much of it every pose is a new
start: the data say how long the model is to be believed. Pose noise is modelled, so that it does
not bias the coefficients as it does the paper's.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from seatrial import _core
from seatrial.errors import IdentificationError
from seatrial.frames import Array
from seatrial.identify.equation_error import equation_error
from seatrial.model import Model, thrust_trace
from seatrial.recording import Recording
from seatrial.schema import (
    ChainGroup,
    DeadZone,
    EstimatorEntry,
    Integration,
    NoiseEntry,
    ProcessEntry,
)
from seatrial.structure import Row
from seatrial.vehicle import STAGES, Vehicle
from seatrial.velocity import motion

METHOD = "output-error"
T = TypeVar("T")

BOUNDS = {  # of the constants that are estimated
    "latency": (-1.0, 2.0),  # [s]
    "lag": (0.002, 3.0),  # [s]
    "edge_forward": (0.0, 0.6),
    "edge_reverse": (0.0, 0.6),
}
START = {"latency": 0.0, "lag": 0.05, "edge": 0.05}
# position [m], heading [rad], walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory [s]
NOISE_START = np.array([2e-3, 4e-3, 5e-3, 2e-2, 3e-3, 1e-2, 2.0])
NOISE_LEAST = np.array([1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 0.3])
NOISE_MOST = np.array([1.0, 1.0, 1.0, 5.0, 1.0, 5.0, 30.0])
VELOCITY_SPREAD = np.array([0.1, 0.1, 0.2])  # [m/s, m/s, rad/s] what the first velocity is worth
BOTH_SIDES = 0.05  # share of its commands that a thruster must have on either side for a dead zone
SETTLED = 0.05  # a step that gains less of the cost is the last
NOISE_SETTLED = 0.3


@dataclass(frozen=True)
class OutputErrorSettings:
    """Choices of the estimator."""

    outlier: float = 4.0  # [sigma] from which on a pose's error counts linearly
    block: float = 10.0  # [s] over which scores may hang together, for the standard errors
    step: float = 1 / 60  # [s] of the integration
    iterations: int = 40


@dataclass(frozen=True)
class Problem:
    """What does not change during the search."""

    vehicle: Vehicle
    recordings: tuple[Recording, ...]
    free: tuple[int, ...]  # parameters that are sought: coefficients, then constants
    settings: OutputErrorSettings

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Coefficients, then constants of the chain."""
        return (*self.vehicle.structure.coefficients, *self.vehicle.constants.names)

    @cached_property
    def size(self) -> int:
        """Number of coefficients."""
        return len(self.vehicle.structure.coefficients)

    @cached_property
    def structure(self) -> _core.Structure:
        """The structure with a disturbance in every axis, its last three coefficients."""
        rows = self.vehicle.structure.rows
        own: list[Row] = [(axis, self.size + axis, 1.0, -1, []) for axis in range(3)]
        return _core.Structure([*rows, *own], self.size + 3, len(self.vehicle.forces))

    @cached_property
    def series(self) -> list[_core.Series]:
        """The poses, and where each recording starts."""
        return [_series(recording) for recording in self.recordings]

    def bounded(self, theta: Array) -> Array:
        """The nearest parameters within bounds."""
        out = theta.copy()
        for i in self.free:
            low, high = BOUNDS.get(self.names[i].partition(".")[0], (-np.inf, np.inf))
            out[i] = np.clip(out[i], low, high) if i >= self.size else out[i]
        return out

    def passes(self, theta: Array, noise: Array) -> "Passes":
        """The filter over all recordings."""
        coefficients = np.concatenate([theta[: self.size], np.zeros(3)])
        boat = _core.Boat(self.structure, coefficients, 0, self.settings.step)
        chosen = [i for i in self.free if i < self.size]
        chosen += [self.size, self.size + 1, self.size + 2]
        tangents = [i - self.size for i in self.free if i >= self.size]

        def one(item: tuple[Recording, _core.Series]) -> _core.FilterPass:
            trace = thrust_trace(
                self.vehicle, np.ascontiguousarray(theta[self.size :]), item[0],
                initial=True, coefficients=chosen, tangents=tangents,
            )  # fmt: skip
            return _core.innovations(boat, trace, item[1], noise, self.settings.outlier)

        return Passes(tuple(spread(one, list(zip(self.recordings, self.series, strict=True)))))


@dataclass(frozen=True)
class Passes:
    """The filter's passes over all recordings."""

    each: tuple[_core.FilterPass, ...]

    @property
    def cost(self) -> float:
        """-2 log likelihood, but for a constant; infinite where the boat diverged."""
        return sum(p.cost for p in self.each) if all(p.good for p in self.each) else np.inf

    @property
    def information(self) -> Array:
        """Fisher's (p, p)."""
        return np.asarray(sum(p.information for p in self.each))

    @property
    def gradient(self) -> Array:
        """Of the log likelihood (p,)."""
        return np.asarray(sum(p.gradient for p in self.each))


def output_error(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    roles: Mapping[str, Sequence[str]] | None = None,
    settings: OutputErrorSettings | None = None,
) -> Model:
    """Coefficients and the constants of the chain that the vehicle file does not state.

    Latency and lag are found, and the dead zone where thrusters are driven to both sides. Raises
    IdentificationError where the search does not get anywhere.
    """
    chosen = settings or OutputErrorSettings()
    whole = with_free_stages(vehicle, recordings)
    start = equation_error(recordings, whole, roles=roles)
    n = len(whole.structure.coefficients)
    known = set(vehicle.constants.names)
    free = [*range(n), *(n + i for i, c in enumerate(whole.constants.names) if c not in known)]
    problem = Problem(whole, tuple(recordings), tuple(free), chosen)
    theta, noise, passes = _search(
        problem, np.concatenate([start.coefficients, whole.constants.values])
    )
    covariance = _covariance(problem, passes)
    return _model(problem, start, theta, noise, covariance)


def with_free_stages(vehicle: Vehicle, recordings: Sequence[Recording]) -> Vehicle:
    """The vehicle with those stages of the chain that its file does not state."""
    given = vehicle.constants.index >= 0
    has = {stage: bool(given[:, STAGES.index(stage)].any()) for stage in STAGES}
    curved = any(g.table or g.power or g.dead_zone for g in vehicle.file.chain)
    edges = not curved and _both_sides(vehicle, recordings)
    group = ChainGroup(
        latency=None if has["latency"] else START["latency"],
        lag=None if has["lag"] else START["lag"],
        dead_zone=DeadZone(START["edge"], START["edge"]) if edges else None,
    )
    return vehicle.with_chain([*vehicle.file.chain, group])


def spread(work: Callable[[T], "_core.FilterPass"], items: list[T]) -> list["_core.FilterPass"]:
    """Work on items in threads; the core lets the interpreter go."""
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return list(pool.map(work, items))


def _both_sides(vehicle: Vehicle, recordings: Sequence[Recording]) -> bool:
    """Whether every thruster is driven forward and in reverse, so that its dead zone is passed."""
    if not (vehicle.file.thrusters or vehicle.file.forces):
        return False  # F itself has none
    commands = np.concatenate([r.commands.values for r in recordings])
    thrust = _core.allocate(vehicle.chain, np.ascontiguousarray(commands))[0]
    return bool(min((thrust > 0).mean(axis=0).min(), (thrust < 0).mean(axis=0).min()) > BOTH_SIDES)


def _series(recording: Recording) -> _core.Series:
    moving = motion(recording)
    use = recording.valid.astype(np.int8)
    jumped = np.diff(recording.segment, prepend=recording.segment[0]) > 0
    near = np.diff(recording.t, prepend=-1.0) < 1.5 * recording.period
    use[recording.valid & jumped & near] = 2  # after a jump for good the pose may be anywhere
    first = int(np.flatnonzero(recording.valid)[0])
    start = np.zeros(6)
    start[:3] = recording.eta[first]
    if moving.valid.any():
        start[3:] = moving.nu[np.flatnonzero(moving.valid)[0]]
    eta = np.where(recording.valid[:, None], recording.eta, 0.0)
    return _core.Series(
        np.ascontiguousarray(recording.t), np.ascontiguousarray(eta), use, start, VELOCITY_SPREAD
    )


def _search(problem: Problem, theta: Array) -> tuple[Array, Array, Passes]:
    """Levenberg and Marquardt on the parameters, Fisher's scoring on the noise, in turns."""
    noise, damping = NOISE_START, 1e-4
    passes = problem.passes(theta, noise)
    if not np.isfinite(passes.cost):
        raise IdentificationError(
            "the boat diverges from the start values; look at the recordings with inspect"
        )
    noise, _ = _fitted_noise(problem, passes, noise)
    passes = problem.passes(theta, noise)
    for _ in range(problem.settings.iterations):
        theta, passes, damping, gained = _step(problem, theta, noise, passes, damping)
        better, cost = _fitted_noise(problem, passes, noise)
        if passes.cost - cost > NOISE_SETTLED:
            noise, passes = better, problem.passes(theta, better)
        elif gained < SETTLED:
            return theta, noise, passes
    raise IdentificationError(
        f"no solution after {problem.settings.iterations} steps; drive more, or state what is known of "
        "the thrusters in the vehicle file (chain)"
    )


def _step(
    problem: Problem, theta: Array, noise: Array, passes: Passes, damping: float
) -> tuple[Array, Passes, float, float]:
    """One step downhill; gained: by how much the cost fell."""
    free = list(problem.free)
    information, gradient = passes.information, passes.gradient
    scale = np.sqrt(np.diag(information)) + 1e-12
    for _ in range(8):
        matrix = information / np.outer(scale, scale) + damping * np.eye(len(free))
        trial = theta.copy()
        trial[free] += np.linalg.solve(matrix, gradient / scale) / scale
        trial = problem.bounded(trial)
        found = problem.passes(trial, noise)
        if found.cost < passes.cost:
            return trial, found, damping / 10.0, passes.cost - found.cost
        damping = max(10.0 * damping, 1e-3)
    return theta, passes, damping, 0.0


def _fitted_noise(problem: Problem, passes: Passes, noise: Array) -> tuple[Array, float]:
    """The noise under which the errors are most likely, with the model as it is; and the cost."""
    outlier, damping = problem.settings.outlier, 1e-3
    pairs = list(zip(passes.each, problem.series, strict=True))
    phi, cost = np.log(noise), passes.cost
    for _ in range(6):
        parts = [_core.noise_slopes(p, s, np.exp(phi), outlier) for p, s in pairs]
        cost = sum(p[0] for p in parts)
        gradient, information = sum(p[1] for p in parts), sum(p[2] for p in parts)
        gain = 0.0
        for _ in range(8):
            matrix = information + np.diag(damping * np.diag(information) + 0.3)
            trial = phi - np.clip(np.linalg.solve(matrix, gradient), -2.5, 2.5)
            trial = np.clip(trial, np.log(NOISE_LEAST), np.log(NOISE_MOST))
            found = sum(_core.repeated(p, s, np.exp(trial), outlier) for p, s in pairs)
            if found < cost:
                phi, gain, cost, damping = trial, cost - found, found, damping / 10.0
                break
            damping = max(10.0 * damping, 1e-2)
        if gain < NOISE_SETTLED / 3:
            break
    return np.exp(phi), float(cost)


def _covariance(problem: Problem, passes: Passes) -> Array:
    """Sandwich of the information and of the scores summed over blocks: errors may hang together."""
    sums = []
    for recording, each in zip(problem.recordings, passes.each, strict=True):
        block = (recording.t // problem.settings.block).astype(np.int64)
        starts = np.flatnonzero(np.diff(block, prepend=-1))
        sums.append(np.add.reduceat(each.score, starts, axis=0))
    scores = np.concatenate(sums)
    p, blocks = len(problem.free), len(scores)
    if blocks < 2 * p:
        raise IdentificationError(
            f"{blocks} blocks of {problem.settings.block:g} s for {p} parameters; record longer"
        )
    inverse = np.linalg.pinv(passes.information, hermitian=True)
    return np.asarray(inverse @ (scores.T @ scores) @ inverse * blocks / (blocks - p))


def _model(problem: Problem, start: Model, theta: Array, noise: Array, covariance: Array) -> Model:
    n = problem.size
    whole = np.zeros((len(theta), len(theta)))
    whole[np.ix_(problem.free, problem.free)] = covariance
    settings: dict[str, str | float | int | bool | None] = {
        "outlier": problem.settings.outlier, "block": problem.settings.block,
    }  # fmt: skip
    position, heading, *process = noise.tolist()
    return replace(
        start,
        coefficients=theta[:n], covariance=whole, constants=theta[n:],
        integration=Integration("runge-kutta", problem.settings.step),
        noise=NoiseEntry(position, heading, ProcessEntry(*process)),
        estimator=EstimatorEntry(METHOD, settings),
    )  # fmt: skip
