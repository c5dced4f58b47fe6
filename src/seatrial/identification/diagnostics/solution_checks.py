# SPDX-License-Identifier: MIT
"""What a solution itself shows: outliers, a poor prediction, parameters at a bound, no significant coefficient."""

from statistics import NormalDist

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.identification.likelihood.fit_horizon import prediction_findings
from seatrial.identification.likelihood.optimiser import Point, at_bounds, far_from_poses
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

SIGNIFICANCE_LEVEL = 0.05  # that any coefficient differs from zero by chance
REPORTED_OUTLIERS = 0.03  # share of the poses: false matches are usually rarer
REFUSED_OUTLIERS = 0.3  # share of the poses: then the model is wrong, not the poses


def solution_findings(at: Point, horizon: float, covariance: Array) -> list[Finding]:
    """What every solution is checked for. horizon: [s] of the fit; covariance: (p, p) of the free parameters.

    Raises IdentificationError where no model of this structure explains the poses.
    """
    findings = [*_outliers(at), *prediction_findings(at, horizon), *at_bound_findings(at)]
    if horizon:
        findings.append(finding_of(FindingKind.MODEL_MISMATCH, horizon=horizon))
    return [*findings, *_nothing_significant(at, covariance)]


def _outliers(at: Point) -> list[Finding]:
    """A finding on the share of outliers. Raises IdentificationError where it is too large for any model."""
    weights = np.concatenate([np.asarray(p.weight) for p in at.runs.by_recording])
    used = weights > 0.0
    share = float(np.mean(weights[used] < 1.0))
    if share > REFUSED_OUTLIERS or far_from_poses(at):
        rejected = f"{100 * share:.0f} % of the poses are rejected as outliers"
        raise IdentificationError(
            f"{rejected if share else 'the poses are nowhere near'}: no model of this structure "
            "explains them. Check the recordings with 'seatrial inspect', and the vehicle file's signs"
        )
    if share > REPORTED_OUTLIERS:
        return [finding_of(FindingKind.OUTLIERS, share=share)]
    return []


def at_bound_findings(at: Point) -> list[Finding]:
    """A finding on each parameter that ends at a bound."""
    problem, findings = at.runs.problem, []
    for i, low, high in np.column_stack([problem.free, *problem.bounds])[at_bounds(at)]:
        value = at.theta[int(i)]
        end = low if abs(value - low) < abs(value - high) else high
        findings.append(finding_of(FindingKind.AT_BOUND, problem.names[int(i)], bound=float(end)))
    return findings


def _nothing_significant(at: Point, covariance: Array) -> list[Finding]:
    """A finding if no coefficient differs from zero at the 5 % level, which is shared by all (Bonferroni)."""
    free = np.array(at.runs.problem.free)
    own = free < at.runs.problem.n_coefficients
    limit = NormalDist().inv_cdf(1.0 - 0.5 * SIGNIFICANCE_LEVEL / max(int(own.sum()), 1))
    significant = np.abs(at.theta[free]) > limit * np.sqrt(np.diag(covariance))
    if not own.any() or significant[own].any():
        return []
    return [finding_of(FindingKind.NO_SIGNIFICANT_COEFFICIENT)]
