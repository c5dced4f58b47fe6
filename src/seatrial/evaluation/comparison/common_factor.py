# SPDX-License-Identifier: MIT
"""The common factor of two correlated estimates of an axis' coefficients.

The errors of one estimate share a factor themselves: short or disturbed recordings determine ratios of
coefficients (top speeds) far better than their scale. A covariance that is held at the estimate then
draws a poorly known scale towards 0 ("Peelle's pertinent puzzle", D'Agostini). Here scale and ratios are
apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.util.distributions import chi2_sf
from seatrial.util.frames import Array
from seatrial.util.statistics import inverse_of

# of the search for the ratios; relative step that ends it
ROUNDS, HALVINGS, SETTLED = 50, 20, 1e-10
LEAST_SINGULAR_VALUE = 1e-9  # of the ratios' Jacobian, which has no information on their scale


@dataclass(frozen=True)
class CommonFactor:
    """Estimate B over estimate A."""

    factor: float
    error: float
    z: float  # distance from 1 in standard errors, of the logarithm
    fits: float  # p of the hypothesis of one factor for all


@dataclass(frozen=True)
class ScaledEstimate:
    """Coefficients x (n,) = (1 + e) s + r: true ones s, a common relative error e, and other errors r.

    var(e) = 1 / (x' C^-1 x) is the most that the covariance C admits; the rest of C is that of r, in the
    plane w'r = 0 with w = C^-1 x / (x' C^-1 x).
    """

    values: Array
    root: Array  # (n, n) R with R'R = C^-1
    plane: Array  # (n,) w: w'x = 1, w's is the scale of s over that of x
    variance: float  # of e

    @classmethod
    def of(cls, values: Array, covariance: Array) -> "ScaledEstimate":
        """From an estimate and its covariance (n, n)."""
        information = inverse_of(covariance)
        root = np.asarray(np.linalg.cholesky(information).T)
        variance = float(1.0 / np.sum((root @ values) ** 2))
        return cls(values, root, np.asarray(variance * information @ values), variance)

    def residuals(self, ratios: Array) -> tuple[Array, Array]:
        """Weighted r (n,) for coefficients in these ratios (n,), and its Jacobian (n, n)."""
        scale = 1.0 / float(self.plane @ ratios)
        slopes = -scale * (np.eye(len(ratios)) - scale * np.outer(ratios, self.plane))
        return self.root @ (self.values - scale * ratios), self.root @ slopes


def common_factor(a: ScaledEstimate, b: ScaledEstimate) -> CommonFactor:
    """The factor between two independent estimates, its error, and a test whether one factor fits all."""
    # 1. The ratios that both share, by Gauss-Newton from the likelier of the two estimates.
    both = (a, b)
    ratios = min((a.values, b.values), key=lambda start: _cost(both, start))
    unit = np.maximum(np.abs(a.values), np.abs(b.values))
    for _ in range(ROUNDS):
        residuals, slopes = _stacked(both, ratios)
        step = -unit * (_pseudo_inverse(slopes * unit) @ residuals)
        ratios, moved = _shortened(both, ratios, step)
        if moved * np.max(np.abs(step / unit)) < SETTLED * np.max(np.abs(ratios / unit)):
            break
    # 2. With them, each estimate's scale; the errors of both scales and of the ratios.
    residuals, slopes = _stacked(both, ratios)
    scales = a.plane @ ratios, b.plane @ ratios
    factor = float(scales[0] / scales[1])
    gradient = unit * (a.plane / scales[0] - b.plane / scales[1])
    through = gradient @ _pseudo_inverse(slopes * unit)
    relative = float(np.sqrt(a.variance + b.variance + through @ through))
    # 3. Two estimates of the ratios: n - 1 degrees of freedom are left for the test.
    freedom = len(ratios) - 1
    fits = chi2_sf(float(residuals @ residuals), freedom) if freedom else 1.0
    z = np.log(factor) / relative if factor > 0 else (factor - 1.0) / (abs(factor) * relative)
    return CommonFactor(factor, abs(factor) * relative, float(z), fits)


def _stacked(both: Sequence[ScaledEstimate], ratios: Array) -> tuple[Array, Array]:
    parts = [one.residuals(ratios) for one in both]
    return np.concatenate([r for r, _ in parts]), np.vstack([slopes for _, slopes in parts])


def _cost(both: Sequence[ScaledEstimate], ratios: Array) -> float:
    return sum(float(np.sum(one.residuals(ratios)[0] ** 2)) for one in both)


def _shortened(both: Sequence[ScaledEstimate], ratios: Array, step: Array) -> tuple[Array, float]:
    """After the step, halved until it lowers the cost; the share of it that was taken."""
    before, share = _cost(both, ratios), 1.0
    for _ in range(HALVINGS):
        if _cost(both, ratios + share * step) <= before:
            return ratios + share * step, share
        share /= 2.0
    return ratios, 0.0


def _pseudo_inverse(slopes: Array) -> Array:
    """(n, 2 n); the common scale of the ratios is free."""
    return np.asarray(np.linalg.pinv(slopes, rcond=LEAST_SINGULAR_VALUE))
