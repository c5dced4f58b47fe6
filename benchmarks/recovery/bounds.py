# SPDX-License-Identifier: MIT
"""Cramer-Rao bounds: the inverse of the information at the true parameters and the true noise."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import thrust_trace
from seatrial.boat.noise_parameters import NOISE_LEAST, SWAY_RATIO
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.estimator import OutputErrorSettings
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.problem import Problem
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import PlanFile
from seatrial.simulation.trials import Trial
from seatrial.util.frames import Array

FREE_VELOCITY = np.full(3, 10.0)  # [m/s, m/s, rad/s] a start of which nothing is known


def problem_of(vehicle: Vehicle, recordings: Sequence[Recording]) -> Problem:
    """The estimator's problem with all parameters sought."""
    count = len(vehicle.structure.coefficients) + len(vehicle.constants.names)
    step = OutputErrorSettings().step
    return Problem(
        vehicle, tuple(recordings), tuple(range(count)), step, np.inf, OutputErrorSettings().block
    )


def without_process(noise: Array) -> Array:
    """The same with the process noise at its lower limit."""
    return np.concatenate([noise[:2], NOISE_LEAST[2:]])


def true_noise(plan: PlanFile) -> Array:
    """The filter's noise as the plan has it."""
    noise = np.array(NOISE_LEAST)
    noise[:2] = plan.pose.position_noise, plan.pose.heading_noise
    force, c = plan.plant.unmodelled, plan.plant.coefficients
    if force is not None:
        noise[4], noise[SWAY_RATIO] = force.share * c["X_F"], c["Y_F"] / c["X_F"]
        noise[5] = force.share * c["N_F"]
        noise[6] = force.correlation
    return noise


def whole(problem: Problem, theta: Array, noise: Array) -> Array:
    """Information (p, p) of whole recordings."""
    return filter_along(problem, theta, noise).information


def undisturbed(problem: Problem, theta: Array, trials: Sequence[Trial]) -> Problem:
    """The same problem with the poses that the model itself takes under the same commands.

    A filter without process noise must be linearised about such a path.
    """
    n = problem.n_coefficients
    boat = _core.Boat(
        problem.vehicle.structure.compiled, np.ascontiguousarray(theta[:n]), 0, problem.step
    )
    moved = []
    for recording, trial in zip(problem.recordings, trials, strict=True):
        trace = thrust_trace(problem.vehicle, np.ascontiguousarray(theta[n:]), recording)
        states, _ = _core.simulate(boat, trace, trial.truth[0], recording.t)
        moved.append(replace(recording, eta=states[:, :3]))
    return replace(problem, recordings=tuple(moved))


def pieces(
    problem: Problem, theta: Array, noise: Array, trials: Sequence[Trial], length: float
) -> Array:
    """Information (p, p) of pieces of `length` [s] that each start anywhere at any speed."""
    n = problem.n_coefficients
    coefficients = np.concatenate([theta[:n], np.zeros(3)])
    boat = _core.Boat(problem.structure, coefficients, 0, problem.step)
    total = np.zeros((len(theta), len(theta)))
    for recording, trial in zip(problem.recordings, trials, strict=True):
        trace = thrust_trace(
            problem.vehicle, np.ascontiguousarray(theta[n:]), recording,
            initial=True, coefficients=range(n + 3), tangents=range(len(theta) - n),
        )  # fmt: skip
        for rows in _rows(recording, length):
            start = trial.truth[trial.arrived][rows[0]].copy()
            start[:3] = recording.eta[rows[0]]
            use = np.ones(len(rows), dtype=np.int8)
            use[0] = 2  # as after a jump: the pose may be anywhere
            series = _core.Series(
                np.ascontiguousarray(recording.t[rows]), np.ascontiguousarray(recording.eta[rows]),
                use, start, FREE_VELOCITY,
            )  # fmt: skip
            total += _core.innovations(boat, trace, series, noise, np.inf).information
    return total


def _rows(recording: Recording, length: float) -> list[NDArray[np.int64]]:
    """Numbers of the usable poses, piece by piece."""
    usable = np.flatnonzero(recording.valid)
    number = (recording.t[usable] // length).astype(np.int64)
    found = np.split(usable, np.flatnonzero(np.diff(number)) + 1)
    return [rows for rows in found if len(rows) > 2]


def inverse(information: Array) -> Array:
    """Covariance (p, p) of the bound; scaled, since parameters differ by orders of magnitude."""
    scale = np.sqrt(np.diag(information))
    scales = np.outer(scale, scale)
    return np.asarray(np.linalg.inv(information / scales) / scales)


def variances(information: Array) -> Array:
    """Its diagonal (p,)."""
    return np.diag(inverse(information))
