# SPDX-License-Identifier: MIT
"""One step of the controller as a CasADi function, that Python calls and C is generated from."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from seatrial.export.casadi import Symbol, casadi_module
from seatrial.frames import Array
from seatrial.model import Model
from seatrial.mpc.problem import MOTION, PATH, POSE, Grid, Weights, stage
from seatrial.mpc.thrusters import Thrusters

if TYPE_CHECKING:
    import casadi

WALLS = 4  # x and y, both ways
QUIET = {"print_iter": False, "print_header": False, "print_info": False, "error_on_fail": False}


@dataclass(frozen=True)
class Layout:
    """Where what stands in the variables w: stage by stage z, g, s; at the end the last z."""

    n: int  # thrusters
    stages: int

    @property
    def block(self) -> int:
        """Of one stage."""
        return MOTION + 2 * self.n + 1

    @property
    def size(self) -> int:
        """Of w."""
        return self.stages * self.block + MOTION + self.n

    @property
    def rows(self) -> int:
        """Of the constraints: first z, the dynamics, the walls."""
        return (self.stages + 1) * (MOTION + self.n) + self.stages * WALLS

    def thrust(self, stage: int) -> slice:
        """g of a stage."""
        begin = stage * self.block + MOTION + self.n
        return slice(begin, begin + self.n)

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
    """(w, duals of w, duals of the rows) from these, z now, reference, last thrust, disturbance.

    walls: (4,) highest x, -x, y, -y [m] of the boat's origin; infinite where there is none.
    Reference (6, stages): eta and nu at the stages' ends, headings without leaps. The function is
    named `seatrial_nmpc`; its solver is CasADi's qrqp, of which C can be generated.
    """
    ca = casadi_module()
    layout = Layout(len(thrusters.lag), grid.stages)
    linear, hessian, jacobian = _linearised(model, thrusters, grid, weights, layout)
    programme = ca.conic("programme", "qrqp", {"h": hessian, "a": jacobian}, QUIET)
    names = ["w", "dual_w", "dual_rows", "z", "reference", "last", "disturbance"]
    n = layout.n
    given = [
        ca.MX.sym(name, *size)
        for name, size in zip(
            names,
            [(layout.size,), (layout.size,), (layout.rows,), (MOTION + n,), (MOTION, grid.stages), (n,), (3,)],
            strict=True,
        )
    ]  # fmt: skip
    w = given[0]
    h, gradient, rows, value = linear(w, *given[3:])
    low, high = layout.bounds(thrusters)
    equal = layout.rows - WALLS * grid.stages
    floor = np.concatenate([np.zeros(equal), np.full(WALLS * grid.stages, -np.inf)])
    roof = np.concatenate([np.zeros(equal), np.tile(walls, grid.stages)])
    found = programme(
        h=h, g=gradient, a=rows,
        lbx=ca.DM(low) - w, ubx=ca.DM(high) - w, lba=ca.DM(floor) - value, uba=ca.DM(roof) - value,
        x0=0, lam_x0=given[1], lam_a0=given[2],
    )  # fmt: skip
    step: casadi.Function = ca.Function(
        "seatrial_nmpc", given, [w + found["x"], found["lam_x"], found["lam_a"]],
        names, ["new_w", "new_dual_w", "new_dual_rows"],
    )  # fmt: skip
    return step


def _linearised(
    model: Model, thrusters: Thrusters, grid: Grid, weights: Weights, layout: Layout
) -> tuple["casadi.Function", "casadi.Sparsity", "casadi.Sparsity"]:
    """Hessian, gradient, Jacobian and value of the rows at w; patterns of the two matrices."""
    ca = casadi_module()
    n, forward = layout.n, stage(model, thrusters, grid)
    z = [ca.SX.sym(f"z{k}", MOTION + n) for k in range(grid.stages + 1)]
    g = [ca.SX.sym(f"g{k}", n) for k in range(grid.stages)]
    s = [ca.SX.sym(f"s{k}") for k in range(grid.stages)]
    now, last, disturbance = ca.SX.sym("now", MOTION + n), ca.SX.sym("last", n), ca.SX.sym("d", 3)
    reference = ca.SX.sym("reference", MOTION, grid.stages)

    dynamics, walls, errors = [z[0] - now], [], []
    for k in range(grid.stages):
        dynamics.append(z[k + 1] - forward(z[k], g[k], disturbance))
        x, y = z[k + 1][0], z[k + 1][1]
        walls += [x - s[k], -x - s[k], y - s[k], -y - s[k]]
        errors += _errors(z[k + 1], reference[:, k], weights)
        errors.append(weights.thrust * (g[k] - ca.DM(thrusters.idle)))
        errors.append(weights.change * (g[k] - (g[k - 1] if k else last)))
    w = ca.vertcat(*(part for k in range(grid.stages) for part in (z[k], g[k], s[k])), z[-1])
    residual = ca.vertcat(*errors)
    rows = ca.vertcat(*dynamics, *walls)
    slope = ca.jacobian(residual, w)
    hessian = slope.T @ slope + PATH * ca.SX.eye(layout.size)
    gradient = slope.T @ residual + ca.gradient(
        weights.price(grid.stages) * ca.sum(ca.vertcat(*s)), w
    )
    jacobian = ca.jacobian(rows, w)
    function = ca.Function(
        "linear", [w, now, reference, last, disturbance], [hessian, gradient, jacobian, rows]
    )
    return function, hessian.sparsity(), jacobian.sparsity()


def _errors(z: Symbol, reference: Symbol, weights: Weights) -> list[Symbol]:
    """Weighted errors of pose and velocity at a stage's end."""
    return [
        weights.position * (z[:2] - reference[:2]),
        weights.heading * (z[2] - reference[2]),
        weights.velocity * (z[POSE : POSE + 2] - reference[POSE : POSE + 2]),
        weights.yaw_rate * (z[POSE + 2] - reference[POSE + 2]),
    ]
