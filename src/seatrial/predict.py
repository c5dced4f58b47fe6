# SPDX-License-Identifier: MIT
"""Velocity some time ahead, from every instant of a recording."""

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.errors import ModelError, RecordingError
from seatrial.faults import FaultKind
from seatrial.frames import Array, Stamps
from seatrial.model import Model
from seatrial.noise import pose_noise
from seatrial.recording import Recording
from seatrial.schema import NoiseEntry
from seatrial.velocity import STENCIL_NOISE, Motion, motion

DEFAULT_HORIZON = 1.0  # [s] the paper's 15 steps at 15 Hz


@dataclass(frozen=True)
class Prediction:
    """Velocities predicted `horizon` ahead, at the instants that they are predicted for."""

    stamps: Stamps  # (m,) [ns]
    t: Array  # (m,) the same in [s] from the recording's start
    nu: Array  # (m, 3) predicted [m/s, m/s, rad/s]
    measured: Array  # (m, 3) at the same instants
    start: Array  # (m, 3) velocity that the prediction started from: the constant-velocity guess
    index: NDArray[np.int64]  # (m,) pose that each belongs to
    steps: int
    floor: Array  # (3,) RMS that a perfect model would score; 0 without pose noise

    @property
    def errors(self) -> Array:
        """Measured minus predicted (m, 3), as in the paper."""
        return np.asarray(self.measured - self.nu)


def _why(model: Model) -> str:
    """What was noted when the model was made; else what is usual."""
    noted = list(model.warnings)
    return f"It was noted: {noted[0]}" if noted else "Identify from driving as fast as this"


def predict(
    model: Model,
    recording: Recording,
    horizon: float = DEFAULT_HORIZON,
    *,
    velocities: Motion | None = None,
) -> Prediction:
    """Predict from every usable pose: the recorded commands drive the model for `horizon` [s].

    Starts and references are the stencil's velocities unless `velocities` are given (the truth of
    a simulated trial). Raises RecordingError where there is no stretch as long as the horizon, and
    ModelError where the model runs away.
    """
    if not 0 < horizon < np.inf:
        raise RecordingError(f"horizon {horizon:g} s: expected a positive number of seconds")
    steps = round(horizon / recording.period)
    if steps < 1:
        raise RecordingError(
            f"{recording.name}: horizon {horizon:g} s is shorter than the time between poses, "
            f"{recording.period:.3f} s; choose a longer one"
        )
    moving = motion(recording) if velocities is None else velocities
    start = _starts(recording, moving, steps, horizon)
    x0 = np.column_stack([moving.eta[start], moving.nu[start]])
    trace = model.trace(recording, initial=velocities is None)
    states, slopes = _core.predict(
        model.boat, trace, recording.t, start.astype(np.int32), np.ascontiguousarray(x0), steps,
        threads=os.cpu_count() or 1, tangents=velocities is None,
    )  # fmt: skip
    lost = int((~np.isfinite(states).all(axis=1)).sum())
    if lost:
        raise ModelError(
            f"{recording.name}: the model runs away from {lost} of {len(states)} starts within "
            f"{horizon:g} s: it can't be used at these speeds. {_why(model)}"
        )
    end = start + steps
    floor = np.zeros(3) if velocities is not None else _floor(model, recording, slopes)
    return Prediction(
        recording.stamps[end],
        recording.t[end],
        states[:, 3:],
        moving.nu[end],
        moving.nu[start],
        end,
        steps,
        floor,
    )


def _starts(recording: Recording, moving: Motion, steps: int, horizon: float) -> NDArray[np.int64]:
    n = len(recording.t)
    start = np.arange(max(0, n - steps), dtype=np.int64)
    end = start + steps
    usable = moving.valid[start] & moving.valid[end]
    usable &= np.abs(recording.t[end] - recording.t[start] - horizon) < 0.75 * recording.period
    for fault in recording.faults:
        if fault.kind is FaultKind.SILENT:  # what drove the boat there is not known
            usable &= (recording.t[end] < fault.start) | (recording.t[start] > fault.end)
    if not usable.any():
        raise RecordingError(
            f"{recording.name}: no two usable velocities {horizon:g} s apart in "
            f"{recording.duration:.1f} s with {int(recording.valid.sum())} usable poses; "
            "record longer, or take a shorter --horizon"
        )
    return start[usable]


def _own_noise(model: Model, recording: Recording) -> NoiseEntry:
    """The recording's own pose noise; the model's where there are too few poses in a row."""
    try:
        return pose_noise(recording)
    except RecordingError:
        return model.noise


def _floor(model: Model, recording: Recording, slopes: Array) -> Array:
    """floor^2 = noise of the reference^2 + noise of the start, propagated through the model^2."""
    spread = STENCIL_NOISE / recording.period
    own = _own_noise(model, recording)
    noise = spread * np.array([own.position, own.position, own.heading])
    phi = slopes[:, 3:, 3:6]  # d nu(end) / d nu(start)
    carried = np.mean(np.einsum("nij,j->ni", phi**2, noise**2), axis=0)
    return np.asarray(np.sqrt(noise**2 + carried))
