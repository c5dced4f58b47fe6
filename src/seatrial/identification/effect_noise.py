# SPDX-License-Identifier: MIT
"""Estimated effects of recordings as process noise: on board the next wind, trim or current is not known."""

from collections.abc import Mapping, Sequence

import numpy as np

from seatrial import _core
from seatrial.boat.noise_parameters import DISTURBANCES, MEMORY, NOISE_MOST
from seatrial.boat.vehicle import Vehicle
from seatrial.util.frames import Array


def with_effects_as_noise(
    noise: Array, effects: Sequence[Mapping[str, float]], vehicle: Vehicle, coefficients: Array
) -> tuple[Array, bool | None]:
    """The noise (11,) with the mean square of all recordings' effects as a slow disturbance force.

    effects: of each recording, by name, in SI. The estimator knows them; a filter on board estimates them as its
    disturbance. A current acts by the drag that it makes. Also whether the disturbance is then earth-fixed; None:
    as before. Variances add, memories are weighted by them.
    """
    if not any(effects):
        return noise, None
    found = np.mean([_variances(own, vehicle, coefficients) for own in effects], axis=0)
    linear, yaw, earth = found.tolist()
    out = noise.copy()
    before = noise[DISTURBANCES] ** 2
    after = before + np.array([linear, yaw])
    share = (linear + yaw) / max(float(after.sum()), np.finfo(float).tiny)
    out[DISTURBANCES] = np.sqrt(after)
    out[MEMORY] = (1.0 - share) * noise[MEMORY] + share * NOISE_MOST[MEMORY]
    return out, True if earth > 0.5 * float(after[0]) else None


def _variances(
    own: Mapping[str, float], vehicle: Vehicle, coefficients: Array
) -> tuple[float, float, float]:
    """Mean squares: linear, of an axis [(m/s^2)^2]; yaw [(rad/s^2)^2]; earth-fixed part of the first."""
    wind = np.hypot(own.get("wind_x", 0.0), own.get("wind_y", 0.0))
    trim = np.hypot(own.get("trim_u", 0.0), own.get("trim_v", 0.0))
    speed = float(np.hypot(own.get("current_x", 0.0), own.get("current_y", 0.0)))
    earth = 0.5 * float(wind) ** 2
    if speed > 0.0:  # a boat that rests over ground: its drag in the two axes, of any heading
        nu = np.array([[-speed, 0.0, 0.0], [0.0, -speed, 0.0]])
        still = np.zeros((2, len(vehicle.forces)))
        pushed = _core.accelerations(vehicle.structure.compiled, coefficients, nu, still)
        earth += 0.25 * float(pushed[0, 0] ** 2 + pushed[1, 1] ** 2)
    return earth + 0.5 * float(trim) ** 2, own.get("trim_r", 0.0) ** 2, earth
