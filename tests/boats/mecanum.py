# SPDX-License-Identifier: MIT
"""A simulated carrier: four mecanum wheels with lag and slip, and a delayed odometry."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.util.frames import Array

ARM = 0.35  # [m] half of length and width together
# wheel speeds of a body velocity (front left, front right, rear left, rear right; per radius)
TO_WHEELS = np.array([[1, -1, -ARM], [1, 1, ARM], [1, 1, -ARM], [1, -1, ARM]], dtype=float)
TO_BODY = np.linalg.pinv(TO_WHEELS)


@dataclass(frozen=True)
class Ground:
    """Errors of wheels, floor and odometry."""

    lag: float = 0.1  # [s] time constant of the wheels' speeds
    delay: float = 0.04  # [s] until a velocity takes effect
    worn: float = 0.03  # constant relative error of each wheel's speed, standard deviation
    slips_per_minute: float = 20.0  # of any one wheel
    slip: float = 0.5  # relative loss of speed during a slip
    slip_length: float = 0.3  # [s]
    pose_rate: float = 20.0  # [Hz]
    pose_delay: float = 0.06  # [s]
    position_noise: float = 0.005  # [m] standard deviation
    heading_noise: float = 0.01  # [rad]
    sees_slip: bool = True  # False: odometry counts the wheels' turns


class SimulatedCarrier:
    """Steps of `dt` [s]; its true pose is `eta` (3,), its odometry is `poses`."""

    def __init__(self, ground: Ground, dt: float, seed: int) -> None:
        self.ground, self.dt = ground, dt
        self._rng = np.random.default_rng(seed)
        self._worn = 1.0 - ground.worn * self._rng.normal(size=4)
        self._wheels = np.zeros(4)
        self._slipping = np.zeros(4)  # [s] left
        self._pending: deque[Array] = deque([np.zeros(3)] * round(ground.delay / dt))
        self._sent: deque[tuple[float, float, Array]] = deque()  # arrival, stamp, pose
        self._readings = 1
        self.eta = np.zeros(3)
        self._counted = np.zeros(3)  # by the wheels' turns
        self.time = 0.0

    def step(self, velocity: Array) -> None:
        """Advance by dt under a velocity (3,)."""
        ground, dt = self.ground, self.dt
        self._pending.append(np.asarray(velocity))
        wanted = TO_WHEELS @ self._pending.popleft()
        self._wheels += (wanted - self._wheels) * -np.expm1(-dt / ground.lag)
        begins = self._rng.random(4) < ground.slips_per_minute * dt / 240.0
        self._slipping = np.where(begins, ground.slip_length, np.maximum(self._slipping - dt, 0.0))
        grip = self._worn * np.where(self._slipping > 0.0, 1.0 - ground.slip, 1.0)
        self.eta = _moved(self.eta, TO_BODY @ (self._wheels * grip), dt)
        self._counted = _moved(self._counted, TO_BODY @ self._wheels, dt)
        self.time += dt
        if self.time >= self._readings / ground.pose_rate - 1e-9:
            self._readings += 1
            self._measure()

    def poses(self) -> list[tuple[float, Array]]:
        """Stamp [s] and pose (3,) of the poses since the last call."""
        found = []
        while self._sent and self._sent[0][0] <= self.time:
            _, stamp, pose = self._sent.popleft()
            found.append((stamp, pose))
        return found

    def _measure(self) -> None:
        ground = self.ground
        noise = np.array([ground.position_noise, ground.position_noise, ground.heading_noise])
        pose = self.eta if ground.sees_slip else self._counted
        self._sent.append(
            (self.time + ground.pose_delay, self.time, pose + noise * self._rng.normal(size=3))
        )


def _moved(eta: Array, nu: Array, dt: float) -> Array:
    """Pose after dt at a body velocity (3,), by the midpoint heading."""
    middle = np.array([eta[2] + 0.5 * dt * nu[2]])
    return np.asarray(eta + dt * _core.rotate(middle, np.ascontiguousarray(nu[None]), False)[0])
