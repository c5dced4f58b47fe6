# SPDX-License-Identifier: MIT
"""Identifiability: how well each parameter is known, and which combinations are better known."""

from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.identification.uncertainty.combinations import (
    CORRELATED,
    INSEPARABLE,
    Combination,
    Estimates,
    combinations,
)
from seatrial.identification.uncertainty.parameter_verdict import (
    SHARP_ERROR,
    ParameterAccuracy,
    ParameterVerdict,
    full_thrust,
    parameter_accuracy,
    reach_text,
)
from seatrial.util.frames import Array

__all__ = [
    "CORRELATED",
    "INSEPARABLE",
    "SHARP_ERROR",
    "Combination",
    "Identifiability",
    "ParameterAccuracy",
    "ParameterVerdict",
    "condition",
    "full_thrust",
    "identifiability",
    "reach_text",
]  # fmt: skip


SINGULAR_EIGENVALUE = 1e-12  # of the largest: a correlation matrix is singular below it


@dataclass(frozen=True)
class Identifiability:
    """Verdicts, and the correlations of the estimated parameters."""

    findings: tuple[ParameterAccuracy, ...]
    names: tuple[str, ...]  # (p,) of what was estimated
    correlation: Array  # (p, p)
    condition: float  # of the correlation matrix; 1 without correlations
    combinations: tuple[Combination, ...]

    def __getitem__(self, name: str) -> ParameterAccuracy:
        return next(found for found in self.findings if found.name == name)


def identifiability(model: Model) -> Identifiability:
    """Verdicts from a model's covariance, with the combinations that are better known."""
    values = np.concatenate([model.coefficients, model.constants])
    errors = np.sqrt(np.diag(model.covariance))
    sought = np.flatnonzero(errors > 0)
    names = tuple(model.parameters[i] for i in sought)
    matrix = model.covariance[np.ix_(sought, sought)]
    correlation = matrix / np.outer(errors[sought], errors[sought])
    findings = [parameter_accuracy(model, name, names, correlation) for name in model.parameters]
    known = Estimates(model, names, values[sought], matrix, {f.name: f for f in findings})
    return Identifiability(
        tuple(findings), names, correlation, condition(correlation), combinations(known)
    )


def condition(correlation: Array) -> float:
    """Largest over smallest eigenvalue of a correlation matrix (p, p); infinite if singular."""
    if not correlation.size:
        return 1.0
    spectrum = np.linalg.eigvalsh(correlation)
    return (
        float(spectrum[-1] / spectrum[0])
        if spectrum[0] > SINGULAR_EIGENVALUE * spectrum[-1]
        else np.inf
    )
