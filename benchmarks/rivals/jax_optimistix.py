# SPDX-License-Identifier: MIT
"""JAX and optimistix: a scan as roll-out, forward derivatives, Levenberg-Marquardt, compiled."""

import time

import jax
import jax.numpy as jnp
import optimistix as optx
from jax import lax

from rivals.problem import Problem, Solution

jax.config.update("jax_enable_x64", True)
Parameters = tuple[jax.Array, jax.Array]  # theta (11,), initial states (R, 6)


def rate(theta: jax.Array, x: jax.Array, F: jax.Array) -> jax.Array:
    """x_dot (6,), Eqs. (1) and (12)."""
    X_u, X_uu, X_F, Y_v, Y_vv, Y_F, N_ud, N_r, N_rr, N_uu, N_F = theta
    _, _, psi, u, v, r = x
    c, s = jnp.cos(psi), jnp.sin(psi)
    du = v * r + (X_u + X_uu * jnp.abs(u)) * u + X_F * F[0]
    dv = -u * r + (Y_v + Y_vv * jnp.abs(v)) * v + Y_F * F[1]
    dr = N_ud * du + (N_r + N_rr * jnp.abs(r)) * r + N_uu * jnp.abs(u) * u + N_F * F[2]
    return jnp.stack([c * u - s * v, s * u + c * v, r, du, dv, dr])


def roll_out(theta: jax.Array, x: jax.Array, h: jax.Array, force: jax.Array) -> jax.Array:
    """Poses (n, 3) of one recording; h (n - 1, steps), force (n - 1, steps, 3, 3)."""

    def step(x: jax.Array, h: jax.Array, F: jax.Array) -> jax.Array:
        begin, middle, end = F
        k1 = rate(theta, x, begin)
        k2 = rate(theta, x + 0.5 * h * k1, middle)
        k3 = rate(theta, x + 0.5 * h * k2, middle)
        k4 = rate(theta, x + h * k3, end)
        return x + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)

    def interval(x: jax.Array, given: Parameters) -> tuple[jax.Array, jax.Array]:
        for one in zip(*given, strict=True):  # unrolled
            x = step(x, *one)
        return x, x[:3]

    poses = lax.scan(interval, x, (h, force))[1]
    return jnp.concatenate([x[None, :3], poses])


def residuals(p: Parameters, problem: dict[str, jax.Array]) -> tuple[jax.Array, jax.Array]:
    """Of the poses, and of the initial states."""
    theta, x = p
    poses = jax.vmap(roll_out, (None, 0, 0, 0))(theta, x, problem["h"], problem["force"])
    return (
        (poses - problem["eta"]) / problem["noise"],
        (x - problem["initial"]) / problem["spread"],
    )


@jax.jit
def minimise(problem: dict[str, jax.Array]) -> tuple[jax.Array, jax.Array]:
    """Coefficients, and the steps that it took."""
    solver = optx.LevenbergMarquardt(rtol=1e-6, atol=1e-6)
    start = (problem["theta"], problem["initial"])
    found = optx.least_squares(
        residuals, solver, start, problem, options={"jac": "fwd"}, max_steps=200
    )
    return found.value[0], found.stats["num_steps"]


def solve(problem: Problem) -> Solution:
    """Compiled, then run; the time of the first is told apart."""
    given = {name: jnp.asarray(value) for name, value in vars(problem).items()}
    begin = time.perf_counter()
    compiled = minimise.lower(given).compile()
    compiling = time.perf_counter() - begin
    theta, steps = compiled(given)
    return Solution(jax.device_get(theta), int(steps), compiling)
