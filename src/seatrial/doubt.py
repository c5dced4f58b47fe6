# SPDX-License-Identifier: MIT
"""The noise that the on-board filter believes: the model's own, and what its errors amount to.

A model identified without a disturbance is still not known exactly. Its coefficients' errors are
constant, but what they do changes as the boat is driven: like a disturbance with some memory.
"""

import numpy as np

from seatrial import _core
from seatrial.causal import NOISE_START
from seatrial.frames import SYMBOLS, Array
from seatrial.model import Model

# position [m], heading [rad], walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory
# [s]: less is not believed, so that the covariance keeps its digits
FLOOR = np.array([1e-4, 1e-4, 1e-6, 1e-6, 1e-5, 1e-5, 0.3])
MEMORY = 2.0  # [s] of what the coefficients' errors do: a stretch of driving in one way
SAMPLES = 200  # speeds and commands that it is averaged over
PERCENTILE = 2.576  # standard deviations of a normal variable's 0.5th and 99.5th percentile
STEP = 0.1  # of a standard error, for a derivative


def believed_on_board(model: Model) -> Array:
    """Noise (7,) of poses and motion: position, heading, walks, disturbances, memory.

    A model without process noise (the paper's method finds none) gets what the estimator starts
    from. To the disturbance comes `coefficient_doubt`, in squares; its memory is in proportion.
    """
    own, noise = model.noise, NOISE_START.copy()
    noise[:2] = own.position, own.heading
    if own.process is not None:
        p = own.process
        noise[2:6] = p.walk_linear, p.walk_yaw, p.disturbance_linear, p.disturbance_yaw
        noise[6] = p.memory
    surge, sway, yaw = coefficient_doubt(model)
    doubt = np.array([np.hypot(surge, sway) / np.sqrt(2.0), yaw])
    both = np.hypot(noise[4:6], doubt)
    if both.all():
        share = float(np.mean((doubt / both) ** 2))
        noise[6] = (1.0 - share) * noise[6] + share * MEMORY
    noise[4:6] = both
    return np.asarray(np.maximum(noise, FLOOR))


def coefficient_doubt(model: Model) -> Array:
    """Standard deviations (3,) of acceleration [m/s^2, m/s^2, rad/s^2] by the model's covariance.

    The mean square over speeds and commands that are normal with the envelope's percentiles. The
    errors of latency and lag are not in it: they matter for moments only.
    """
    speeds = model.envelope.speeds
    errors = np.sqrt(np.diag(model.covariance))
    if not errors.any() or not set(SYMBOLS) <= set(speeds):
        return np.zeros(3)
    rng = np.random.default_rng(0)
    low, high = np.array([speeds[s] for s in SYMBOLS]).T
    spread = (high - low) / (2.0 * PERCENTILE)
    nu = 0.5 * (low + high) + spread * rng.normal(size=(SAMPLES, 3))
    width = len(model.vehicle.inputs)
    command = np.clip(rng.normal(size=(SAMPLES, width)) / PERCENTILE, -1.0, 1.0)
    slopes = np.zeros((len(errors), SAMPLES, 3))
    theta = np.concatenate([model.coefficients, model.constants])
    for i in np.flatnonzero(errors):
        step = np.zeros(len(theta))
        step[i] = STEP * errors[i]
        ahead, back = (_acceleration(model, x, nu, command) for x in (theta + step, theta - step))
        slopes[i] = (ahead - back) / (2.0 * step[i])
    square = np.einsum("ink,ij,jnk->nk", slopes, model.covariance, slopes)
    return np.asarray(np.sqrt(np.maximum(square.mean(axis=0), 0.0)))


def _acceleration(model: Model, theta: Array, nu: Array, command: Array) -> Array:
    """Accelerations (n, 3) at settled thrusters, for coefficients and constants theta."""
    vehicle, size = model.vehicle, len(model.coefficients)
    thrusters, _ = _core.allocate(vehicle.chain, np.ascontiguousarray(command))
    constants = np.ascontiguousarray(theta[size:])
    curves = [
        _core.curve(vehicle.chain, constants, k, thrusters) for k in range(thrusters.shape[1])
    ]
    force = np.ascontiguousarray(np.column_stack(curves) @ vehicle.mix.T)
    coefficients = np.ascontiguousarray(theta[:size])
    return np.asarray(
        _core.accelerations(model.structure.compiled, coefficients, np.ascontiguousarray(nu), force)
    )
