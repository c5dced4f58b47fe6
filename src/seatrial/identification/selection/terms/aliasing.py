# SPDX-License-Identifier: MIT
"""Exact aliases: terms that are linear combinations of others for any data.

N_ud u_dot, with u_dot = v r + X_u u + X_uu |u| u + X_F F_u put in, is a combination of v r, u,
|u| u and F_u: with all of these in the yaw equation one of the five is too many.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.structure import Force, Structure, Term
from seatrial.util.frames import Array

ALIAS_SAMPLES = 400  # random states and forces: ten times the columns of the largest structure
ALIAS_TOLERANCE = 1e-8  # relative remainder of a column that others reproduce


@dataclass(frozen=True)
class Alias:
    """A coefficient that no data can separate from others."""

    coefficient: str
    made_by: tuple[str, ...]  # coefficients whose terms add up to its term


def aliases(
    own: Sequence[Term], candidates: Sequence[Term], forces: Sequence[Force]
) -> tuple[Alias, ...]:
    """Exact linear dependencies among the free terms of every axis, own terms first.

    Of terms that depend on each other the last one is the alias. Accelerations are those of the structure
    itself, with random coefficients.
    """
    rng = np.random.default_rng(0)
    base = Structure("own", tuple(own), tuple(forces))
    nu = rng.normal(size=(ALIAS_SAMPLES, 3))
    force = rng.normal(size=(ALIAS_SAMPLES, len(forces)))
    theta = rng.uniform(0.2, 0.8, len(base.coefficients))  # none near 0, none dominates
    nu_dot = _core.accelerations(base.compiled, theta, nu, force)
    found = []
    for axis in range(3):
        terms = [t for t in (*own, *candidates) if t.axis == axis and t.coefficient]
        if terms:
            names, columns = _columns(terms, forces, nu, nu_dot, force)
            found += _dependent(names, columns)
    return tuple(found)


def _columns(
    terms: Sequence[Term], forces: Sequence[Force], nu: Array, nu_dot: Array, force: Array
) -> tuple[list[str], Array]:
    """Coefficients of one axis and their columns (samples, coefficients), of length 1."""
    parts = Structure("axis", tuple(terms), tuple(forces))
    each = _core.regressors(parts.compiled, nu, nu_dot, force)
    names = list(dict.fromkeys(str(t.coefficient) for t in terms))
    columns = np.zeros((len(nu), len(names)))
    for term, column in zip(terms, each.T, strict=True):
        columns[:, names.index(str(term.coefficient))] += column
    return names, np.asarray(columns / np.linalg.norm(columns, axis=0))


def _dependent(names: list[str], columns: Array) -> list[Alias]:
    kept: list[int] = []
    found = []
    for j, name in enumerate(names):
        weights = np.linalg.lstsq(columns[:, kept], columns[:, j], rcond=None)[0]
        left = columns[:, j] - columns[:, kept] @ weights
        if kept and np.linalg.norm(left) < ALIAS_TOLERANCE:
            shares = [
                names[k] for k, w in zip(kept, weights, strict=True) if abs(w) > ALIAS_TOLERANCE
            ]
            found.append(Alias(name, tuple(shares)))
        else:
            kept.append(j)
    return found
