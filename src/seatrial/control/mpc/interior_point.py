# SPDX-License-Identifier: MIT
"""A convex quadratic programme by Mehrotra's interior-point method, as CasADi functions.

min x'H x / 2 + g'x with A x = b and C x <= d. Of CasADi's own solvers C can be generated of one only,
qrqp, and that gives up where a plan runs along a wall. Nocedal and Wright, Numerical Optimization, 16.6,
with the equalities regularised as in a proximal method: the matrix is quasi-definite then, and its LDL'
needs no pivots (Vanderbei, 1995). The number of iterations is fixed, so that every call takes as long.
"""

from typing import TYPE_CHECKING

from seatrial.export.casadi import Symbol, casadi_module

if TYPE_CHECKING:
    import casadi

ITERATIONS = 24
SOFT = 1e-9  # of the equalities: what a multiplier's step costs
BACK = 0.99  # of the way to the nearest bound
SLACK = 0.05  # from every bound at the begin, at least
FAST = 1e-9  # share that a y or z falls by which is none
CLOSED = 1e-5  # mean product of slack and multiplier that is taken for none


def minimum(programme: "tuple[Symbol, ...]", start: float) -> tuple[Symbol, Symbol]:
    """x, and (2,) how far off: largest violation of a row; gap to the optimum, as cost.

    programme: H, g, A, b, C, d; only the patterns of the matrices are fixed. start: mean product
    of slack and multiplier at the begin, a hundredth of the largest multiplier or so.
    """
    ca = casadi_module()
    h, _, a, b, c, d = programme
    step = _iteration(h.sparsity(), a.sparsity(), c.sparsity())
    y = ca.fmax(d, SLACK)
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
    short = below @ x + y - d
    upper = hessian + below.T @ ca.diag(z / y) @ below
    matrix = ca.vertcat(ca.horzcat(upper, equal.T), ca.horzcat(equal, -SOFT * ca.MX.eye(n_equal)))

    def newton(product: Symbol) -> tuple[Symbol, ...]:
        """The way to where y z is `product` less."""
        pull = z + (z * short - product) / y
        right = ca.vertcat(hessian @ x + g + equal.T @ nu + below.T @ pull, equal @ x - b)
        both = ca.solve(matrix, -right, "ldl")
        dy = -short - below @ both[:n]
        return both[:n], both[n:], dy, -(product + z * dy) / y

    def room(dy: Symbol, dz: Symbol) -> Symbol:
        """How often the way can be gone until a y or z is 0."""
        return 1 / ca.fmax(ca.mmax(ca.vertcat(-dy / y, -dz / z)), FAST)

    _, _, dy, dz = newton(y * z)
    share = ca.fmin(1, room(dy, dz))
    left = ca.dot(y + share * dy, z + share * dz) / n_below
    way = newton(y * z + dy * dz - (left / mean) ** 3 * mean)
    share = ca.if_else(mean > CLOSED, ca.fmin(1, BACK * room(*way[2:])), 0)
    moved = [at + share * by for at, by in zip((x, nu, y, z), way, strict=True)]
    found: casadi.Function = ca.Function(
        "iteration", [x, nu, y, z, hessian, g, equal, b, below, d], moved
    )
    return found
