# SPDX-License-Identifier: MIT
"""The noise that the on-board filter believes: the model's own, and what its errors amount to.

A model identified without a disturbance is still not known exactly. Its coefficients' errors are
constant, but what they do changes as the boat is driven: like a disturbance with some memory. Errors
of latency and lag leave a kick behind at every change of a command: like a random walk.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.chain import STAGES
from seatrial.filter_noise import NOISE_START
from seatrial.frames import SYMBOLS, Array
from seatrial.model import Model

# position [m], heading [rad], walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory
# [s]: less is not believed, so that the covariance keeps its digits
FLOOR = np.array([1e-4, 1e-4, 1e-6, 1e-6, 1e-5, 1e-5, 0.3])
MEMORY = 2.0  # [s] of what the coefficients' errors do: a stretch of driving in one way
CHANGES = 1.0  # [1/s] of the commands, each to any other
SAMPLES = 200  # speeds and commands that it is averaged over
STEP = 0.1  # of a standard error, for a derivative
TIMES = ("latency", "lag")


def believed_on_board(model: Model) -> Array:
    """Noise (7,) of poses and motion: position, heading, walks, disturbances, memory.

    A model without process noise (the paper's method finds none) gets what the estimator starts
    from. Pose errors that hang together count as white ones of their size: the gate is right, what
    many poses tell is taken for more than it is. The doubt about the model's parameters is added
    in squares; the memory is in proportion.
    """
    own, noise = model.noise, NOISE_START[: len(FLOOR)].copy()
    noise[:2] = own.position, own.heading
    if own.correlated is not None:
        noise[:2] = np.hypot(noise[:2], [own.correlated.position, own.correlated.heading])
    if own.process is not None:
        p = own.process
        noise[2:6] = p.walk_linear, p.walk_yaw, p.disturbance_linear, p.disturbance_yaw
        noise[6] = p.memory
    if np.any(model.covariance) and set(SYMBOLS) <= set(model.envelope.speeds):
        doubt = Doubt(model)
        noise[2:4] = np.hypot(noise[2:4], _linear_and_yaw(doubt.walk))
        push = _linear_and_yaw(doubt.disturbance)
        both = np.hypot(noise[4:6], push)
        share = float(np.mean((push / np.maximum(both, FLOOR[4:6])) ** 2))
        noise[4:6], noise[6] = both, (1.0 - share) * noise[6] + share * MEMORY
    return np.asarray(np.maximum(noise, FLOOR))


def _linear_and_yaw(axes: Array) -> Array:
    """Surge and sway as one: root mean square."""
    return np.array([np.hypot(axes[0], axes[1]) / np.sqrt(2.0), axes[2]])


@dataclass(frozen=True)
class Doubt:
    """What a model's covariance amounts to, at speeds and commands anywhere in its envelope."""

    model: Model

    @cached_property
    def disturbance(self) -> Array:
        """Standard deviations (3,) of acceleration [m/s^2, m/s^2, rad/s^2], without latency and lag."""
        theta = np.concatenate([self.model.coefficients, self.model.constants])
        errors = np.sqrt(np.diag(self.model.covariance))
        slopes = np.zeros((len(theta), SAMPLES, 3))
        for i in np.flatnonzero(errors):
            step = np.zeros(len(theta))
            step[i] = STEP * errors[i]
            ahead = self._acceleration(theta + step, self._thrust(theta + step, self._commands[0]))
            back = self._acceleration(theta - step, self._thrust(theta - step, self._commands[0]))
            slopes[i] = (ahead - back) / (2.0 * step[i])
        return self._spread(slopes, np.arange(len(theta), dtype=np.int64))

    @cached_property
    def walk(self) -> Array:
        """[m/s, m/s, rad/s per sqrt(s)] of the velocity (3,), by latency and lag.

        A change of the acceleration by a that comes so much too late leaves a times that behind.
        """
        theta = np.concatenate([self.model.coefficients, self.model.constants])
        index, size = self.model.vehicle.constants.index, len(self.model.coefficients)
        before, after = (self._thrust(theta, c) for c in self._commands)
        start = self._acceleration(theta, before)
        used = [i for stage in TIMES for i in np.unique(index[:, STAGES.index(stage)]) if i >= 0]
        kicks = np.zeros((len(used), SAMPLES, 3))
        for kick, i in zip(kicks, used, strict=True):
            own = np.any(index[:, [STAGES.index(stage) for stage in TIMES]] == i, axis=1)
            kick[:] = self._acceleration(theta, np.where(own, after, before)) - start
        return np.asarray(
            np.sqrt(CHANGES) * self._spread(kicks, size + np.array(used, dtype=np.int64))
        )

    @cached_property
    def _speeds(self) -> Array:
        low, high = np.array([self.model.envelope.speeds[s] for s in SYMBOLS]).T
        share = np.random.default_rng(0).uniform(size=(SAMPLES, 3))
        return np.ascontiguousarray(low + (high - low) * share)

    @cached_property
    def _commands(self) -> Array:
        """Before and after a change (2, n, inputs)."""
        width = len(self.model.vehicle.inputs)
        return np.random.default_rng(1).uniform(-1.0, 1.0, (2, SAMPLES, width))

    def _thrust(self, theta: Array, command: Array) -> Array:
        """Settled thrust (n, actuators)."""
        chain, constants = self.model.vehicle.chain, theta[len(self.model.coefficients) :]
        given, _ = _core.allocate(chain, np.ascontiguousarray(command))
        constants = np.ascontiguousarray(constants)
        curves = [_core.curve(chain, constants, k, given) for k in range(given.shape[1])]
        return np.column_stack(curves)

    def _acceleration(self, theta: Array, thrust: Array) -> Array:
        """Accelerations (n, 3)."""
        coefficients = np.ascontiguousarray(theta[: len(self.model.coefficients)])
        force = np.ascontiguousarray(thrust @ self.model.vehicle.mix.T)
        compiled = self.model.structure.compiled
        return np.asarray(_core.accelerations(compiled, coefficients, self._speeds, force))

    def _spread(self, slopes: Array, at: NDArray[np.int64]) -> Array:
        """Root (3,) of the mean variance, by slopes (m, n, 3) to the parameters at `at` (m,)."""
        own = self.model.covariance[np.ix_(at, at)]
        square = np.einsum("ink,ij,jnk->k", slopes, own, slopes) / SAMPLES
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))
