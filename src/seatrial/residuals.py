# SPDX-License-Identifier: MIT
"""What the errors of a model still have to do with its inputs.

The errors of a filter's prediction from pose to pose are white and follow nothing if model and noise
are right (Ljung, section 16.6). If they follow a force, a term or a delay is missing.
"""

from dataclasses import dataclass
from statistics import NormalDist

import msgspec
import numpy as np

from seatrial.causal import Causal
from seatrial.frames import AXES, SYMBOLS, Array
from seatrial.model import Model
from seatrial.recording import Recording
from seatrial.statistics import NORMAL_95, autocorrelation, cross_correlation

REACH = 2.0  # [s] lags to either side
SETTLING = 2.0  # [s] in which the filter forgets how it started
WHITENING, RIDGE = 20, 1e-6  # lags of the autoregression of a force
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
    peak: float  # the value of largest size on the side where the whitened force has its own
    lag: float  # [s] of the peak


@dataclass(frozen=True)
class Scan:
    """Lags that are looked at."""

    lags: int  # to either side
    step: float  # [s]
    widening: float  # of the band, so that it holds for all lags of all pairs together


def residuals(model: Model, recording: Recording, filtered: Causal) -> list[Correlation]:
    """Every residual of the model's filter against every generalised force of the model."""
    step = max(recording.period, REACH / MOST_LAGS)
    index = np.rint(recording.t / step).astype(np.int64)
    grid = np.arange(index[-1] + 1)
    errors = np.full((len(grid), 3), np.nan)
    late = recording.t > SETTLING
    errors[index[late]] = filtered.residual[late]
    forces = np.asarray(model.trace(recording).forces(grid * step))
    lags = round(REACH / step)
    names = [force.name for force in model.vehicle.forces]
    tests = 3 * len(names) * (2 * lags + 1)
    scan = Scan(lags, step, NormalDist().inv_cdf(1.0 - 0.025 / tests) / NORMAL_95)
    return [
        _correlation(errors[:, axis], forces[:, i], (SYMBOLS[axis], name), scan)
        for axis in range(3)
        for i, name in enumerate(names)
        if np.isfinite(errors[:, axis]).sum() > 4 * lags and np.ptp(forces[:, i]) > 0.0
    ]


def _correlation(error: Array, force: Array, names: tuple[str, str], scan: Scan) -> Correlation:
    values, band = cross_correlation(error, force, scan.lags)
    sharp, _ = cross_correlation(error, _whitened(force), scan.lags)
    late = int(np.argmax(np.abs(sharp))) >= scan.lags
    side = np.arange(scan.lags, 2 * scan.lags + 1) if late else np.arange(scan.lags)
    at = int(side[np.argmax(np.abs(values[side]))])
    limit = scan.widening * band
    return Correlation(
        *names, scan.step, values.round(4).tolist(), band, limit,
        bool(np.abs(values).max() > limit), float(values[at]), (at - scan.lags) * scan.step,
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
    return (
        f"residuals in {axis} follow {correlation.force} {correlation.lag:.2f} s later: {size}: "
        "a term or a delay is missing"
    )
