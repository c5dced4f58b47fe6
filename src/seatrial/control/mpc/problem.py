# SPDX-License-Identifier: MIT
"""The optimal control problem, as CasADi functions: multiple shooting, one Gauss-Newton step a call.

Stage k has state z_k = [eta, nu, level] and thrust g_k, constant over the stage, and s_k, the
distance of the boat's origin beyond the walls. The cost is half a sum of squares, and an exact penalty on s,
so that a wall is violated only where the problem is infeasible otherwise. A call linearises it
around the last solution and solves one quadratic programme (real-time iteration: Diehl, Bock and
Schloeder, 2005).
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from seatrial.boat.model import Model
from seatrial.control.mpc.thrusters import Thrusters
from seatrial.export.casadi import Symbol, casadi_dynamics, casadi_mix, casadi_module
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array

if TYPE_CHECKING:
    import casadi

POSE_SIZE, MOTION_SIZE = 3, 6  # eta; eta and nu
LARGEST_ERROR = 3.0  # [m] largest lasting position error, for the penalty's weight
# [-] on the Hessian's diagonal: keeps the quadratic programme strictly convex
HESSIAN_REGULARISATION = 1e-6


@dataclass(frozen=True)
class Weights:
    """Weights of the cost: one over the error of unit cost, term by term."""

    position: float = 1 / 0.02  # [1/m] across the path, whose direction is the reference's heading
    along: float = 1 / 0.02  # [1/m] along the path
    heading: float = 1 / 0.05  # [1/rad]
    velocity: float = 1 / 0.10  # [s/m] surge
    sway: float = 1 / 0.10  # [s/m]
    yaw_rate: float = 1 / 0.20  # [s/rad]
    thrust: float = 1 / 2.0  # [-] from idle, of full thrust
    change: float = 1 / 1.0  # [-] from stage to stage

    def price(self, stages: int) -> float:
        """Penalty on a wall's violation [1/m]: above the gradient of all stages' position errors."""
        return self.position**2 * LARGEST_ERROR * stages


# Of a boat without sway thrust: it follows the path; sway and heading are free, as wind and current require
PATH_FOLLOWING = Weights(
    position=1 / 0.05, along=1 / 0.30, heading=0.0, velocity=1 / 0.20, sway=0.0, yaw_rate=1 / 0.50
)  # fmt: skip


# With one thrust and its angle: it steers only under thrust, so that position errors weigh less
STEERED_FOLLOWING = replace(PATH_FOLLOWING, position=1 / 0.10)


@dataclass(frozen=True)
class Grid:
    """Stages ahead."""

    stages: int = 12
    length: float = 0.2  # [s] of each
    substeps: int = 2  # of Runge-Kutta in each

    def __post_init__(self) -> None:
        if self.stages < 2 or self.substeps < 1 or not 0.0 < self.length < float("inf"):
            raise ControlError(
                f"{self.stages} stages of {self.length:g} s, {self.substeps} substeps: expected two "
                "stages or more, a length and substeps above 0"
            )

    @property
    def times(self) -> Array:
        """Ends (stages,) of the stages [s]."""
        return np.asarray(self.length * np.arange(1, self.stages + 1))


# for `PATH_FOLLOWING`: sway settles by the hull's drag alone
PATH_GRID = Grid(stages=15, length=0.3)
# for `STEERED_FOLLOWING`: a shorter plan ends in a turn about, and the boat goes on astern
STEERED_GRID = Grid(stages=20, length=0.4)


def stage(model: Model, thrusters: Thrusters, grid: Grid) -> "casadi.Function":
    """z at a stage's end from z (6 + n,) at its start, thrust (n,) and disturbance (3,).

    Levels follow the thrust exactly, with their lag; an angle with a rate limit turns evenly over the stage.
    eta and nu by the classical Runge-Kutta method. The
    disturbance [m/s^2, m/s^2, rad/s^2] is earth-fixed, as the predictor's.
    """
    ca = casadi_module()
    n = len(thrusters.lag)
    z, g, d = ca.SX.sym("z", MOTION_SIZE + n), ca.SX.sym("g", n), ca.SX.sym("d", 3)
    dynamics = casadi_dynamics(model)
    mix = casadi_mix(model)
    known = [signal.reference for signal in model.vehicle.file.scales.values()]

    def slope(x: Symbol, level: Symbol) -> Symbol:
        c, s = ca.cos(x[2]), ca.sin(x[2])
        force = ca.vertcat(0, 0, 0, c * d[0] + s * d[1], -s * d[0] + c * d[1], d[2])
        return dynamics(x, mix(level, known)) + force

    h = grid.length / grid.substeps
    x, first = z[:MOTION_SIZE], z[MOTION_SIZE:]

    def level_at(t: float) -> Symbol:
        return g + (first - g) * ca.DM(thrusters.left(t, grid.length))

    level = first
    for step in range(grid.substeps):
        middle, end = level_at((step + 0.5) * h), level_at((step + 1.0) * h)
        k1 = slope(x, level)
        k2 = slope(x + h / 2 * k1, middle)
        k3 = slope(x + h / 2 * k2, middle)
        k4 = slope(x + h * k3, end)
        x, level = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), end
    found: casadi.Function = ca.Function(
        "stage", [z, g, d], [ca.vertcat(x, level)], ["z", "g", "d"], ["next"]
    )
    return found
