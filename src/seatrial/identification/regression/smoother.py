# SPDX-License-Identifier: MIT
"""Smooth the poses, then regress the smoothed accelerations: a common method, as a baseline.

A Kalman filter with constant acceleration driven by white jerk, and the backward pass of Rauch, Tung and
Striebel (1965), give position, velocity and acceleration of each pose coordinate. Jerk intensity and pose noise
are those of highest likelihood. The accelerations are then regressed on Eq. (12) pose by pose.

It is biased: the smoother spreads the acceleration in time, but not the command that it is regressed on; and
the regressors contain the noise that is left in the velocities.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model, thrust_trace
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.regression.linear_equations import (
    LinearEquations,
)
from seatrial.identification.regression.weak_form import (
    axes_served,
    regression_model,
    sought_constants,
)
from seatrial.recording.delays import at_one_time
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Mask, body_velocity

SMOOTHER = "smoother"
ROUGHNESS_GRID = 10.0 ** np.arange(-7.0, 5.0)  # jerk intensity over pose noise, in pose periods
ROUGHNESS_POSES = 3000  # of a recording, at most, for the likelihood of the roughness
EDGE_POSES = 3  # at either end of an interval, without a usable acceleration


@dataclass(frozen=True)
class Track:
    """One smoothed recording at its usable poses, without the ends of its continuous intervals."""

    recording: Recording
    t: Array  # (n,) [s]
    nu: Array  # (n, 3) body velocity
    nu_dot: Array  # (n, 3)


@dataclass(frozen=True)
class AccelerationRows:
    """Accelerations and regressors, pose by pose."""

    vehicle: Vehicle
    tracks: tuple[Track, ...]
    use: Mask  # (m, 3) rows that count

    def design(self, constants: Array) -> LinearEquations:
        """Eq. (12) for these constants of the chain."""
        structure = self.vehicle.structure
        places = np.array([row[1] for row in structure.rows])
        axes = np.array([row[0] for row in structure.rows])
        sums = np.eye(len(structure.coefficients) + 1)[places]
        parts = []
        for track in self.tracks:
            force = thrust_trace(self.vehicle, constants, track.recording).forces(track.t)
            products = _core.regressors(structure.compiled, track.nu, track.nu_dot, force)
            parts.append(
                np.stack([products[:, axes == k] @ sums[axes == k] for k in range(3)], axis=1)
            )
        columns = np.concatenate(parts)
        a = np.concatenate([track.nu_dot for track in self.tracks])
        return LinearEquations(a - columns[:, :, -1], columns[:, :, :-1])


def smoother(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    roles: Mapping[str, Sequence[str]] | None = None,
) -> Model:
    """Coefficients, and the latencies, lags and dead zones that the vehicle file does not state.

    Recordings serve the axes as they do in `weak_form`. Raises IdentificationError, RecordingError.
    """
    # the same axes, constants and blocks as in the weak form
    whole, moved = sought_constants(recordings, vehicle)
    serves = axes_served(whole, recordings, roles)
    tracks = smoothed([at_one_time(r) for r in recordings])
    use = [np.tile(np.array(s), (len(t.t), 1)) for s, t in zip(serves, tracks, strict=True)]
    samples = AccelerationRows(whole, tracks, np.concatenate(use))
    return regression_model(
        recordings, samples, moved, [track.t for track in tracks], method=SMOOTHER, settings={}
    )


def smoothed(recordings: Sequence[Recording]) -> tuple[Track, ...]:
    """Smoothed motion of each recording. Raises IdentificationError where poses are too few."""
    series = [_series(r) for r in recordings]
    runs = [_forward(s, ROUGHNESS_GRID, ROUGHNESS_POSES) for s in series]
    count = sum(p.count for p in runs)
    squares, logs = (
        np.sum([p.squares for p in runs], axis=0),
        np.sum([p.logs for p in runs], axis=0),
    )
    # at the pose noise of highest likelihood
    cost = count * np.log(squares + 1e-300) + logs[:, None]
    likeliest = ROUGHNESS_GRID[[np.argmin(cost[:, :2].sum(axis=1)), np.argmin(cost[:, 2])]]
    tracks = tuple(_track(s, _forward(s, likeliest, len(s.t))) for s in series)
    if not any(len(track.t) for track in tracks):
        raise IdentificationError(
            f"{', '.join(r.name for r in recordings)}: no {2 * EDGE_POSES + 1} usable poses in a row; record "
            "longer, or look for drop-outs with inspect"
        )
    return tracks


@dataclass(frozen=True)
class _Series:
    """Usable poses, and the motion between each and the one before, in pose periods."""

    recording: Recording
    t: Array  # (n,) [s]
    y: Array  # (n, 3)
    fresh: Mask  # (n,) first of a continuous interval
    move: Array  # (n, 3, 3) transition of position, velocity, acceleration
    spread: Array  # (n, 3, 3) covariance by jerk of unit intensity


@dataclass(frozen=True)
class _ForwardRun:
    """The filter along a series, for c values of the roughness at once."""

    count: int  # poses with an informative prediction
    logs: Array  # (c,) sums of log prediction variances
    squares: Array  # (c, 3) sums of squared errors over them
    predicted: list[tuple[Array, Array]]  # x (c, 3, signals), P (c, 3, 3)
    updated: list[tuple[Array, Array]]


def _series(recording: Recording) -> _Series:
    good = np.flatnonzero(recording.valid)
    t, segment = recording.t[good], recording.segment[good]
    h = np.diff(t, prepend=t[0]) / recording.period
    one, no = np.ones_like(h), np.zeros_like(h)
    move = np.array([[one, h, h**2 / 2], [no, one, h], [no, no, one]])
    spread = np.array(
        [
            [h**5 / 20, h**4 / 8, h**3 / 6],
            [h**4 / 8, h**3 / 3, h**2 / 2],
            [h**3 / 6, h**2 / 2, h],
        ]
    )
    fresh = np.diff(segment, prepend=segment[0] - 1) != 0
    first, last = (np.moveaxis(x, 2, 0) for x in (move, spread))
    return _Series(recording, t, recording.eta[good], fresh, first, last)


def _forward(series: _Series, roughness: Array, most: int) -> _ForwardRun:
    """The Kalman filter with pose noise 1 over the first `most` poses."""
    c = len(roughness)
    x, P = np.zeros((c, 3, 3)), np.zeros((c, 3, 3))
    unknown = np.diag([1.0, 1e8, 1e8])  # velocity and acceleration, at first
    count, logs, squares = 0, np.zeros(c), np.zeros((c, 3))
    predicted, updated = [], []
    for k in range(min(most, len(series.t))):
        if series.fresh[k]:
            x, P = np.zeros((c, 3, 3)), np.tile(unknown, (c, 1, 1))
            x[:, 0] = series.y[k]
            predicted.append((x, P))
            updated.append((x, P))
            continue
        F = series.move[k]
        x, P = F @ x, F @ P @ F.T + roughness[:, None, None] * series.spread[k]
        predicted.append((x, P))
        variance, error = P[:, 0, 0] + 1.0, series.y[k] - x[:, 0]
        if variance.max() < 1e4:  # not diffuse any more
            count, logs = count + 1, logs + np.log(variance)
            squares = squares + error**2 / variance[:, None]
        gain = P[:, :, 0] / variance[:, None]
        x = x + gain[:, :, None] * error[:, None, :]
        P = P - gain[:, :, None] * P[:, None, 0, :]
        updated.append((x, P))
    return _ForwardRun(count, logs, squares, predicted, updated)


def _track(series: _Series, along: _ForwardRun) -> Track:
    """The backward pass of Rauch, Tung and Striebel, then Eq. (1) into body axes."""
    n, r = len(series.t), series.recording
    states = np.zeros((n, 3, 3))  # pose, velocity, acceleration by signal
    x = along.updated[-1][0]
    states[-1, :, :2], states[-1, :, 2] = x[0, :, :2], x[1, :, 2]
    for k in range(n - 2, -1, -1):
        if series.fresh[k + 1]:
            x = along.updated[k][0]
        else:
            (ahead, A), (here, P) = along.predicted[k + 1], along.updated[k]
            gain = np.linalg.solve(A, series.move[k + 1] @ P).transpose(0, 2, 1)
            x = here + gain @ (x - ahead)
        states[k, :, :2], states[k, :, 2] = x[0, :, :2], x[1, :, 2]
    nu = body_velocity(states[:, 0, 2], states[:, 1] / r.period)
    nu_dot = body_velocity(states[:, 0, 2], states[:, 2] / r.period**2)
    nu_dot[:, 0] += nu[:, 2] * nu[:, 1]  # the derivative of Eq. (1)
    nu_dot[:, 1] -= nu[:, 2] * nu[:, 0]
    stretch = np.cumsum(series.fresh)
    index = np.arange(n)
    inner = (stretch[np.maximum(index - EDGE_POSES, 0)] == stretch) & (index >= EDGE_POSES)
    inner &= (stretch[np.minimum(index + EDGE_POSES, n - 1)] == stretch) & (index < n - EDGE_POSES)
    return Track(
        r, series.t[inner], np.ascontiguousarray(nu[inner]), np.ascontiguousarray(nu_dot[inner])
    )
