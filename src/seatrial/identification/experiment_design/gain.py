# SPDX-License-Identifier: MIT
"""What another minute of driving would tell: expected information of simulated manoeuvres."""

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

NEARLY_SHORTEST = 1.25  # times the shortest time that a simpler manoeuvre may take instead
LONGEST_TIME = 24 * 3600.0  # [s] that are looked through
REST_BEFORE = 1.0  # [s] at rest before a manoeuvre


@dataclass(frozen=True)
class ManoeuvreGain:
    """What a manoeuvre does for one parameter."""

    parameter: str
    value: float
    error: float  # standard error now
    manoeuvre: str
    seconds: float  # of it that halve the error; infinite: it can't
    after: float  # standard error after one minute of it


def manoeuvre_gains(
    point: ReferencePoint,
    period: float,
    known: Sequence[RecordingInformation] = (),
    seen: Sequence[str] = (),
) -> list[ManoeuvreGain]:
    """For every estimated parameter the manoeuvre that halves its error soonest.

    Expected information of each manoeuvre, simulated with the model from rest, poses every `period`
    [s] with the model's noise, is added to what the covariance says is known already. `known`: what
    recordings say alone; where the model was identified from some of them (`seen`), their
    information tells how much more errors scatter than it promises, and the new one is trusted as
    little. The boat is the model's: where that is wrong, so is this.
    """
    model = point.model
    sought = [model.parameters.index(name) for name in point.names]
    covariance = model.covariance[np.ix_(sought, sought)]
    tried = manoeuvres(model)
    if not tried:
        return []
    trust = 1.0 / _scatter(covariance, [k for k in known if k.recording in seen])
    trials = [trial(model, one, period) for one in tried]
    good = [i for i, run in enumerate(trials) if run is not None]
    if not good:
        return []
    runs = point.run_filter([run for run in trials if run is not None])
    rates = [
        trust * information_of(runs, i) / (MANOEUVRE_LENGTH + REST_BEFORE) for i in range(len(good))
    ]
    errors = np.sqrt(np.diag(covariance))
    curves = [ErrorDecay.of(covariance, rate) for rate in rates]
    times = np.array([[curve.halved(k) for k in range(len(errors))] for curve in curves])
    after = np.array([[curve.error(k, 60.0) for k in range(len(errors))] for curve in curves])
    found = []
    for k, name in enumerate(point.names):
        best = _best(times[:, k], after[:, k], [tried[i].effort for i in good])
        found.append(
            ManoeuvreGain(
                name, float(point.theta[k]), float(errors[k]), tried[good[best]].text,
                float(times[best, k]), float(after[best, k]),
            )
        )  # fmt: skip
    return found


def _best(times: Array, after: Array, effort: Sequence[int]) -> int:
    """The manoeuvre that is soonest there, or a simpler one that is nearly as soon."""
    if not np.isfinite(times).any():
        return int(np.argmin(after))
    near = [j for j, t in enumerate(times.tolist()) if t <= NEARLY_SHORTEST * times.min()]
    return min(near, key=lambda j: (effort[j], times[j]))


@dataclass(frozen=True)
class ErrorDecay:
    """Errors against time at a rate of information: variance_k = sum_j V_kj^2 / (1 + t rate_j)."""

    squares: Array  # (p, p) of the directions in which both are diagonal
    rates: Array  # (p,) [1/s]

    @classmethod
    def of(cls, covariance: Array, rate: Array) -> "ErrorDecay":
        """From what is known (p, p), and what a second more adds (p, p)."""
        size = np.sqrt(np.diag(covariance))
        spectrum, vectors = np.linalg.eigh(covariance / np.outer(size, size))
        root = size[:, None] * vectors * np.sqrt(np.maximum(spectrum, 0.0))
        speed, turn = np.linalg.eigh(root.T @ rate @ root)
        return cls(np.square(root @ turn), np.maximum(speed, 0.0))

    def error(self, k: int, seconds: float) -> float:
        """Standard error of a parameter after some time [s]."""
        return float(np.sqrt(np.sum(self.squares[k] / (1.0 + seconds * self.rates))))

    def halved(self, k: int) -> float:
        """Seconds until the error of a parameter is half of what it is; infinite: never."""
        goal = 0.5 * self.error(k, 0.0)
        if self.error(k, LONGEST_TIME) > goal:
            return float("inf")
        low, high = 0.0, 1.0
        while self.error(k, high) > goal:
            low, high = high, 2.0 * high
        for _ in range(40):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.error(k, middle) > goal else (low, middle)
        return high


def _scatter(covariance: Array, known: Sequence[RecordingInformation]) -> float:
    """Variances over what the information of the same recordings promises; at least 1."""
    if not known:
        return 1.0
    total = np.sum([k.information for k in known], axis=0)
    size = np.sqrt(np.diag(total))
    if not np.all(size > 0):
        return 1.0
    promised = np.linalg.pinv(total / np.outer(size, size), hermitian=True) / np.outer(size, size)
    return max(1.0, float(np.median(np.diag(covariance) / np.diag(promised))))


def trial(model: Model, one: Manoeuvre, period: float) -> Recording | None:
    """The recording that a manoeuvre would make; None where the model trials away."""
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
    if not np.isfinite(states).all() or np.abs(states[:, 3:]).max() > 10.0:
        return None
    stamps = np.rint(1e9 * t).astype(np.int64)
    held = np.rint(1e9 * np.concatenate([begin, one.t + REST_BEFORE])).astype(np.int64)
    every = np.ones(len(t), dtype=bool)
    return Recording(
        one.text, stamps, states[:, :3], states[:, :3], every, np.zeros(len(t), dtype=np.int64),
        Signal(model.vehicle.inputs, held, commands),
        Signal(model.vehicle.scales, held[:1], scales) if signals else None,
    )  # fmt: skip
