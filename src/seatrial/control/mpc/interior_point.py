# SPDX-License-Identifier: MIT
"""A convex quadratic programme by Mehrotra's interior-point method, as CasADi functions.

min x'H x / 2 + g'x with A x = b and C x <= d. CasADi generates C code only of its solver qrqp, which
fails where a plan is along a wall. Nocedal and Wright, Numerical Optimization, 16.6, with the equalities
regularised as in a proximal method: the matrix is quasi-definite then, and its LDL' needs no pivots
(Vanderbei, 1995). The number of iterations is fixed, so that every call takes the same time.
"""

from typing import TYPE_CHECKING

from seatrial.export.casadi import Symbol, casadi_module

if TYPE_CHECKING:
    import casadi

ITERATIONS = 24
EQUALITY_REGULARISATION = 1e-9  # of the equalities: weight of a multiplier's step
STEP_FRACTION = 0.99  # of the step to the nearest bound
LEAST_SLACK = 0.05  # least initial distance from every bound
LEAST_DECREASE = 1e-9  # relative decrease of y or z below which it counts as none
CONVERGED_GAP = 1e-5  # mean product of slack and multiplier at which the iteration is converged


def minimum(programme: "tuple[Symbol, ...]", start: float) -> tuple[Symbol, Symbol]:
    """x, and (2,) its error: largest violation of a row; duality gap, as cost.

    programme: H, g, A, b, C, d; only the patterns of the matrices are fixed. start: mean product
    of slack and multiplier at the start, about a hundredth of the largest multiplier.
    """
    ca = casadi_module()
    h, _, a, b, c, d = programme
    step = _iteration(h.sparsity(), a.sparsity(), c.sparsity())
    y = ca.fmax(d, LEAST_SLACK)
    state = ca.MX.zeros(h.shape[0]), ca.MX.zeros(a.shape[0]), y, start / y
    for _ in range(ITERATIONS):
        state = step(*state, *programme)
    x, _, y, multiplier = state
    violation = ca.fmax(ca.norm_inf(a @ x - b), ca.mmax(c @ x - d))
    return x, ca.vertcat(ca.fmax(violation, 0), ca.dot(y, multiplier))


def _iteration(
    h: "casadi.Sparsity", a: "casadi.Sparsity", c: "casadi.Sparsity"
) -> "casadi.Function":
    """Next x, multipliers of the equalities, slacks, multipliers of the inequalities."""
    ca = casadi_module()
    hessian, equal, below = ca.MX.sym("h", h), ca.MX.sym("a", a), ca.MX.sym("c", c)
    (n, _), (n_equal, _), (n_below, _) = h.shape, a.shape, c.shape
    sizes = {"x": n, "nu": n_equal, "y": n_below, "z": n_below, "g": n, "b": n_equal, "d": n_below}
    x, nu, y, z, g, b, d = (ca.MX.sym(name, size) for name, size in sizes.items())
    mean = ca.dot(y, z) / n_below
    residual = below @ x + y - d
    upper = hessian + below.T @ ca.diag(z / y) @ below
    matrix = ca.vertcat(
        ca.horzcat(upper, equal.T), ca.horzcat(equal, -EQUALITY_REGULARISATION * ca.MX.eye(n_equal))
    )

    def newton(product: Symbol) -> tuple[Symbol, ...]:
        """The Newton step that reduces y z by `product`."""
        pull = z + (z * residual - product) / y
        right = ca.vertcat(hessian @ x + g + equal.T @ nu + below.T @ pull, equal @ x - b)
        both = ca.solve(matrix, -right, "ldl")
        dy = -residual - below @ both[:n]
        return both[:n], both[n:], dy, -(product + z * dy) / y

    def room(dy: Symbol, dz: Symbol) -> Symbol:
        """Multiple of the step at which a y or z is 0."""
        return 1 / ca.fmax(ca.mmax(ca.vertcat(-dy / y, -dz / z)), LEAST_DECREASE)

    _, _, dy, dz = newton(y * z)
    share = ca.fmin(1, room(dy, dz))
    remaining = ca.dot(y + share * dy, z + share * dz) / n_below
    direction = newton(y * z + dy * dz - (remaining / mean) ** 3 * mean)
    share = ca.if_else(mean > CONVERGED_GAP, ca.fmin(1, STEP_FRACTION * room(*direction[2:])), 0)
    moved = [at + share * by for at, by in zip((x, nu, y, z), direction, strict=True)]
    found: casadi.Function = ca.Function(
        "iteration", [x, nu, y, z, hessian, g, equal, b, below, d], moved
    )
    return found
