# SPDX-License-Identifier: MIT
"""What the report needs of each recording, computed once and laid on one time base."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial.errors import RecordingError
from seatrial.excitation import Excitation, excitation
from seatrial.faults import GAP_FACTOR
from seatrial.frames import Array
from seatrial.model import Model
from seatrial.predict import Prediction, predict
from seatrial.recording import Recording
from seatrial.validate import RecordingScore, score, seen
from seatrial.velocity import motion

WINDOW = 40.0  # [s] that a plot opens at, as in Figs. 5 and 6
WINDOW_STEP = 5.0  # [s] between the windows that are compared
NEARLY_ALL = 0.95  # share of the best window's predictions that a window must have


@dataclass(frozen=True)
class Run:
    """One recording beside its prediction. A row of NaN stands where a line must break."""

    recording: Recording
    prediction: Prediction
    score: RecordingScore
    excitation: Excitation
    unseen: bool  # the model was not identified from it
    t: Array  # (n,) time base: the poses', and the middle of every gap and jump [s]
    position: Array  # (n, 2) x, y [m] of the usable poses
    measured: Array  # (n, 3) [m/s, m/s, rad/s]
    predicted: Array  # (n, 3) [m/s, m/s, rad/s]
    forces: Array  # (n, forces) [command units]
    window: tuple[float, float]  # [s] busy stretch that the plots open at

    @property
    def masked(self) -> float:
        """Share of the poses that were left out."""
        return 1.0 - self.recording.usable


def gather(model: Model, recordings: Sequence[Recording], horizon: float) -> list[Run]:
    """Every recording with its prediction `horizon` [s] ahead, in the order given."""
    if not recordings:
        raise RecordingError("report: no recording given; pass at least one")
    return [_run(model, recording, horizon) for recording in recordings]


def _run(model: Model, recording: Recording, horizon: float) -> Run:
    moving = motion(recording)
    prediction = predict(model, recording, horizon)
    t, row = time_base(recording)

    def spread(values: Array, index: NDArray[np.intp] | NDArray[np.bool_]) -> Array:
        out = np.full((len(t), values.shape[1]), np.nan)
        out[row[index]] = values
        return out

    predicted = spread(prediction.nu, np.asarray(prediction.index, dtype=np.intp))
    forces = np.asarray(model.trace(recording).forces(t))
    return Run(
        recording,
        prediction,
        score(model, recording, prediction),
        excitation(model.vehicle, recording),
        not seen(model, recording),
        t,
        spread(recording.eta[recording.valid, :2], recording.valid),
        spread(moving.nu[moving.valid], moving.valid),
        predicted,
        forces,
        busy_window(t, np.isfinite(predicted[:, 0]), forces),
    )


def time_base(recording: Recording) -> tuple[Array, NDArray[np.intp]]:
    """Pose times [s] with a row more in the middle of each gap and jump; the row of each pose."""
    t, valid, segment = recording.t, recording.valid, recording.segment
    breaks = np.diff(t) > GAP_FACTOR * recording.period
    breaks |= valid[1:] & valid[:-1] & (np.diff(segment) != 0)
    before = np.flatnonzero(breaks)
    row = np.arange(len(t)) + np.searchsorted(before, np.arange(len(t)))
    base = np.insert(t, before + 1, 0.5 * (t[before] + t[before + 1]))
    return base, row


def busy_window(t: Array, predicted: NDArray[np.bool_], forces: Array) -> tuple[float, float]:
    """The most strongly driven `WINDOW` [s] among those with nearly all possible predictions."""
    end = float(t[-1])
    if end <= WINDOW:
        return 0.0, end
    starts = np.append(np.arange(0.0, end - WINDOW, WINDOW_STEP), end - WINDOW)
    first, last = np.searchsorted(t, starts), np.searchsorted(t, starts + WINDOW)
    count = np.concatenate([[0], np.cumsum(predicted)])
    effort = np.concatenate([[0.0], np.cumsum(np.sum(forces**2, axis=1))])
    found = count[last] - count[first]
    strength = np.where(found >= NEARLY_ALL * found.max(), effort[last] - effort[first], -1.0)
    best = float(starts[int(np.argmax(strength))])
    return best, best + WINDOW
