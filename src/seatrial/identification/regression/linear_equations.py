# SPDX-License-Identifier: MIT
"""Equations that are linear in the coefficients once the constants of the actuator chain are fixed.

Latency, lag and dead zone are scanned on a grid, the value with the smallest residual is kept, and refined by
Gauss-Newton.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.recording.pose_noise import MAD_OF_NORMAL
from seatrial.util.frames import Array, Mask

LATENCY_GRID = (-0.5, -0.2, 0.1, 0.4, 0.8)  # [s]
LAG_GRID = (0.02, 0.1, 0.2, 0.4, 0.8)  # [s] where the latency is given
DEAD_ZONE_GRID = (0.0, 0.08, 0.16, 0.3)  # of full command
ROW_OUTLIER = 1.5  # [robust standard deviations] beyond which a row counts linearly (Huber)


@dataclass(frozen=True)
class ConstantSteps:
    """How a constant of the chain is searched."""

    probe: float  # finite difference for its derivative
    most: float  # largest change in one step
    grid: tuple[float, ...] = ()  # values of the first scan


CONSTANT_STEPS = {
    "latency": ConstantSteps(0.02, 0.15, LATENCY_GRID),  # [s]
    "lag": ConstantSteps(0.02, 0.15, LAG_GRID),  # [s]
    "slew_rate": ConstantSteps(0.1, 0.5),  # [1/s]
    "edge_forward": ConstantSteps(0.02, 0.08, DEAD_ZONE_GRID),
    "edge_reverse": ConstantSteps(0.02, 0.08, DEAD_ZONE_GRID),
    "pair_dead_zone": ConstantSteps(0.02, 0.08, DEAD_ZONE_GRID),
    "steer_rate": ConstantSteps(2.0, 20.0),  # [deg/s]
    "steer_angle": ConstantSteps(2.0, 10.0),  # [deg]
    "steer_offset": ConstantSteps(1.0, 5.0),  # [deg]
    "steer_dead_zone": ConstantSteps(0.02, 0.08, DEAD_ZONE_GRID),
    "pair_offset_along": ConstantSteps(0.02, 0.08),
    "pair_offset_across": ConstantSteps(0.02, 0.08),
}


class Equations(Protocol):
    """Equations linear in the coefficients, for given constants of the chain."""

    @property
    def vehicle(self) -> Vehicle:
        """Whose constants they are."""

    @property
    def use(self) -> Mask:
        """(m, 3) rows that count."""

    def design(self, constants: Array) -> "LinearEquations":
        """The equations for these constants."""


@dataclass(frozen=True)
class LinearEquations:
    """a = B theta."""

    a: Array  # (m, 3)
    B: Array  # (m, 3, n)

    def solved(self, weights: Array) -> Array:
        """Weighted least squares (n,); coefficients without any data are 0."""
        flat = self.B.reshape(-1, self.B.shape[2])
        weighted = flat * weights.reshape(-1, 1)
        normal = flat.T @ weighted
        alive = np.linalg.norm(flat, axis=0) > 1e-9 * np.sqrt(len(flat))  # more than rounding
        size = np.where(alive, np.sqrt(np.diag(normal)) + 1e-12, np.inf)
        # the ridge keeps parameters without excitation near 0
        scaled = normal / np.outer(size, size) + 1e-8 * np.eye(len(size))
        return np.asarray(np.linalg.solve(scaled, weighted.T @ self.a.ravel() / size) / size)

    def cost(self, theta: Array, weights: Array) -> float:
        """Weighted sum of squared residuals."""
        return float(np.sum(weights * (self.a - self.B @ theta) ** 2))

    def weights(self, use: Mask) -> Array:
        """Huber's weights (m, 3) over the squared robust spread of each axis' residuals."""
        spread = np.array([np.std(self.a[use[:, k], k]) for k in range(3)]) + 1e-12
        weights: Array = use / spread**2
        for _ in range(4):
            error = np.abs(self.a - self.B @ self.solved(weights))
            middle = [np.median(error[use[:, k], k]) for k in range(3)]
            spread = np.array(middle) / MAD_OF_NORMAL + 1e-9  # without any noise
            weights = use / np.maximum(1.0, error / spread / ROW_OUTLIER) / spread**2
        return weights


@dataclass(frozen=True)
class EquationFit:
    """A solution of the equations."""

    theta: Array  # (n,)
    constants: Array  # (m,)
    design: LinearEquations
    weights: Array  # (m, 3)


def movable_constants(vehicle: Vehicle, free: Sequence[int]) -> dict[int, ConstantSteps]:
    """How the constants that are estimated are searched, by index."""
    stage = {i: vehicle.constants.names[i].partition(".")[0] for i in free}
    found = {i: CONSTANT_STEPS[s] for i, s in stage.items() if s in CONSTANT_STEPS}
    delayed = any(c.grid == LATENCY_GRID for c in found.values())
    # scan one of lag and latency only: they are separated later
    return {
        i: replace(c, grid=()) if delayed and c.grid == LAG_GRID else c for i, c in found.items()
    }


def fit_equations(rows: Equations, moved: Mapping[int, ConstantSteps], steps: int) -> EquationFit:
    """Coefficients and constants: a scan of each kind on its grid, then Gauss-Newton steps."""
    constants = rows.vehicle.constants.values.copy()
    weights = rows.design(constants).weights(rows.use)
    for grid in (LATENCY_GRID, LAG_GRID, DEAD_ZONE_GRID):
        places = [i for i, change in moved.items() if change.grid == grid]
        if places:
            constants = _scanned(rows, weights, constants, places, grid)
    return _refined(rows, constants, moved, steps if moved else 0)


def with_constant_columns(
    rows: Equations, at: EquationFit, moved: Mapping[int, ConstantSteps]
) -> LinearEquations:
    """The equations with further columns for changes of the constants, by finite differences."""
    columns = []
    for i, change in moved.items():
        probe = rows.design(_placed(at.constants, [i], at.constants[i] + change.probe))
        tilt = (probe.B - at.design.B) @ at.theta - (probe.a - at.design.a)
        columns.append(tilt[:, :, None] / change.probe)
    return LinearEquations(at.design.a, np.concatenate([at.design.B, *columns], axis=2))


def _scanned(
    rows: Equations, weights: Array, constants: Array, places: Sequence[int], grid: Sequence[float]
) -> Array:
    """The constants with those at `places` at the best grid value, refined by a parabola."""
    costs = []
    for value in grid:
        design = rows.design(_placed(constants, places, value))
        costs.append(design.cost(design.solved(weights), weights))
    i = int(np.argmin(costs))
    inside = 0 < i < len(grid) - 1
    best = _lowest(grid[i - 1 : i + 2], costs[i - 1 : i + 2]) if inside else grid[i]
    return _placed(constants, places, best)


def _refined(
    rows: Equations, constants: Array, moved: Mapping[int, ConstantSteps], steps: int
) -> EquationFit:
    """Gauss-Newton steps on coefficients and constants together; the coefficients are solved exactly."""
    at = _solved_at(rows, constants)
    for _ in range(steps):
        step = with_constant_columns(rows, at, moved).solved(at.weights)[len(at.theta) :]
        before = at.design.cost(at.theta, at.weights)
        for share in (1.0, 0.3):
            trial = _moved(rows, at.constants, moved, share * step)
            design = rows.design(trial)
            after = design.cost(design.solved(at.weights), at.weights)
            if after < before:
                at = _solved_at(rows, trial, design)
                break
        if after > (1 - 1e-4) * before:
            break
    return at


def _moved(
    rows: Equations, constants: Array, moved: Mapping[int, ConstantSteps], step: Array
) -> Array:
    """The constants (m,) after a step, within their bounds."""
    out = constants.copy()
    for (i, c), s in zip(moved.items(), step, strict=True):
        out[i] = np.clip(out[i] + np.clip(s, -c.most, c.most), *rows.vehicle.constants.bounds(i))
    return out


def _solved_at(
    rows: Equations, constants: Array, design: LinearEquations | None = None
) -> EquationFit:
    there = design or rows.design(constants)
    weights = there.weights(rows.use)
    return EquationFit(there.solved(weights), constants, there, weights)


def _placed(constants: Array, places: Sequence[int], value: float) -> Array:
    out = constants.copy()
    out[list(places)] = value
    return out


def _lowest(x: Sequence[float], y: Sequence[float]) -> float:
    """The minimum of the parabola through three points, the middle one being the lowest."""
    left, right = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    bend = (right - left) / (x[2] - x[0])
    if bend <= 0:
        return x[1]
    return float(np.clip((x[0] + x[1]) / 2 - left / (2 * bend), x[0], x[2]))
