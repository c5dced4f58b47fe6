# SPDX-License-Identifier: MIT
"""Likelihood of a window of poses, to second order in the boat's parameters."""

from dataclasses import dataclass, replace

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
from seatrial.identification.likelihood.problem import Problem
from seatrial.recording.recording import Recording
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array

# what moves a boat and is no change of it, with standard deviations
CURRENT = 0.3  # [m/s]
WIND = 0.3  # of full thrust
GUSTS = (0.0, 0.06, 0.2)  # of full thrust: disturbance force beside the model's process noise
GUST_MEMORY = 2.0  # [s] of it, where the model has no process noise
SHORTEST_BLOCK = 1.0  # [s]


@dataclass(frozen=True)
class Quadratic:
    """log L about `at` (n,): value + gradient' d - d' information d / 2."""

    at: Array
    value: float
    gradient: Array
    information: Array


@dataclass(frozen=True)
class Window:
    """A window of a recording, with the noise that may have been in it."""

    recording: Recording
    noise: Array  # (11,)
    earth_fixed: bool

    def quadratic(self, boat: Model, theta: Array) -> Quadratic | None:
        """About parameters theta of a boat; wind and current integrated out. None: it diverges."""
        problem = Problem(
            boat.vehicle, (self.recording,), tuple(range(len(theta))), boat.integration.step, OUTLIER,
            SHORTEST_BLOCK, earth_fixed=self.earth_fixed,
        )  # fmt: skip
        deviation = _nuisances(boat)
        nuisance = [
            int(i) for i in problem.effects(0) if problem.names[i].partition(".")[0] in deviation
        ]
        problem = replace(problem, free=(*problem.free, *nuisance))
        whole = np.zeros(len(problem.names))
        whole[: len(theta)] = theta
        runs = problem.run_filter(whole, self.noise, repeatable=False)
        if not np.isfinite(runs.cost):
            return None
        # the nuisances have a prior of mean 0; they are integrated out
        prior = [deviation[problem.names[i].partition(".")[0]] ** -2.0 for i in nuisance]
        k = len(theta)
        own, across = runs.information[:k, :k], runs.information[:k, k:]
        other = runs.information[k:, k:] + np.diag(prior)
        gain = np.linalg.solve(other, across.T).T
        rest = runs.gradient[k:]
        value = -0.5 * runs.cost + 0.5 * rest @ np.linalg.solve(other, rest)
        value -= 0.5 * (np.linalg.slogdet(other)[1] - np.sum(np.log(prior)))
        return Quadratic(
            theta, float(value), runs.gradient[:k] - gain @ rest, own - gain @ across.T
        )


def _nuisances(boat: Model) -> dict[str, float]:
    """Standard deviations of wind [m/s^2] and current [m/s]."""
    wind = WIND * max(full_thrust(boat, 0), full_thrust(boat, 1))
    return {"wind_x": wind, "wind_y": wind, "current_x": CURRENT, "current_y": CURRENT}


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


def windows(model: Model, recording: Recording) -> list[Window]:
    """The window with the model's noise, with gusts beside it, and calm. Raises ModelError as `noise_of`."""
    own = noise_of(model)
    linear, yaw = max(full_thrust(model, 0), full_thrust(model, 1)), full_thrust(model, 2)
    found = []
    for share in GUSTS:
        noise = own.copy()
        if share and np.all(own[DISTURBANCES] <= NOISE_LEAST[DISTURBANCES]):
            noise[MEMORY] = GUST_MEMORY
        noise[DISTURBANCES] = np.hypot(own[DISTURBANCES], share * np.array([linear, yaw]))
        found.append(Window(recording, noise, earth_fixed(model.noise)))
    if np.any(own[DISTURBANCES] > NOISE_LEAST[DISTURBANCES]):
        # at a quay, or in calm water, nothing moves a boat that is identified in gusts
        noise = own.copy()
        noise[DISTURBANCES] = NOISE_LEAST[DISTURBANCES]
        found.append(Window(recording, noise, earth_fixed(model.noise)))
    return found
