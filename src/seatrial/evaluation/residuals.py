# SPDX-License-Identifier: MIT
"""What the errors of a model still have to do with its inputs.

The errors of a filter's prediction from pose to pose are white and follow nothing if model and noise
are right (Ljung, section 16.6). If they follow a force, a term is missing or a
delay wrong.
"""

from statistics import NormalDist

import msgspec
import numpy as np

from seatrial.boat.model import Model
from seatrial.evaluation.filtering import Causal
from seatrial.recording.recording import Recording
from seatrial.util.frames import AXES, SYMBOLS, Array
from seatrial.util.statistics import (
    NORMAL_95,
    autocorrelation,
    bartlett_band,
    cross_correlation,
    white_band,
)

REACH = 2.0  # [s] lags to either side
ENOUGH = 10.0 * REACH  # [s] of residuals: of less, correlations over so many lags are chance
WHITENING, RIDGE = 20, 1e-6  # lags of the autoregression of a force
LEAK = 0.5  # of the largest value after a force, before it: more is no leak of the whitening
MOST_LAGS = 400  # to either side; at higher rates lags are further apart than poses


class Correlation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """Correlation of one residual with one force, over lags."""

    residual: str  # u, v or r: of the pose in surge, sway or yaw, a pose ahead
    force: str
    step: float  # [s] from lag to lag; the first is minus `REACH`
    values: list[float]  # at positive lags the residual follows the force
    band: float  # 95 %, at one lag, for signals that have nothing to do with each other
    limit: float  # what all values of all residuals and forces stay within in 95 %
    found: bool  # one is beyond the limit: chance does not explain it
    peak: float  # the value of largest size; at a negative lag only if the force clearly follows
    lag: float  # [s] of the peak


def residuals(model: Model, recording: Recording, filtered: Causal) -> list[Correlation]:
    """Every residual of the model's filter against every generalised force of the model."""
    step = max(recording.period, REACH / MOST_LAGS)
    index = np.rint(recording.t / step).astype(np.int64)
    grid = np.arange(index[-1] + 1)
    errors = np.full((len(grid), 3), np.nan)
    errors[index] = filtered.residual
    forces = np.asarray(model.trace(recording).forces(grid * step))
    if np.isfinite(errors).all(axis=1).sum() * step < ENOUGH:
        return []
    lags = round(REACH / step)
    found = cross_correlation(errors, forces, lags)
    sharp = cross_correlation(errors, np.column_stack([_whitened(f) for f in forces.T]), lags)
    band = _band(errors, forces)
    names = [force.name for force in model.vehicle.forces]
    tests = 3 * len(names) * (2 * lags + 1)
    widening = NormalDist().inv_cdf(1.0 - 0.025 / tests) / NORMAL_95  # for all of them together
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
    """95 % band (3, forces), from how errors and forces are correlated with themselves."""
    there = np.flatnonzero(np.isfinite(errors).all(axis=1))
    reach = len(errors) // 4
    rho = autocorrelation(errors[there], there, reach)
    return bartlett_band(
        rho, autocorrelation(forces, np.arange(len(forces)), len(rho) - 1), len(there)
    )


def _correlation(
    names: tuple[str, str], step: float, values: Array, sharp: Array, bands: Array
) -> Correlation:
    """What is new in a force is clearly (beyond 1) at negative lags only if residuals precede it.

    Whitening is not perfect: a strong answer to the force leaks a little to before it.
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
    """What is new in a force: less its autoregression (Yule, Walker).

    A force lasts, so that an answer to it now is correlated with what it will be; what is new can
    only be followed.
    """
    rho = autocorrelation(force, np.arange(len(force)), WHITENING)
    apart = np.abs(np.subtract.outer(np.arange(WHITENING), np.arange(WHITENING)))
    weights = np.linalg.solve(rho[apart] + RIDGE * np.eye(WHITENING), rho[1:])
    return np.convolve(force - force.mean(), np.append(1.0, -weights))[: len(force)]


def in_words(correlation: Correlation) -> str:
    """What it says, and what may be done about it."""
    axis = AXES[SYMBOLS.index(correlation.residual)]
    size = f"{correlation.peak:+.2f}, chance {correlation.limit:.2f}"
    if correlation.lag < 0:
        return (
            f"{correlation.force} follows residuals in {axis} {-correlation.lag:.2f} s later: {size}: "
            "the operator answers them, or the clock of the commands is late"
        )
    own = correlation.force[-1] == correlation.residual
    or_else = (
        "a delay is wrong, or mass, thrust or drag is not what it was"
        if own
        else "or a delay is wrong"
    )
    return (
        f"residuals in {axis} follow {correlation.force} {correlation.lag:.2f} s later: {size}: "
        f"a term is missing, {or_else}"
    )
