# SPDX-License-Identifier: MIT
"""One step of the controller as a CasADi function, for Python and for C code generation."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from seatrial.boat.model import Model
from seatrial.control.mpc.interior_point import minimum
from seatrial.control.mpc.problem import (
    HESSIAN_REGULARISATION,
    MOTION_SIZE,
    POSE_SIZE,
    Grid,
    Weights,
    stage,
)
from seatrial.control.mpc.thrusters import Thrusters
from seatrial.export.casadi import Symbol, casadi_module
from seatrial.util.frames import Array

if TYPE_CHECKING:
    import casadi

WALLS = 4  # x and y, both directions
START_MULTIPLIER = 0.01  # of the walls' penalty: initial multipliers


@dataclass(frozen=True)
class Layout:
    """Layout of the variables w: stage by stage z, g, s; at the end the last z."""

    n: int  # thrusters
    stages: int

    @property
    def block(self) -> int:
        """Of one stage."""
        return MOTION_SIZE + 2 * self.n + 1

    @property
    def size(self) -> int:
        """Of w."""
        return self.stages * self.block + MOTION_SIZE + self.n

    @property
    def equations(self) -> int:
        """Rows of the constraints that are equations: first z, the dynamics."""
        return (self.stages + 1) * (MOTION_SIZE + self.n)

    @property
    def rows(self) -> int:
        """Of the constraints: the equations, then the walls."""
        return self.equations + self.stages * WALLS

    def thrust(self, stage: int) -> slice:
        """g of a stage."""
        begin = stage * self.block + MOTION_SIZE + self.n
        return slice(begin, begin + self.n)

    def turn(self, thrusters: Thrusters, length: float) -> tuple[Array, Array]:
        """Rows (2 m, size) of w and their largest values (2 m,): how far angles turn in a stage of length [s].

        The angle moves to the thrust by 1 - decay of its lag; that is within rate * length, both ways.
        """
        rows, room = [], []
        for k in thrusters.limited:
            reached = 1.0 - thrusters.decay(length)[k]
            for i in range(self.stages):
                row = np.zeros(self.size)
                row[self.thrust(i).start + k] = reached
                row[i * self.block + MOTION_SIZE + k] = -reached
                rows += [row, -row]
                room += [thrusters.rate[k] * length] * 2
        return np.array(rows).reshape(-1, self.size), np.array(room)

    def bounds(self, thrusters: Thrusters) -> tuple[Array, Array]:
        """Lowest and highest w."""
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        for k in range(self.stages):
            low[self.thrust(k)], high[self.thrust(k)] = thrusters.lowest, thrusters.highest
            low[(k + 1) * self.block - 1] = 0.0
        return low, high


def step_function(
    model: Model, thrusters: Thrusters, grid: Grid, weights: Weights, walls: Array
) -> "casadi.Function":
    """(w, off) from w, z now, reference, last thrust, disturbance.

    walls: (4,) highest x, -x, y, -y [m] of the boat's origin; infinite without a wall.
    Reference (6, stages): eta and nu at the stages' ends, its headings continuous with that of z. off (2,): of
    the quadratic programme, the constraint violation and the duality gap. Headings of w stay continuous where
    that of z passes pi.
    The function is named `seatrial_nmpc`; C code can be generated from it.
    """
    ca = casadi_module()
    layout = Layout(len(thrusters.lag), grid.stages)
    n = layout.n
    sizes: dict[str, tuple[int, ...]] = {
        "w": (layout.size,),
        "z": (MOTION_SIZE + n,),
        "reference": (MOTION_SIZE, grid.stages),
        "last": (n,),
        "disturbance": (3,),
    }
    given = [ca.MX.sym(name, *size) for name, size in sizes.items()]
    w, z, reference, *rest = given
    # a full turn from the last plan, z would be far from where that is linearised
    turns = 2.0 * ca.pi * ca.floor((w[2] - z[2]) / (2.0 * ca.pi) + 0.5)
    z = ca.vertcat(z[:2], z[2] + turns, z[3:])
    reference = ca.vertcat(reference[:2, :], reference[2, :] + turns, reference[3:, :])
    hessian, gradient, jacobian, value = _linearised(model, thrusters, grid, weights, layout)(
        w, z, reference, *rest
    )
    below, room = _inequalities(thrusters, grid, layout, walls, (w, jacobian, value))
    equal = layout.equations
    programme = hessian, gradient, jacobian[:equal, :], -value[:equal], below, room
    by, off = minimum(programme, START_MULTIPLIER * weights.price(grid.stages))
    step: casadi.Function = ca.Function(
        "seatrial_nmpc", given, [w + by, off], list(sizes), ["new_w", "off"]
    )
    return step


def _inequalities(
    thrusters: Thrusters,
    grid: Grid,
    layout: Layout,
    walls: Array,
    at: tuple[Symbol, Symbol, Symbol],
) -> tuple[Symbol, Symbol]:
    """Rows, and room that steps of w have along them: bounds of w, rates of angles, walls.

    at: w, and of the constraints there the Jacobian and the values.
    """
    ca = casadi_module()
    w, jacobian, value = at
    low, high = layout.bounds(thrusters)
    wall_limits = np.tile(walls, grid.stages)
    lower, upper, kept = (
        np.flatnonzero(np.isfinite(row)).tolist() for row in (low, high, wall_limits)
    )
    wall = [layout.equations + i for i in kept]
    box = ca.sparsify(
        ca.vertcat(-ca.DM.eye(layout.size)[lower, :], ca.DM.eye(layout.size)[upper, :])
    )
    turn, most = layout.turn(thrusters, grid.length)
    turn = ca.sparsify(ca.DM(turn))
    below = ca.vertcat(box, turn, jacobian[wall, :])
    room = ca.vertcat(
        w[lower] - low[lower], high[upper] - w[upper], most - turn @ w,
        wall_limits[kept] - value[wall],
    )  # fmt: skip
    return below, room


def _linearised(
    model: Model, thrusters: Thrusters, grid: Grid, weights: Weights, layout: Layout
) -> "casadi.Function":
    """Hessian, gradient, Jacobian and value of the rows at w."""
    ca = casadi_module()
    n, forward = layout.n, stage(model, thrusters, grid)
    z = [ca.SX.sym(f"z{k}", MOTION_SIZE + n) for k in range(grid.stages + 1)]
    g = [ca.SX.sym(f"g{k}", n) for k in range(grid.stages)]
    s = [ca.SX.sym(f"s{k}") for k in range(grid.stages)]
    now, last, disturbance = (
        ca.SX.sym("now", MOTION_SIZE + n),
        ca.SX.sym("last", n),
        ca.SX.sym("d", 3),
    )
    reference = ca.SX.sym("reference", MOTION_SIZE, grid.stages)
    unit = ca.DM(thrusters.unit)

    dynamics, walls, errors = [z[0] - now], [], []
    for k in range(grid.stages):
        dynamics.append(z[k + 1] - forward(z[k], g[k], disturbance))
        x, y = z[k + 1][0], z[k + 1][1]
        walls += [x - s[k], -x - s[k], y - s[k], -y - s[k]]
        errors += _errors(z[k + 1], reference[:, k], weights)
        errors.append(weights.thrust * (g[k] - ca.DM(thrusters.idle)) / unit)
        errors.append(weights.change * (g[k] - (g[k - 1] if k else last)) / unit)
    w = ca.vertcat(*(part for k in range(grid.stages) for part in (z[k], g[k], s[k])), z[-1])
    residual = ca.vertcat(*errors)
    rows = ca.vertcat(*dynamics, *walls)
    slope = ca.jacobian(residual, w)
    hessian = slope.T @ slope + HESSIAN_REGULARISATION * ca.SX.eye(layout.size)
    gradient = slope.T @ residual + ca.gradient(
        weights.price(grid.stages) * ca.sum(ca.vertcat(*s)), w
    )
    jacobian = ca.jacobian(rows, w)
    found: casadi.Function = ca.Function(
        "linear", [w, now, reference, last, disturbance], [hessian, gradient, jacobian, rows]
    )
    return found


def _errors(z: Symbol, reference: Symbol, weights: Weights) -> list[Symbol]:
    """Weighted errors of pose and velocity at a stage's end; the position's along and across the path."""
    ca = casadi_module()
    off = z[:2] - reference[:2]
    if weights.along == weights.position:  # whatever the path's direction
        position = [weights.position * off]
    else:
        c, s = ca.cos(reference[2]), ca.sin(reference[2])
        position = [
            weights.along * (c * off[0] + s * off[1]),
            weights.position * (c * off[1] - s * off[0]),
        ]
    speed = z[POSE_SIZE:MOTION_SIZE] - reference[POSE_SIZE:MOTION_SIZE]
    return [
        *position,
        weights.heading * (z[2] - reference[2]),
        weights.velocity * speed[0],
        weights.sway * speed[1],
        weights.yaw_rate * speed[2],
    ]
