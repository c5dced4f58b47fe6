# SPDX-License-Identifier: MIT
"""The loop with exact delays: stability, and each axis' margins with the other axes closed.

About a steady motion nu_0 the controller sees, in body axes, the pose error q and the velocity error
w = nu + W q (a heading error turns the reference's velocity), with q_dot = w - r_0 S q. Its integral is
earth-fixed. Broken at the axis commands, the loop is L = C P, and the loop of
axis j with the others closed is 1 / S_jj - 1 with S = (I + L)^-1.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial.control.tuning.linear import Complex, LinearBoat
from seatrial.control.tuning.rules import Gains
from seatrial.util.frames import Array, Mask

LOOP_FREQUENCIES = 400  # frequencies of the nominal loop
# of the grid, times one over the slowest and the fastest time constant
LOWEST_FREQUENCY, HIGHEST_FREQUENCY = 1e-3, 100.0
S_2D = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


@dataclass(frozen=True)
class Margins:
    """Of each axis (..., 3), loop by loop with the others closed."""

    stable: Mask  # (...,) of all three together
    gain_up: Array  # factor by which thrust may exceed the model's
    gain_down: Array  # factor to which it may fall; 0: any
    phase: Array  # [rad]
    delay: Array  # [s] additional delay that keeps it stable
    sensitivity: Array  # largest |S|: worst amplification of a disturbance
    crossover: Array  # [rad/s] highest frequency at which the loop's gain is 1

    def worst(self) -> "Margins":
        """The worst of the first dimension."""
        least = (getattr(self, name).min(axis=0) for name in ("phase", "delay"))
        most = (getattr(self, name).max(axis=0) for name in ("sensitivity", "crossover"))
        up, down = self.gain_up.min(axis=0), self.gain_down.max(axis=0)
        return Margins(np.asarray(self.stable.all(axis=0)), up, down, *least, *most)


def frequencies(knob: float, delay: float, points: int = LOOP_FREQUENCIES) -> Array:
    """Angular frequencies [rad/s] that cover a loop with this knob [s] and delay [s]."""
    fast = min(knob, max(delay, 0.02 * knob))
    return np.geomspace(LOWEST_FREQUENCY / knob, HIGHEST_FREQUENCY / fast, points)


@dataclass(frozen=True)
class Feedback:
    """Gains, and the motions and frequencies at which the loop is evaluated."""

    gains: Sequence[Gains]  # of the three axes, in accelerations
    speeds: Array  # (m, 3) steady motions [m/s, m/s, rad/s]
    omega: Array  # (n,) [rad/s]
    hold: float  # [s] delay of the controller itself

    @property
    def integral(self) -> bool:
        """Whether it has integral action."""
        return any(g.integral != 0.0 for g in self.gains)

    @cached_property
    def response(self) -> Complex:
        """Commanded accelerations (m, n, 3, 3) per velocity: the controller with the kinematics."""
        parts = ("proportional", "integral", "derivative")
        kp, ki, kd = (np.diag([getattr(g, name) for g in self.gains]) for name in parts)
        s, eye = 1j * self.omega[:, None, None], np.eye(3)
        found = []
        for nu in self.speeds:
            W = _heading_coupling(nu)
            turning = s * eye + nu[2] * S_2D
            pose = np.linalg.inv(turning - W)
            found.append(kp @ pose + ki @ np.linalg.solve(turning, pose) + kd @ (eye + W @ pose))
        return np.asarray(np.array(found) * np.exp(-s * self.hold))


def open_loop(boat: LinearBoat, feedback: Feedback, strength: float = 1.0) -> Complex:
    """L (m, n, 3, 3) about each steady motion; strength: of the thrusters, relative to the model."""
    s = 1j * feedback.omega
    B = strength * boat.actuators.response(feedback.omega)
    velocity = np.linalg.solve(s[:, None, None] * np.eye(3) - boat.slopes[:, None], B[None])
    return np.asarray(feedback.response @ velocity / boat.authority[:, None])


def margins(boat: LinearBoat, feedback: Feedback, strength: float = 1.0) -> Margins:
    """Of the loop about each steady motion (m,); arguments as of `open_loop`."""
    L = open_loop(boat, feedback, strength)
    whole, own = _determinants(np.eye(3) + L)
    single: Complex = np.asarray(whole[:, None] / own - 1.0)
    up, down = gain_margins(single)
    phase, delay, crossover = phase_margins(single, feedback.omega)
    stable = unstable_poles(boat, feedback, whole) == 0
    sensitivity = np.abs(own / whole[:, None]).max(axis=-1)
    return Margins(stable, up, down, phase, delay, sensitivity, crossover)


def _determinants(m: Complex) -> tuple[Complex, Complex]:
    """Of matrices (m, n, 3, 3), and of what is left without row and column j: (m, n), (m, 3, n)."""
    a, b, c = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    d, e, f = m[..., 0, 1], m[..., 0, 2], m[..., 1, 2]
    g, h, i = m[..., 1, 0], m[..., 2, 0], m[..., 2, 1]
    left = np.stack([b * c - f * i, a * c - e * h, a * b - d * g], axis=1)
    return a * left[:, 0] - d * (g * c - f * h) + e * (g * i - b * h), left


def gain_margins(L: Complex) -> tuple[Array, Array]:
    """Factors up and down (...,) by which loops (..., n) reach -1; inf and 0 where none does."""
    a, b = L[..., :-1], L[..., 1:]
    share = _zero_crossing(a.imag, b.imag)
    real = a.real + share * (b.real - a.real)
    crosses = (a.imag * b.imag <= 0) & (a.imag != b.imag) & (real < 0)
    factor = np.where(crosses, -1.0 / np.where(crosses, real, -1.0), np.nan)
    up = np.where(factor > 1.0, factor, np.inf).min(axis=-1)
    down = np.where(factor <= 1.0, factor, 0.0).max(axis=-1)
    return np.asarray(up), np.asarray(down)


def phase_margins(L: Complex, omega: Array) -> tuple[Array, Array, Array]:
    """Phase [rad], delay [s], and highest crossover [rad/s] (...,) of loops (..., n)."""
    size = np.log(np.abs(L))
    angle = np.unwrap(np.angle(L), axis=-1)
    a, b = size[..., :-1], size[..., 1:]
    crosses = a * b <= 0
    share = _zero_crossing(a, b)
    at = np.exp(np.log(omega[:-1]) + share * np.diff(np.log(omega)))
    turned = angle[..., :-1] + share * np.diff(angle, axis=-1)
    left = np.mod(turned + np.pi, 2.0 * np.pi)  # phase lag that remains
    delay = np.where(crosses, left / at, np.inf).min(axis=-1)
    either = np.minimum(left, 2.0 * np.pi - left)
    phase = np.where(crosses, either, np.inf).min(axis=-1)
    return np.asarray(phase), np.asarray(delay), np.where(crosses, at, 0.0).max(axis=-1)


def unstable_poles(boat: LinearBoat, feedback: Feedback, whole: Complex) -> NDArray[np.int64]:
    """Number (m,) of closed-loop poles in the right half plane, by the argument principle.

    whole: det(I + L) (m, n). The characteristic function det(s I - A) (s (s^2 + r_0^2))^k det(I + L), k = 2 with
    an integral and 1 without, has no poles there; from s = 0 to i inf it turns by as many right angles as
    there are states, and by two fewer for each zero on the right.
    """
    s, k = 1j * feedback.omega, 2 if feedback.integral else 1
    found = []
    for nu, A, value in zip(boat.speeds, boat.slopes, whole, strict=True):
        free = np.prod(s[:, None] - np.linalg.eigvals(A), axis=1)
        turns = np.unwrap(np.angle(value * free * (s * (s**2 + nu[2] ** 2)) ** k))
        found.append(round((3 * (1 + k) * np.pi / 2 - (turns[-1] - turns[0])) / np.pi))
    return np.array(found)


def _heading_coupling(nu: Array) -> Array:
    """W: effect of a heading error on the reference's velocity."""
    W = np.zeros((3, 3))
    W[0, 2], W[1, 2] = -nu[1], nu[0]
    return W


def _zero_crossing(a: Array, b: Array) -> Array:
    """Zero crossing between two samples, as a share of the step."""
    step = a - b
    return np.clip(np.divide(a, step, out=np.zeros_like(a), where=step != 0.0), 0.0, 1.0)
