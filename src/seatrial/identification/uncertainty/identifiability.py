# SPDX-License-Identifier: MIT
"""What a model's recordings say about each of its parameters, and what only about some together."""

from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.identification.uncertainty.combinations import (
    APART,
    TOGETHER,
    Combination,
    Known,
    combinations,
)
from seatrial.identification.uncertainty.parameter_verdict import (
    SHARP,
    Finding,
    Verdict,
    finding,
    full_thrust,
)
from seatrial.util.frames import Array

__all__ = [
    "APART", "SHARP", "TOGETHER", "Combination", "Finding", "Identifiability", "Verdict", "condition",
    "full_thrust", "identifiability",
]  # fmt: skip


@dataclass(frozen=True)
class Identifiability:
    """Verdicts, and the correlations of all that was estimated."""

    findings: tuple[Finding, ...]
    names: tuple[str, ...]  # (p,) of what was estimated
    correlation: Array  # (p, p)
    condition: float  # of the correlation matrix; 1 without correlations
    combinations: tuple[Combination, ...]

    def __getitem__(self, name: str) -> Finding:
        return next(found for found in self.findings if found.name == name)


def identifiability(model: Model) -> Identifiability:
    """Verdicts from a model's covariance, in words, with the combinations that are known better."""
    values = np.concatenate([model.coefficients, model.constants])
    errors = np.sqrt(np.diag(model.covariance))
    sought = np.flatnonzero(errors > 0)
    names = tuple(model.parameters[i] for i in sought)
    matrix = model.covariance[np.ix_(sought, sought)]
    correlation = matrix / np.outer(errors[sought], errors[sought])
    findings = [finding(model, name, names, correlation) for name in model.parameters]
    known = Known(model, names, values[sought], matrix, {f.name: f for f in findings})
    return Identifiability(
        tuple(findings), names, correlation, condition(correlation), combinations(known)
    )


def condition(correlation: Array) -> float:
    """Largest over smallest eigenvalue of a correlation matrix (p, p); infinite if singular."""
    if not correlation.size:
        return 1.0
    spectrum = np.linalg.eigvalsh(correlation)
    return float(spectrum[-1] / spectrum[0]) if spectrum[0] > 1e-12 * spectrum[-1] else np.inf
