# SPDX-License-Identifier: MIT
"""Residual analysis: correlation of a model's innovations with its generalised forces.

With the right model and noise the innovations are white and uncorrelated with the inputs (Ljung,
section 16.6). A correlation with a past force indicates a missing term or a wrong delay.
"""

from collections.abc import Iterable
from statistics import NormalDist

import msgspec
import numpy as np

from seatrial.boat.model import Model
from seatrial.evaluation.filtering import Filtered
from seatrial.recording.recording import Recording
from seatrial.util.frames import AXES, SYMBOLS, Array
from seatrial.util.statistics import (
    NORMAL_95,
    autocorrelation,
    bartlett_band,
    cross_correlation,
    white_band,
)

REACH = 2.0  # [s] largest lag in both directions
ENOUGH = 10.0 * REACH  # [s] of innovations: with fewer, chance dominates at large lags
WHITENING, RIDGE = 20, 1e-6  # lags of the autoregression of a force
LEAK = 0.5  # of the largest value at positive lags; a larger one at negative lags is no leakage
MOST_LAGS = 400  # in each direction; at higher pose rates lags are coarser than poses


class Correlation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """Correlation of one residual with one force, over lags."""

    residual: str  # u, v or r: the innovation in surge, sway or yaw
    force: str
    step: float  # [s] from lag to lag; the first is minus `REACH`
    values: list[float]  # at positive lags the residual follows the force
    band: float  # 95 % at one lag, for independent signals
    limit: float  # 95 % for all lags, residuals and forces together (Bonferroni)
    found: bool  # the peak is beyond the limit
    peak: float  # the largest value; at a negative lag only if the force clearly follows
    lag: float  # [s] of the peak


def residuals(model: Model, recording: Recording, filtered: Filtered) -> list[Correlation]:
    """Correlation of every innovation of the model's filter with every generalised force."""
    # 1. Innovations and forces on one regular grid.
    step = max(recording.period, REACH / MOST_LAGS)
    index = np.rint(recording.t / step).astype(np.int64)
    grid = np.arange(index[-1] + 1)
    errors = np.full((len(grid), 3), np.nan)
    errors[index] = filtered.residual
    forces = np.asarray(model.trace(recording).forces(grid * step))
    if np.isfinite(errors).all(axis=1).sum() * step < ENOUGH:
        return []
    # 2. Correlations with the forces, and with their whitened parts (no smearing over lags).
    lags = round(REACH / step)
    found = cross_correlation(errors, forces, lags)
    sharp = cross_correlation(errors, np.column_stack([_whitened(f) for f in forces.T]), lags)
    # 3. Bands: of one lag, and of all lags and pairs together.
    band = _band(errors, forces)
    names = [force.name for force in model.vehicle.forces]
    tests = 3 * len(names) * (2 * lags + 1)
    widening = NormalDist().inv_cdf(1.0 - 0.025 / tests) / NORMAL_95  # Bonferroni
    clear = widening * white_band(int(np.isfinite(errors[:, 0]).sum()))
    return [
        _correlation(
            (symbol, name),
            step,
            found[:, axis, i],
            sharp[:, axis, i] / clear,
            band[axis, i] * np.array([1.0, widening]),
        )
        for axis, symbol in enumerate(SYMBOLS)
        for i, name in enumerate(names)
        if np.ptp(forces[:, i]) > 0.0
    ]


def _band(errors: Array, forces: Array) -> Array:
    """95 % band (3, forces), from the autocorrelations of innovations and forces."""
    there = np.flatnonzero(np.isfinite(errors).all(axis=1))
    reach = len(errors) // 4
    rho = autocorrelation(errors[there], there, reach)
    return bartlett_band(
        rho, autocorrelation(forces, np.arange(len(forces)), len(rho) - 1), len(there)
    )


def _correlation(
    names: tuple[str, str], step: float, values: Array, sharp: Array, bands: Array
) -> Correlation:
    """A correlation; its peak is at a negative lag only if the whitened force clearly follows.

    Clearly: beyond 1 (the limit), and beyond `LEAK`, as imperfect whitening leaks to negative lags.
    """
    lags = len(values) // 2
    band, limit = bands.tolist()
    early = np.abs(sharp[:lags]).max() > max(1.0, LEAK * np.abs(sharp[lags:]).max())
    side = np.arange(lags) if early else np.arange(lags, 2 * lags + 1)
    at = int(side[np.argmax(np.abs(values[side]))])
    found = bool(abs(values[at]) > limit)
    return Correlation(
        *names, step, values.round(4).tolist(), band, limit, found, float(values[at]),
        (at - lags) * step,
    )  # fmt: skip


def _whitened(force: Array) -> Array:
    """A force minus its autoregression (Yule-Walker).

    A force is correlated in time, so a response correlates with its future, too. Its whitened part
    is not.
    """
    rho = autocorrelation(force, np.arange(len(force)), WHITENING)
    apart = np.abs(np.subtract.outer(np.arange(WHITENING), np.arange(WHITENING)))
    weights = np.linalg.solve(rho[apart] + RIDGE * np.eye(WHITENING), rho[1:])
    return np.convolve(force - force.mean(), np.append(1.0, -weights))[: len(force)]


def significant(found: Iterable[Correlation]) -> list[Correlation]:
    """Those beyond their limits, the strongest first."""
    return sorted((c for c in found if c.found), key=lambda c: -abs(c.peak) / c.limit)


def in_words(correlation: Correlation) -> str:
    """The correlation as a message: value, cause."""
    axis = AXES[SYMBOLS.index(correlation.residual)]
    peak, limit = correlation.peak, correlation.limit
    digits = next((d for d in (2, 3, 4) if round(abs(peak), d) != round(limit, d)), 5)
    size = f"{peak:+.{digits}f} (95 % limit {limit:.{digits}f})"
    if correlation.lag < 0:
        return (
            f"{correlation.force} follows residuals in {axis} after {-correlation.lag:.2f} s: correlation {size}: "
            "feedback by the operator, or a late clock of the commands"
        )
    own = correlation.force[-1] == correlation.residual
    or_else = (
        "a delay is wrong, or mass, thrust or drag has changed" if own else "or a delay is wrong"
    )
    return (
        f"residuals in {axis} follow {correlation.force} after {correlation.lag:.2f} s: correlation {size}: "
        f"a term is missing, {or_else}"
    )
