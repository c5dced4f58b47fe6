# SPDX-License-Identifier: MIT
"""Errors of the estimates where the commands are samples: a change may be a step, or a ramp from sample to sample.

A step halfway and a ramp have the same size and the same mean time. A ramp spreads thrust in time, as a longer lag
does, and the samples do not tell which of them it was. So the difference that ramps make to the estimates is added
to their covariance.
"""

from dataclasses import replace

import numpy as np

from seatrial.boat.model import sampling_period
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import Point
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.util.frames import Array
from seatrial.util.statistics import inverse_of

# [periods] from the middle of a ramp to either half of it: two halves there have its mean and its variance
RAMP_HALF = 1.0 / np.sqrt(12.0)


def with_unknown_shape(at: Point, covariance: Array) -> Array:
    """The covariance (p, p) with the difference between steps and ramps of sampled commands.

    One filter pass with ramps, and the Gauss-Newton step from there. Unchanged where no commands are samples.
    """
    problem = at.runs.problem
    periods = [sampling_period(problem.vehicle, r) for r in problem.recordings]
    if not any(periods):
        return covariance
    ramps = tuple(with_ramps(r, p) for r, p in zip(problem.recordings, periods, strict=True))
    runs = filter_along(replace(problem, recordings=ramps), at.theta, at.noise, repeatable=False)
    if not np.isfinite(runs.cost):
        return covariance
    # parameters at a bound stay there
    inside = np.diag(covariance) > 0.0
    move = np.zeros(len(covariance))
    move[inside] = inverse_of(runs.information[np.ix_(inside, inside)]) @ runs.gradient[inside]
    return covariance + np.outer(move, move)


def with_ramps(recording: Recording, period: float) -> Recording:
    """The recording with every change of its commands in two halves, spread in time as ramps of a period [s]."""
    if period == 0.0:
        return recording
    known = recording.commands
    halves = 0.5 * np.diff(known.values, axis=0)
    away = round(1e9 * period * RAMP_HALF)
    times = np.concatenate([known.stamps[:1], known.stamps[1:] - away, known.stamps[1:] + away])
    stamps, places = np.unique(times, return_inverse=True)
    # sums of the changes: halves of two changes may pass each other where samples are irregular
    changes = np.zeros((len(stamps), len(known.names)))
    np.add.at(changes, places, np.concatenate([known.values[:1], halves, halves]))
    return replace(recording, commands=Signal(known.names, stamps, np.cumsum(changes, axis=0)))
