# SPDX-License-Identifier: MIT
"""The expected Fisher information of simulated manoeuvres, and the time in which each halves an error."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.identification.experiment_design.information import (
    RecordingInformation,
    ReferencePoint,
    information_of,
)
from seatrial.identification.experiment_design.manoeuvres import (
    MANOEUVRE_LENGTH,
    Manoeuvre,
    manoeuvres,
)
from seatrial.recording.recording import Recording, Signal
from seatrial.util.frames import Array

# times the shortest time: a simpler manoeuvre that takes no longer is preferred
NEARLY_SHORTEST = 1.25
LONGEST_TIME = 24 * 3600.0  # [s] up to which the time for half the error is sought
REST_BEFORE = 1.0  # [s] at rest before a manoeuvre
ONE_MINUTE = 60.0  # [s]
TIME_BISECTIONS = 40
DIVERGED_SPEED = 10.0  # [m/s, rad/s] a simulation beyond it diverges


@dataclass(frozen=True)
class ManoeuvreGain:
    """The effect of the best manoeuvre on one parameter."""

    parameter: str
    value: float
    error: float  # standard error now
    manoeuvre: str
    seconds: float  # of it that halve the error; infinite: never
    after: float  # standard error after one minute of it


def manoeuvre_gains(
    point: ReferencePoint,
    period: float,
    known: Sequence[RecordingInformation] = (),
    seen: Sequence[str] = (),
) -> list[ManoeuvreGain]:
    """For every estimated parameter the manoeuvre that halves its error soonest.

    The expected information of each manoeuvre, simulated with the model from rest, poses every `period` [s]
    with the model's noise, is added to that of the covariance. `known`: information of recordings; where the model
    was identified from some of them (`seen`), the ratio of the covariance to their information scales the new
    one, too. All of it holds for the model's boat: where the model is wrong, so is this.
    """
    model = point.model
    sought = [model.parameters.index(name) for name in point.names]
    covariance = model.covariance[np.ix_(sought, sought)]
    tried = manoeuvres(model)
    if not tried:
        return []
    # new information counts as little as that of the recordings turned out to
    trust = 1.0 / _scatter(covariance, [k for k in known if k.recording in seen])
    # simulate all manoeuvres, and filter those that the model survives
    trials = [trial(model, one, period) for one in tried]
    good = [i for i, run in enumerate(trials) if run is not None]
    if not good:
        return []
    runs = point.run_filter([run for run in trials if run is not None])
    rates = [
        trust * information_of(runs, i) / (MANOEUVRE_LENGTH + REST_BEFORE) for i in range(len(good))
    ]
    return _best_for_each(point, covariance, rates, [tried[i] for i in good])


def _best_for_each(
    point: ReferencePoint, covariance: Array, rates: Sequence[Array], tried: Sequence[Manoeuvre]
) -> list[ManoeuvreGain]:
    """The best manoeuvre for each parameter, by the rates (p, p) [1/s] at which they add information."""
    errors = np.sqrt(np.diag(covariance))
    curves = [ErrorDecay.of(covariance, rate) for rate in rates]
    times = np.array([curve.halved() for curve in curves])
    after = np.array([curve.errors(np.full(len(errors), ONE_MINUTE)) for curve in curves])
    found = []
    for k, name in enumerate(point.names):
        best = _best(times[:, k], after[:, k], [one.effort for one in tried])
        found.append(
            ManoeuvreGain(
                name, float(point.theta[k]), float(errors[k]), tried[best].text,
                float(times[best, k]), float(after[best, k]),
            )
        )  # fmt: skip
    return found


def _best(times: Array, after: Array, effort: Sequence[int]) -> int:
    """The manoeuvre that takes the least time, or a simpler one that takes little more."""
    if not np.isfinite(times).any():
        return int(np.argmin(after))
    near = [j for j, t in enumerate(times.tolist()) if t <= NEARLY_SHORTEST * times.min()]
    return min(near, key=lambda j: (effort[j], times[j]))


@dataclass(frozen=True)
class ErrorDecay:
    """Errors against time at a constant rate of information: variance_k = sum_j V_kj^2 / (1 + t rate_j)."""

    squares: Array  # (p, p) of the directions in which covariance and rate are diagonal
    rates: Array  # (p,) [1/s]

    @classmethod
    def of(cls, covariance: Array, rate: Array) -> "ErrorDecay":
        """From a covariance (p, p), and the information (p, p) of one more second."""
        size = np.sqrt(np.diag(covariance))
        spectrum, vectors = np.linalg.eigh(covariance / np.outer(size, size))
        root = size[:, None] * vectors * np.sqrt(np.maximum(spectrum, 0.0))
        speed, turn = np.linalg.eigh(root.T @ rate @ root)
        return cls(np.square(root @ turn), np.maximum(speed, 0.0))

    def errors(self, seconds: Array) -> Array:
        """Standard errors (p,) of the parameters, each after its own time (p,) [s]."""
        return np.asarray(
            np.sqrt(np.sum(self.squares / (1.0 + seconds[:, None] * self.rates), axis=1))
        )

    def halved(self) -> Array:
        """Seconds (p,) until the error of each parameter is half of what it is; infinite: never."""
        low, high = np.zeros(len(self.squares)), np.ones(len(self.squares))
        goal = 0.5 * self.errors(low)
        never = self.errors(np.full(len(goal), LONGEST_TIME)) > goal
        while (later := ~never & (self.errors(high) > goal)).any():
            low, high = np.where(later, high, low), np.where(later, 2.0 * high, high)
        for _ in range(TIME_BISECTIONS):
            middle = 0.5 * (low + high)
            later = self.errors(middle) > goal
            low, high = np.where(later, middle, low), np.where(later, high, middle)
        return np.where(never, np.inf, high)


def _scatter(covariance: Array, known: Sequence[RecordingInformation]) -> float:
    """Ratio of the covariance to the inverse information of the same recordings; at least 1."""
    if not known:
        return 1.0
    total = np.sum([k.information for k in known], axis=0)
    size = np.sqrt(np.diag(total))
    if not np.all(size > 0):
        return 1.0
    expected = np.linalg.pinv(total / np.outer(size, size), hermitian=True) / np.outer(size, size)
    return max(1.0, float(np.median(np.diag(covariance) / np.diag(expected))))


def trial(model: Model, one: Manoeuvre, period: float) -> Recording | None:
    """The simulated recording of a manoeuvre; None where the model diverges."""
    t = np.arange(0.0, MANOEUVRE_LENGTH + REST_BEFORE, period)
    signals = [model.vehicle.file.scales[name].reference for name in model.vehicle.scales]
    scales = np.array([signals], dtype=float).reshape(1, len(signals))
    begin = np.array([-1.0])
    commands = np.vstack([np.zeros((1, one.commands.shape[1])), one.commands])
    trace = _core.ThrustTrace(
        model.vehicle.chain, model.constants, np.concatenate([begin, one.t + REST_BEFORE]),
        np.ascontiguousarray(commands), begin, scales,
    )  # fmt: skip
    states, _ = _core.simulate(model.boat, trace, np.zeros(6), t)
    if not np.isfinite(states).all() or np.abs(states[:, 3:]).max() > DIVERGED_SPEED:
        return None
    stamps = np.rint(1e9 * t).astype(np.int64)
    held = np.rint(1e9 * np.concatenate([begin, one.t + REST_BEFORE])).astype(np.int64)
    every = np.ones(len(t), dtype=bool)
    return Recording(
        one.text, stamps, states[:, :3], states[:, :3], every, np.zeros(len(t), dtype=np.int64),
        Signal(model.vehicle.inputs, held, commands),
        Signal(model.vehicle.scales, held[:1], scales) if signals else None,
    )  # fmt: skip
