# SPDX-License-Identifier: MIT
"""The loop with exact delays: stability, and each axis' margins with the other axes closed.

About a steady motion nu_0 the controller sees, in body axes, the pose error q and the velocity error
w = nu + W q (a heading error turns the reference's velocity), with q_dot = w - r_0 S q. Its integral is
earth-fixed. Broken at the axis commands, the loop is L = C P, and the loop of
axis j with the others closed is 1 / S_jj - 1 with S = (I + L)^-1.

A boat without sway thrust has a guidance law instead of a sway controller: the heading error is
psi + y / Delta + (drift gain) y's earth-fixed integral, and y is the distance from the path's nearest point.
The second loop is then the cross-track one, broken at y with surge and yaw closed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from seatrial.control.tuning.guidance import Guidance
from seatrial.control.tuning.linear import Complex, LinearBoat
from seatrial.control.tuning.rules import Gains
from seatrial.util.frames import Array, Mask

LOOP_FREQUENCIES = 400  # frequencies of the nominal loop
# of the grid, times one over the slowest and the fastest time constant
LOWEST_FREQUENCY, HIGHEST_FREQUENCY = 1e-3, 100.0
NO_LOOP = 1e-300  # [-] for the logarithm of a loop that is open
S_2D = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
# in a bend a boat to the left of its path gets ahead along it
ALONG_BEND = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


@dataclass(frozen=True)
class Margins:
    """Of each axis (..., 3), loop by loop with the others closed.

    stable: (...,) of all three together
    gain_up: factor by which thrust may exceed the model's
    gain_down: factor to which it may fall; 0: any
    phase: [rad] additional lag that keeps it stable
    delay: [s] additional delay that keeps it stable
    sensitivity: largest |S|: worst amplification of a disturbance
    crossover: [rad/s] highest frequency at which the loop's gain is 1
    """

    stable: Mask
    gain_up: Array
    gain_down: Array
    phase: Array
    delay: Array
    sensitivity: Array
    crossover: Array

    def worst(self) -> "Margins":
        """The worst of the first dimension."""
        least = (getattr(self, name).min(axis=0) for name in ("phase", "delay"))
        most = (getattr(self, name).max(axis=0) for name in ("sensitivity", "crossover"))
        up, down = self.gain_up.min(axis=0), self.gain_down.max(axis=0)
        return Margins(np.asarray(self.stable.all(axis=0)), up, down, *least, *most)


def frequencies(
    knob: float, delay: float, points: int = LOOP_FREQUENCIES, slow: float = 0.0
) -> Array:
    """Angular frequencies [rad/s] that cover a loop with this knob [s] and delay [s].

    slow [s]: a time constant above the knob, of guidance.
    """
    fast = min(knob, max(delay, 0.02 * knob))
    return np.geomspace(LOWEST_FREQUENCY / max(knob, slow), HIGHEST_FREQUENCY / fast, points)


@dataclass(frozen=True)
class Feedback:
    """Gains, and the motions and frequencies at which the loop is evaluated."""

    gains: Sequence[Gains]  # of the three axes, in accelerations
    speeds: Array  # (m, 3) steady motions [m/s, m/s, rad/s]
    omega: Array  # (n,) [rad/s]
    hold: float  # [s] delay of the controller itself
    guidance: Guidance | None = None  # of a boat without sway thrust

    @property
    def integral(self) -> bool:
        """Whether it has integral action."""
        return any(g.integral != 0.0 for g in self.gains)

    @cached_property
    def response(self) -> Complex:
        """Commanded accelerations (m, n, 3, 3) per velocity: the controller with the kinematics."""
        return self._response(self.guidance)

    @cached_property
    def without_path(self) -> Complex:
        """`response` of a boat without sway thrust that holds a heading, not a path."""
        assert self.guidance is not None
        return self._response(replace(self.guidance, slowest=np.inf))

    def _response(self, guidance: Guidance | None) -> Complex:
        law = self._three_axes if guidance is None else partial(self._guided, guidance)
        s: Complex = np.asarray(1j * self.omega[:, None, None])
        return np.asarray(np.array([law(s, nu) for nu in self.speeds]) * np.exp(-s * self.hold))

    def _three_axes(self, s: Complex, nu: Array) -> Complex:
        """The controller (n, 3, 3) about one motion, without the hold."""
        kp, ki, kd = self._matrices
        eye, W = np.eye(3), _heading_coupling(nu)
        turning = s * eye + nu[2] * S_2D
        pose = np.linalg.inv(turning - W)
        return np.asarray(kp @ pose + ki @ np.linalg.solve(turning, pose) + kd @ (eye + W @ pose))

    def _guided(self, guidance: Guidance, s: Complex, nu: Array) -> Complex:
        """The same with guidance: surge by the error along the path, yaw by that of the heading."""
        kp, ki, kd = self._matrices
        eye, W = np.eye(3), _heading_coupling(nu)
        pose = np.linalg.inv(s * eye - nu[2] * ALONG_BEND - W)
        # integrals of one component of a vector that is fixed to the earth
        integral = s[:, 0] / (s[:, 0] ** 2 + nu[2] ** 2)
        near, drift = guidance.coupling(float(nu[0]), float(nu[2]))
        heading = pose[:, 2] + (near + drift * integral) * pose[:, 1]
        found = np.zeros_like(pose)
        found[:, 0] = kp[0, 0] * pose[:, 0] + ki[0, 0] * integral * pose[:, 0]
        found[:, 0] += kd[0, 0] * (eye + W @ pose)[:, 0]
        found[:, 2] = (kp[2, 2] + ki[2, 2] / s[:, 0] + kd[2, 2] * s[:, 0]) * heading
        return np.asarray(found)

    @property
    def _matrices(self) -> tuple[Array, Array, Array]:
        parts = ("proportional", "integral", "derivative")
        kp, ki, kd = (np.diag([getattr(g, name) for g in self.gains]) for name in parts)
        return kp, ki, kd

    def marginal(self, nu: Array, s: Complex) -> tuple[Complex, int]:
        """Of the controller about one motion: the product (n,) of its marginal poles, and their number."""
        turning = s**2 + nu[2] ** 2
        if self.guidance is None:
            k = 2 if self.integral else 1
            return np.asarray((s * turning) ** k), 3 * k
        # a component of an earth-fixed integral is one state on a straight path, two in a bend
        one, states = (turning, 2) if nu[2] != 0.0 else (s, 1)
        path, drift = self.guidance.coupling(float(nu[0]), float(nu[2]))
        found, n = (s**3, 3) if path else (s**2, 2)
        if drift:
            found, n = found * one, n + states
        if self.integral:
            found, n = found * s * one, n + 1 + states
        return np.asarray(found), n


def open_loop(boat: LinearBoat, feedback: Feedback, strength: float = 1.0) -> Complex:
    """L (m, n, 3, 3) about each steady motion; strength: of the thrusters, relative to the model."""
    return _loop(boat, feedback, feedback.response, strength)


def _loop(boat: LinearBoat, feedback: Feedback, response: Complex, strength: float) -> Complex:
    s = 1j * feedback.omega
    B = strength * boat.actuators.response(feedback.omega)
    velocity = np.linalg.solve(s[:, None, None] * np.eye(3) - boat.slopes[:, None], B[None])
    return np.asarray(response @ velocity * boat.per_authority[:, None])


def single_loops(
    boat: LinearBoat, feedback: Feedback, strength: float = 1.0
) -> tuple[Complex, Complex]:
    """Each loop (m, 3, n) with the others closed, and det(I + L) (m, n).

    With guidance the second is the cross-track loop: closing it takes the determinant without it to det(I + L).
    """
    whole, own = _determinants(np.eye(3) + open_loop(boat, feedback, strength))
    if feedback.guidance is not None:
        heading = _loop(boat, feedback, feedback.without_path, strength)
        own[:, 1] = _determinants(np.eye(3) + heading)[0]
    return np.asarray(whole[:, None] / own - 1.0), whole


def margins(boat: LinearBoat, feedback: Feedback, strength: float = 1.0) -> Margins:
    """Of the loop about each steady motion (m,); arguments as of `open_loop`."""
    single, whole = single_loops(boat, feedback, strength)
    up, down = gain_margins(single)
    phase, delay, crossover = phase_margins(single, feedback.omega)
    stable = unstable_poles(boat, feedback, whole) == 0
    sensitivity = 1.0 / np.abs(1.0 + single).min(axis=-1)
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
    size = np.log(np.maximum(np.abs(L), NO_LOOP))
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

    whole: det(I + L) (m, n). The characteristic function det(s I - A) q(s) det(I + L), q of `Feedback.marginal`,
    has no poles there; from s = 0 to i inf it turns by as many right angles as there are states, and by two
    fewer for each zero on the right.
    """
    s: Complex = np.asarray(1j * feedback.omega)
    found = []
    for nu, A, value in zip(boat.speeds, boat.slopes, whole, strict=True):
        free = np.prod(s[:, None] - np.linalg.eigvals(A), axis=1)
        marginal, n = feedback.marginal(nu, s)
        turns = np.unwrap(np.angle(value * free * marginal))
        found.append(round(((3 + n) * np.pi / 2 - (turns[-1] - turns[0])) / np.pi))
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
