# SPDX-License-Identifier: MIT
"""Fisher scoring of noise parameters on linearised filter runs: no integration.

The covariance of the innovations is linear in the variances of all noise sources. So amplitudes are scored as
variances, bounded below at (nearly) none: a source that the data do not need ends there in one step, and one that
they need leaves it again. Time constants and the angular frequency are scored as logarithms, with damped steps.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.noise_parameters import (
    AMPLITUDES,
    COLOUR,
    COLOUR_MEMORY,
    COLOUR_TURN,
    DISTURBANCES,
    IN_PLANE,
    MEMORY,
    NOISE_LEAST,
    OUTLIER,
    SWAY_RATIO,
    is_unequal,
    least_noise,
    noise_units,
    oscillates,
)
from seatrial.util.box import box_minimum
from seatrial.util.frames import Array, Mask
from seatrial.util.parallel import spread

PROBE = 0.1  # of a variance, by which it is moved for its derivative
LEAST_PROBE = 0.02  # of the unit of a noise source: the same, of a deviation near none
LOGARITHM_PROBE = 0.05  # of a time constant or an angular frequency
LOGARITHM_STEP, TURN_STEP = 1.5, 0.15  # largest steps; a resonance is narrow
GROWTH = 30.0  # of a variance in one step, beyond the square of its unit
LEAST_CURVATURE = 0.25  # of a logarithm: keeps time constants without information in place
SHARES = (1.0, 0.9, 0.5, 0.1)  # of a step that are tried until one gains
LEAST_PROMISE = 0.05  # fall of -2 log likelihood by a step: less is not tried
AT_LEAST = 1.01  # times the lower bounds: up to here noise is at them
SCORING_STEPS = 8  # of `fitted_noise`
RELATIVE_RIDGE = 1e-9  # keeps the step unique where two sources have the same effect


Places = NDArray[np.int64]  # of some noise parameters among all


@dataclass(frozen=True)
class Linearised:
    """Filter runs that kept their linearisation, one for each recording, and a step of the parameters."""

    runs: Sequence[_core.FilterRun]
    series: Sequence[_core.Series]
    period: float  # [s] of the poses
    outlier: float = OUTLIER
    steps: Sequence[Array | None] = ()  # of each run's own parameters; none where empty
    effects: bool = False  # whether the runs' effects are parameters

    def _items(self) -> list[tuple[_core.FilterRun, _core.Series, Array | None]]:
        steps = self.steps or [None] * len(self.runs)
        return list(zip(self.runs, self.series, steps, strict=True))

    def cost(self, noise: Array) -> float:
        """-2 log likelihood with other noise (12,), without its constant."""

        def one(item: tuple[_core.FilterRun, _core.Series, Array | None]) -> float:
            run, series, step = item
            return _core.repeated(run, series, noise, self.outlier, step, self.effects)

        return float(sum(spread(one, self._items())))

    def derivatives(self, noise: Array, moved: Array, steps: Array) -> tuple[float, Array, Array]:
        """Cost, half its gradient (m,), and the information (m, m) in the directions of noises `moved` (m, 12)."""

        def one(
            item: tuple[_core.FilterRun, _core.Series, Array | None],
        ) -> tuple[float, Array, Array]:
            run, series, step = item
            return _core.noise_slopes(
                run, series, noise, moved, steps, self.outlier, step, self.effects
            )

        parts = spread(one, self._items())
        m = len(steps)
        gradient = np.sum([p[1] for p in parts], axis=0)
        information = np.sum([np.reshape(p[2], (m, m)) for p in parts], axis=0)
        return float(sum(p[0] for p in parts)), gradient, information


@dataclass(frozen=True)
class NoiseBox:
    """Which noise may be there: bounds (12,), and which parameters are free."""

    least: Array = field(default_factory=least_noise)
    most: Array = field(default_factory=lambda: np.full(len(NOISE_LEAST), np.inf))
    free: Mask = field(default_factory=lambda: np.ones(len(NOISE_LEAST), dtype=bool))

    def active(self, noise: Array, *, absent: bool) -> Mask:
        """Parameters (12,) that can be scored: time constants count only with their amplitudes.

        absent: with amplitudes that are at their lower bound.
        """
        there = noise > self.least
        out = self.free & (there | absent)
        out[MEMORY] = self.free[MEMORY] and there[DISTURBANCES].any()
        coloured = (noise[COLOUR] > _core.NO_COLOUR).any()
        out[COLOUR_MEMORY] = self.free[COLOUR_MEMORY] and coloured
        out[COLOUR_TURN] = self.free[COLOUR_TURN] and coloured and oscillates(noise)
        in_plane = is_unequal(noise) and there[IN_PLANE].any()
        out[SWAY_RATIO] = self.free[SWAY_RATIO] and in_plane
        return np.asarray(out)


@dataclass(frozen=True)
class Value:
    """What is to fall, of a noise (12,), and how much it is here."""

    of: Callable[[Array], float]
    here: float


def scored(
    at: Linearised, noise: Array, box: NoiseBox, value: Value, *, absent: bool = True
) -> tuple[Array, float]:
    """One step of Fisher scoring within a box: likelier noise (12,), and its value.

    absent: whether sources that are at their lower bound may leave it.
    """
    period, here = at.period, value.here
    places = np.flatnonzero(box.active(noise, absent=absent))
    units = noise_units(noise, period)
    amplitude = np.isin(places, AMPLITUDES)
    begin = _coordinates(noise, places, amplitude)
    # numerical derivatives, by small changes of each noise
    probes = np.where(amplitude, np.maximum(PROBE * begin, (LEAST_PROBE * units[places]) ** 2), 0.0)
    probes[~amplitude] = _logarithm_probes(noise, places[~amplitude])
    moved = np.array(
        [_noise(noise, places, amplitude, begin + step) for step in np.diag(probes)]
    ).reshape(len(places), len(noise))
    _, gradient, information = at.derivatives(noise, moved, probes)
    # time constants without information stay where they are
    information = information + np.diag(np.where(amplitude, 0.0, LEAST_CURVATURE))
    # the step within the bounds
    least, most = (_coordinates(bound, places, amplitude) for bound in (box.least, box.most))
    reach = np.where(amplitude, GROWTH * np.maximum(begin, units[places] ** 2), LOGARITHM_STEP)
    reach[places == COLOUR_TURN] = TURN_STEP
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), np.finfo(float).tiny))
    with np.errstate(over="ignore"):
        matrix = information * np.outer(scale, scale) + RELATIVE_RIDGE * np.eye(len(places))
    if not np.isfinite(matrix).all():  # a model that diverges shows nothing of the noise
        return noise, here
    low, high = np.maximum(least - begin, -reach) / scale, np.minimum(most - begin, reach) / scale
    step = scale * box_minimum(
        matrix, -scale * gradient, np.minimum(low, 0.0), np.maximum(high, 0.0)
    )
    if not -(2.0 * gradient @ step + step @ information @ step) > LEAST_PROMISE:
        return noise, here
    # the largest share of the step that gains
    for share in SHARES:
        trial = np.clip(_noise(noise, places, amplitude, begin + share * step), box.least, box.most)
        found = value.of(trial)
        if found < here:
            return trial, found
    return noise, here


def fitted_noise(at: Linearised, noise: Array, settled: float) -> tuple[Array, float]:
    """Maximum-likelihood noise (12,) for a fixed model, and -2 log likelihood without its constant.

    A step that gains less than `settled` is the last.
    """
    here = at.cost(noise)
    for _ in range(SCORING_STEPS):
        before = here
        noise, here = scored(at, noise, NoiseBox(), Value(at.cost, before))
        if before - here < settled:
            break
    return noise, here


def _coordinates(noise: Array, places: Places, amplitude: Mask) -> Array:
    """Variances of amplitudes, logarithms of the others."""
    own = noise[places]
    return np.where(amplitude, own**2, np.log(np.where(amplitude, 1.0, own)))


def _noise(noise: Array, places: Places, amplitude: Mask, at: Array) -> Array:
    """The noise (12,) with these coordinates."""
    out = noise.copy()
    out[places] = np.where(
        amplitude, np.sqrt(np.maximum(at, 0.0)), np.exp(np.where(amplitude, 0.0, at))
    )
    none = out < AT_LEAST * NOISE_LEAST
    none[SWAY_RATIO] = False
    return np.where(none, NOISE_LEAST, out)


def _logarithm_probes(noise: Array, places: Places) -> Array:
    """Steps of logarithms: short ones of the frequency, as a resonance is narrow."""
    sharp = 1.0 + noise[COLOUR_TURN] * noise[COLOUR_MEMORY]
    return np.where(places == COLOUR_TURN, LOGARITHM_PROBE / sharp, LOGARITHM_PROBE)
