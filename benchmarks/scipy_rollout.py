# SPDX-License-Identifier: MIT
"""The estimation as one would write it with SciPy: least_squares on a roll-out in NumPy.

Sought are the 11 coefficients of Eq. (12) and each recording's initial state, so that the sum of
squares of ((pose - simulated pose) / noise) is least, with the initial state's own spread beside.
Shares no code with seatrial.
"""

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]

STEP = 1e-6  # of the differences
STEPS = 4  # Runge-Kutta steps between two poses: about 1/60 s


@dataclass(frozen=True)
class Problem:
    """R recordings of n poses each; the actuator chain is known, so that forces are given."""

    h: Array  # (R, n - 1, STEPS) [s] Runge-Kutta steps after each pose; commands change between them
    eta: Array  # (R, n, 3) x, y [m], psi [rad] unwrapped
    nu: Array  # (R, n, 3) u, v [m/s], r [rad/s] differentiated: a guess
    force: Array  # (R, n - 1, STEPS, 3, 3) F at begin, middle and end of each step
    noise: Array  # (3,) of the poses [m, m, rad]
    initial: Array  # (R, 6) guess of the first state
    spread: Array  # (6,) its standard deviations
    theta: Array  # (11,) guess of the coefficients

    def save(self, path: Path) -> None:
        """To one file."""
        np.savez(path, **{f.name: getattr(self, f.name) for f in fields(self)})

    @classmethod
    def load(cls, path: Path) -> "Problem":
        """From its file."""
        with np.load(path) as data:
            return cls(**{f.name: data[f.name] for f in fields(cls)})


def rate(theta: Array, x: Array, F: Array) -> Array:
    """x_dot (6, R, P) of P boats in R recordings; theta (11, P), F (3, R, 1)."""
    X_u, X_uu, X_F, Y_v, Y_vv, Y_F, N_ud, N_r, N_rr, N_uu, N_F = theta
    psi, u, v, r = x[2:]
    size_u = np.abs(u)
    c, s = np.cos(psi), np.sin(psi)
    out = np.empty_like(x)
    out[0] = c * u - s * v
    out[1] = s * u + c * v
    out[2] = r
    out[3] = v * r + (X_u + X_uu * size_u) * u + X_F * F[0]
    out[4] = (Y_v + Y_vv * np.abs(v)) * v + Y_F * F[1] - u * r
    out[5] = N_ud * out[3] + (N_r + N_rr * np.abs(r)) * r + N_uu * size_u * u + N_F * F[2]
    return out


def roll_out(problem: Problem, theta: Array, x: Array) -> Array:
    """Poses (n, 3, R, P) from the states x (6, R, P) on."""
    poses = np.empty((problem.eta.shape[1], 3, *x.shape[1:]))
    poses[0] = x[:3]
    forces = np.ascontiguousarray(np.moveaxis(problem.force, 0, -1))[..., None]
    lengths = np.moveaxis(problem.h, 0, -1)[..., None]
    for k in range(len(forces)):
        for h, (begin, middle, end) in zip(lengths[k], forces[k], strict=True):
            k1 = rate(theta, x, begin)
            k2 = rate(theta, x + 0.5 * h * k1, middle)
            k3 = rate(theta, x + 0.5 * h * k2, middle)
            k4 = rate(theta, x + h * k3, end)
            x = x + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        poses[k + 1] = x[:3]
    return poses


class Residuals:
    """Residuals and Jacobian by differences, from one roll-out of 18 boats a recording."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.at = np.array([])

    def values(self, p: Array) -> Array:
        """Residuals (m,) of the parameters p: coefficients, then the initial states."""
        if not np.array_equal(p, self.at):
            self._evaluate(p)
        return self._values

    def jacobian(self, p: Array) -> Array:
        """(m, p)."""
        self.values(p)
        return self._jacobian

    def _evaluate(self, p: Array) -> None:
        problem, count = self.problem, len(self.problem.eta)
        theta, x = p[:11], p[11:].reshape(count, 6)
        shift = np.concatenate([np.zeros((17, 1)), STEP * np.eye(17)], axis=1)
        poses = roll_out(
            problem, theta[:, None] + shift[:11], x.T[:, :, None] + shift[11:, None, :]
        )
        scaled = np.transpose(poses, (2, 0, 1, 3)) / problem.noise[:, None]  # (R, n, 3, 18)
        slopes = (scaled[..., 1:] - scaled[..., :1]) / STEP
        size = slopes[0].size // 17
        self.at, rows = p.copy(), count * size
        self._values = np.concatenate([
            (scaled[..., 0] - problem.eta / problem.noise).ravel(),
            ((x - problem.initial) / problem.spread).ravel(),
        ])  # fmt: skip
        self._jacobian = np.zeros((rows + x.size, len(p)))
        for i in range(count):
            part = slopes[i].reshape(size, 17)
            here = slice(i * size, (i + 1) * size)
            self._jacobian[here, :11] = part[:, :11]
            self._jacobian[here, 11 + 6 * i : 17 + 6 * i] = part[:, 11:]
        self._jacobian[rows:, 11:] = np.diag(np.tile(1.0 / problem.spread, count))


def solve(problem: Problem) -> tuple[Array, int]:
    """Coefficients (11,) and evaluations, by a trust region on the dense Jacobian."""
    start = np.concatenate([problem.theta, problem.initial.ravel()])
    both = Residuals(problem)
    found = least_squares(
        both.values, start, jac=both.jacobian, x_scale="jac", ftol=1e-7, xtol=1e-6, gtol=1e-12
    )
    return found.x[:11], int(found.nfev)
