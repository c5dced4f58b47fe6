# SPDX-License-Identifier: MIT
"""CasADi and IPOPT: multiple shooting from pose to pose, exact Jacobian, Gauss-Newton Hessian."""

import time

import casadi as ca
import numpy as np

from rivals.problem import STEPS, Problem, Solution

COEFFICIENTS, STATES = 11, 6
# of MUMPS: as it comes its steps are so inaccurate here that IPOPT needs hundreds of them
ACCURATE = {"mumps_permuting_scaling": 0, "mumps_scaling": 8, "mumps_pivtol": 1e-3}


def rate(theta: ca.SX, x: ca.SX, F: ca.SX) -> ca.SX:
    """x_dot (6,), Eqs. (1) and (12)."""
    X_u, X_uu, X_F, Y_v, Y_vv, Y_F, N_ud, N_r, N_rr, N_uu, N_F = ca.vertsplit(theta)
    psi, u, v, r = ca.vertsplit(x[2:])
    du = v * r + (X_u + X_uu * ca.fabs(u)) * u + X_F * F[0]
    dv = -u * r + (Y_v + Y_vv * ca.fabs(v)) * v + Y_F * F[1]
    dr = N_ud * du + (N_r + N_rr * ca.fabs(r)) * r + N_uu * ca.fabs(u) * u + N_F * F[2]
    c, s = ca.cos(psi), ca.sin(psi)
    return ca.vertcat(c * u - s * v, s * u + c * v, r, du, dv, dr)


def interval() -> tuple[ca.Function, ca.Function]:
    """(x, theta, steps with their forces) -> x at the next pose; and its two Jacobians."""
    x, theta = ca.SX.sym("x", STATES), ca.SX.sym("theta", COEFFICIENTS)
    given = ca.SX.sym("given", 10, STEPS)
    end = x
    for one in ca.horzsplit(given):
        h, begin, middle, last = one[0], one[1:4], one[4:7], one[7:]
        k1 = rate(theta, end, begin)
        k2 = rate(theta, end + 0.5 * h * k1, middle)
        k3 = rate(theta, end + 0.5 * h * k2, middle)
        k4 = rate(theta, end + h * k3, last)
        end = end + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    slopes = [ca.jacobian(end, to) for to in (x, theta)]
    options = {"cse": True}
    return (
        ca.Function("interval", [x, theta, given], [end], options),
        ca.Function("slopes", [x, theta, given], slopes, options),
    )


def placed(to_x: ca.MX, to_theta: ca.MX, begin: np.ndarray, end: np.ndarray, size: int) -> ca.MX:
    """The constraints' sparse Jacobian; CasADi's own colouring takes ten times as long.

    Without structural zeros: with them, MUMPS loses the accuracy that IPOPT needs.
    """
    row_x, column_x = (np.array(a) for a in to_x.sparsity().get_triplet())
    row_theta, column_theta = (np.array(a) for a in to_theta.sparsity().get_triplet())
    k, j = column_x // STATES, column_x % STATES
    m, c = column_theta // COEFFICIENTS, column_theta % COEFFICIENTS
    own = np.arange(STATES * len(end))
    rows = np.concatenate([STATES * k + row_x, STATES * m + row_theta, own])
    following = COEFFICIENTS + STATES * np.repeat(end, STATES) + own % STATES
    columns = np.concatenate([COEFFICIENTS + STATES * begin[k] + j, c, following])
    pattern, order = ca.Sparsity.triplet(len(own), size, rows.tolist(), columns.tolist(), False)
    values = ca.vertcat(to_x.nz[:], to_theta.nz[:], ca.MX(-np.ones(len(own))))
    return ca.MX(pattern, values.nz[order])


def solve(problem: Problem) -> Solution:
    """IPOPT with its default linear solver; start: poses as measured, velocities as differences."""
    started = time.perf_counter()
    count, n = problem.eta.shape[:2]
    w = ca.MX.sym("w", COEFFICIENTS + STATES * n * count)
    theta, x = w[:COEFFICIENTS], ca.reshape(w[COEFFICIENTS:], STATES, n * count)
    nodes = np.arange(n * count).reshape(count, n)
    begin, end = nodes[:, :-1].ravel(), nodes[:, 1:].ravel()
    given = np.concatenate([problem.h.reshape(-1, 1), problem.force.reshape(-1, 9)], axis=1).T
    step, slopes = (f.map(f.name(), "serial", len(begin), [1], []) for f in interval())
    at = (x[:, begin.tolist()], theta, given)
    gap = ca.vec(step(*at) - x[:, end.tolist()])
    slope = placed(*slopes(*at), begin, end, w.shape[0])
    residual = ca.vertcat(
        ca.vec((x[:3, :] - problem.eta.reshape(-1, 3).T) / problem.noise),
        ca.vec((x[:, nodes[:, 0].tolist()] - problem.initial.T) / problem.spread),
    )
    J = ca.jacobian(residual, w)
    none, weight, multipliers = ca.MX.sym("p", 0), ca.MX.sym("f"), ca.MX.sym("g", gap.shape[0])
    hessian = ca.Function(
        "nlp_hess_l", [w, none, weight, multipliers], [weight * ca.triu(J.T @ J)],
        ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"],
    )  # fmt: skip
    jacobian = ca.Function("nlp_jac_g", [w, none], [gap, slope], ["x", "p"], ["g", "jac_g_x"])
    solver = ca.nlpsol(
        "solver", "ipopt", {"x": w, "f": 0.5 * ca.sumsqr(residual), "g": gap},
        {"hess_lag": hessian, "jac_g": jacobian, "print_time": False,
         "ipopt": {**ACCURATE, "print_level": 0, "sb": "yes", "tol": 1e-6, "max_iter": 100}},
    )  # fmt: skip
    states = np.concatenate([problem.eta, problem.nu], axis=2)
    built = time.perf_counter() - started
    found = solver(x0=np.concatenate([problem.theta, states.ravel()]), lbg=0.0, ubg=0.0)
    if not solver.stats()["success"]:
        raise SystemExit(f"IPOPT: {solver.stats()['return_status']}")
    return Solution(found["x"].full()[:COEFFICIENTS, 0], solver.stats()["iter_count"], built)
