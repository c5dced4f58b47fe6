# SPDX-License-Identifier: MIT
"""Quadratic minimisation within a box."""

import numpy as np

from seatrial.util.frames import Array

BOX_STEPS_PER_PARAMETER = 4  # of the active-set solver, at most


def box_minimum(matrix: Array, linear: Array, low: Array, high: Array) -> Array:
    """The minimum (p,) of x' M x / 2 - b' x in a box around 0.

    matrix: M (p, p), positive definite; linear: b (p,); low, high: (p,). Active sets: Nocedal and Wright,
    Numerical Optimization, 2nd ed., algorithm 16.3.
    """
    x = np.clip(np.zeros(len(linear)), low, high)
    held = np.zeros(len(linear), dtype=bool)
    for _ in range(BOX_STEPS_PER_PARAMETER * len(linear)):
        # minimum over the variables that are not held at a bound
        go = np.flatnonzero(~held)
        to = x.copy()
        rest = linear[go] - matrix[np.ix_(go, held)] @ x[held]
        to[go] = np.linalg.solve(matrix[np.ix_(go, go)], rest)
        # outside the box: only as far as the first bound, which then holds its variable
        edge = np.clip(to, low, high)
        beyond = go[edge[go] != to[go]]
        if len(beyond):
            shares = (edge - x)[beyond] / (to - x)[beyond]
            first = beyond[int(np.argmin(shares))]
            x += float(shares.min()) * (to - x)
            x[first], held[first] = edge[first], True
            continue
        # inside: release the held variable with the steepest way down into the box
        x = to
        slope = linear - matrix @ x
        back = held & (low < high) & np.where(x <= low, slope > 0.0, slope < 0.0)
        if not back.any():
            break
        held[int(np.argmax(np.where(back, np.abs(slope), 0.0)))] = False
    return x
