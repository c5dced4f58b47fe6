# SPDX-License-Identifier: MIT
"""Estimates of a boat, as if they came from recordings."""

from dataclasses import replace

import numpy as np
from conftest import make_model


def estimated(vehicle, values, random=None, size=0.02):
    """A model whose errors of `size` are correlated, drawn from them by a generator or seed if there is one."""
    model = make_model(vehicle, values)
    n = len(model.coefficients)
    root = np.linalg.cholesky(0.5 * np.eye(n) + 0.5) * size * np.abs(model.coefficients)[:, None]
    off = 0.0 if random is None else root @ np.random.default_rng(random).normal(size=n)
    return replace(model, coefficients=model.coefficients + off, covariance=root @ root.T)
