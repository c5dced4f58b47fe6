# SPDX-License-Identifier: MIT
"""Expected Fisher information of simulated manoeuvres: the time in which each halves an error, and sentences."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.identification.experiment_design.information import (
    RecordingInformation,
    ReferencePoint,
)
from seatrial.identification.experiment_design.manoeuvres import (
    MANOEUVRE_LENGTH,
    Manoeuvre,
    manoeuvres,
)
from seatrial.identification.experiment_design.simulated_drive import simulated_drive
from seatrial.identification.uncertainty.identifiability import Identifiability
from seatrial.identification.uncertainty.parameter_verdict import ParameterVerdict
from seatrial.recording.recording import Recording
from seatrial.util.errors import ModelError
from seatrial.util.format import joined
from seatrial.util.frames import Array
from seatrial.util.statistics import NORMAL_95, root_of

# times the shortest time: a simpler manoeuvre that takes no longer is preferred
NEARLY_SHORTEST = 1.25
LONGEST_TIME = 24 * 3600.0  # [s] up to which the time for half the error is sought
REST_BEFORE = 1.0  # [s] at rest before a manoeuvre
MOST_SENTENCES = 4
LONGEST_DRIVE = 1800.0  # [s] a longer one for one parameter is not proposed
# times a sentence's time: parameters of the same manoeuvre within it share the sentence
SIMILAR_TIME = 2.0


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
        trust * runs.information_of(i) / (MANOEUVRE_LENGTH + REST_BEFORE) for i in range(len(good))
    ]
    return _best_for_each(point, covariance, rates, [tried[i] for i in good])


def _best_for_each(
    point: ReferencePoint, covariance: Array, rates: Sequence[Array], tried: Sequence[Manoeuvre]
) -> list[ManoeuvreGain]:
    """The best manoeuvre for each parameter, by the rates (p, p) [1/s] at which they add information."""
    errors = np.sqrt(np.diag(covariance))
    curves = [ErrorDecay.of(covariance, rate) for rate in rates]
    times = np.array([curve.halved() for curve in curves])
    after = np.array([curve.errors(np.full(len(errors), 60.0)) for curve in curves])
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
        root = size[:, None] * root_of(covariance / np.outer(size, size))
        speed, turn = np.linalg.eigh(root.T @ rate @ root)
        return cls(np.square(root @ turn), np.maximum(speed, 0.0))

    def errors(self, seconds: Array) -> Array:
        """Standard errors (p,) of the parameters, each after its own time (p,) [s]."""
        return np.asarray(
            np.sqrt(np.sum(self.squares / (1.0 + seconds[:, None] * self.rates), axis=1))
        )

    def halved(self) -> Array:
        """Seconds (p,) until the standard error of each parameter is halved; infinite: never."""
        low, high = np.zeros(len(self.squares)), np.ones(len(self.squares))
        goal = 0.5 * self.errors(low)
        never = self.errors(np.full(len(goal), LONGEST_TIME)) > goal
        while (later := ~never & (self.errors(high) > goal)).any():
            low, high = np.where(later, high, low), np.where(later, 2.0 * high, high)
        for _ in range(40):
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
    """The simulated recording of a manoeuvre from rest; None where the model diverges."""
    times = np.arange(0.0, MANOEUVRE_LENGTH + REST_BEFORE, period)
    sticks = one.t + REST_BEFORE, one.commands
    with suppress(ModelError):
        return simulated_drive(model, np.zeros(6), sticks, times, one.text).recording
    return None


def next_drive(found: Identifiability, gained: Sequence[ManoeuvreGain]) -> list[str]:
    """The manoeuvres that halve the errors of the least known parameters, the worst first."""
    helped = {n for c in found.combinations if c.verdict is ParameterVerdict.SHARP for n in c.names}
    loose = {
        ParameterVerdict.USABLE,
        ParameterVerdict.WEAK,
        ParameterVerdict.ZERO,
        ParameterVerdict.LOST,
    }
    wanted = [
        g for g in gained if found[g.parameter].verdict in loose and g.parameter not in helped
    ]
    wanted.sort(key=lambda g: -found[g.parameter].relative)
    units = {gain.parameter: found[gain.parameter].unit for gain in wanted}
    sentences: list[str] = []
    never: list[ManoeuvreGain] = []
    done: set[str] = set()
    for gain in wanted:
        if gain.seconds > LONGEST_DRIVE:
            if found[gain.parameter].verdict is not ParameterVerdict.USABLE:
                never.append(gain)
            continue
        if gain.parameter in done or len(sentences) == MOST_SENTENCES:
            continue
        same = [
            g for g in wanted
            if g.manoeuvre == gain.manoeuvre and g.parameter not in done
            and g.seconds <= SIMILAR_TIME * gain.seconds
        ]  # fmt: skip
        done |= {g.parameter for g in same}
        sentences.append(_halves(gain.manoeuvre, same, units))
    if never:
        sentences.append(
            f"No manoeuvre that was tried halves within {LONGEST_DRIVE / 60:.0f} minutes the "
            f"interval{'s' * (len(never) > 1)} of {_listed(never, units)}: fix a value that you know "
            "otherwise, or take a term out that is not distinguishable from zero."
        )
    return sentences


def _halves(manoeuvre: str, gains: Sequence[ManoeuvreGain], units: Mapping[str, str]) -> str:
    """One manoeuvre for one or more parameters."""
    time = drive_time(max(g.seconds for g in gains))
    many = "s" if len(gains) > 1 else ""
    return f"{time} more of {manoeuvre} would halve the 95 % interval{many} of {_listed(gains, units)}."


def _listed(found: Sequence[ManoeuvreGain], units: Mapping[str, str]) -> str:
    return joined([f"{g.parameter} ({_interval(g, units.get(g.parameter, ''))})" for g in found])


def drive_time(seconds: float) -> str:
    """A driving time, rounded up to 5 s, or half a minute."""
    if not np.isfinite(seconds):
        return "no time"
    if seconds <= 90:
        return f"{max(1, int(np.ceil(seconds / 5))) * 5} s"
    if seconds <= 3600:
        return f"{np.ceil(seconds / 30) * 30 / 60:g} min"
    return f"{seconds / 3600:.1f} h"


def _interval(gain: ManoeuvreGain, unit: str) -> str:
    """The 95 % interval by its ends, as ± is one standard error elsewhere."""
    half = NORMAL_95 * gain.error
    text = f"{gain.value - half:.3g} to {gain.value + half:.3g}"
    return f"{text} {unit}" if unit not in ("", "-") else text
