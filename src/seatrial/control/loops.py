# SPDX-License-Identifier: MIT
"""The loop with its exact delays: stable or not, and each axis' margins with the other axes closed.

About a steady motion nu_0 the controller sees, in body axes, the pose error q and the velocity error
w = nu + W q (a heading error turns the reference's velocity), with q_dot = w - r_0 S q. What it
integrates is fixed to the earth. Broken at the axis commands, the loop is L = C P, and the loop of axis
j alone is 1 / S_jj - 1 with S = (I + L)^-1.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial.control.linear import Complex, LinearBoat
from seatrial.control.rules import Gains
from seatrial.frames import Array, Mask

GRID = 400  # frequencies of a loop that is shown
SLOWEST, FASTEST = 1e-3, 100.0  # of the grid, over the slowest and the fastest time constant
S_2D = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


@dataclass(frozen=True)
class Margins:
    """Of each axis (..., 3), loop by loop with the others closed."""

    stable: Mask  # (...,) of all three together
    gain_up: Array  # by how much thrust may be stronger than the model says
    gain_down: Array  # ... or weaker: 0 where it may vanish
    phase: Array  # [rad]
    delay: Array  # [s] that may come on top
    sensitivity: Array  # largest |S|: over how much a disturbance is amplified at worst
    crossover: Array  # [rad/s] highest frequency at which the loop's gain is 1

    def worst(self) -> "Margins":
        """The worst of the first dimension."""
        least = (getattr(self, name).min(axis=0) for name in ("phase", "delay"))
        most = (getattr(self, name).max(axis=0) for name in ("sensitivity", "crossover"))
        up, down = self.gain_up.min(axis=0), self.gain_down.max(axis=0)
        return Margins(np.asarray(self.stable.all(axis=0)), up, down, *least, *most)


def frequencies(knob: float, delay: float, points: int = GRID) -> Array:
    """Angular frequencies [rad/s] that hold all of a loop with this knob [s] and delay [s]."""
    fast = min(knob, max(delay, 0.02 * knob))
    return np.geomspace(SLOWEST / knob, FASTEST / fast, points)


def open_loop(
    boat: LinearBoat, gains: Sequence[Gains], omega: Array, hold: float, strength: float = 1.0
) -> Complex:
    """L (m, n, 3, 3) about each steady motion at angular frequencies (n,) [rad/s].

    gains: of the three axes, in accelerations. hold [s]: delay of the controller itself. strength: of the
    thrusters, over what the model says.
    """
    s = 1j * omega
    kp, ki, kd = (np.diag([getattr(g, name) for g in gains]) for name in _PARTS)
    B = boat.actuators.response(omega) * (strength * np.exp(-s * hold))[:, None, None]
    eye = np.eye(3)
    found = []
    for nu, A in zip(boat.speeds, boat.slopes, strict=True):
        W = _turned(nu)
        velocity = np.linalg.solve(s[:, None, None] * eye - A, B)
        turning = s[:, None, None] * eye + nu[2] * S_2D
        pose = np.linalg.solve(turning - W, velocity)
        asked = kp @ pose + ki @ np.linalg.solve(turning, pose) + kd @ (velocity + W @ pose)
        found.append(asked / boat.authority[:, None])
    return np.array(found)


_PARTS = ("proportional", "integral", "derivative")


def margins(
    boat: LinearBoat, gains: Sequence[Gains], omega: Array, hold: float, strength: float = 1.0
) -> Margins:
    """Of the loop about each steady motion (m,); arguments as of `open_loop`."""
    L = open_loop(boat, gains, omega, hold, strength)
    S = np.linalg.inv(np.eye(3) + L)
    own = np.moveaxis(np.diagonal(S, axis1=2, axis2=3), 1, 2)  # (m, 3, n)
    alone: Complex = np.asarray(1.0 / own - 1.0)
    up, down = gain_margins(alone)
    phase, delay, crossover = phase_margins(alone, omega)
    stable = unstable_poles(boat, L, omega, gains) == 0
    return Margins(stable, up, down, phase, delay, np.abs(own).max(axis=-1), crossover)


def gain_margins(L: Complex) -> tuple[Array, Array]:
    """Factors up and down (...,) by which loops (..., n) reach -1; inf and 0 where none does."""
    a, b = L[..., :-1], L[..., 1:]
    share = _share(a.imag, b.imag)
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
    share = _share(a, b)
    at = np.exp(np.log(omega[:-1]) + share * np.diff(np.log(omega)))
    turned = angle[..., :-1] + share * np.diff(angle, axis=-1)
    left = np.mod(turned + np.pi, 2.0 * np.pi)  # how far it may turn backwards
    delay = np.where(crosses, left / at, np.inf).min(axis=-1)
    either = np.minimum(left, 2.0 * np.pi - left)
    phase = np.where(crosses, either, np.inf).min(axis=-1)
    return np.asarray(phase), np.asarray(delay), np.where(crosses, at, 0.0).max(axis=-1)


def unstable_poles(
    boat: LinearBoat, L: Complex, omega: Array, gains: Sequence[Gains]
) -> NDArray[np.int64]:
    """Number (m,) of closed-loop poles in the right half plane, by the argument principle.

    The characteristic function det(s I - A) det(s I + r_0 S - W) det(s I + r_0 S) det(I + L) has no poles
    there; from s = 0 to i inf it turns by as many right angles as there are states, and by two fewer for each
    zero on the right.
    """
    s = 1j * omega[:, None, None]
    eye = np.eye(3)
    integral = any(g.integral != 0.0 for g in gains)
    states = 9 if integral else 6
    found = []
    for nu, A, loop in zip(boat.speeds, boat.slopes, L, strict=True):
        turning = s * eye + nu[2] * S_2D
        value = np.linalg.det(eye + loop) * np.linalg.det(s * eye - A)
        value *= np.linalg.det(turning - _turned(nu))
        value *= np.linalg.det(turning) if integral else 1.0
        turns = np.unwrap(np.angle(value))
        found.append(round((states * np.pi / 2 - (turns[-1] - turns[0])) / np.pi))
    return np.array(found)


def _turned(nu: Array) -> Array:
    """W: what a heading error makes of the reference's velocity."""
    W = np.zeros((3, 3))
    W[0, 2], W[1, 2] = -nu[1], nu[0]
    return W


def _share(a: Array, b: Array) -> Array:
    """Where between two samples a signal is 0."""
    step = a - b
    return np.clip(np.divide(a, step, out=np.zeros_like(a), where=step != 0.0), 0.0, 1.0)
