# SPDX-License-Identifier: MIT
"""Each recording's series for the report, computed once, on one time base."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.findings import Finding
from seatrial.boat.model import Model
from seatrial.evaluation.assessment import Assessment, judging
from seatrial.evaluation.predicted import Prediction
from seatrial.evaluation.residuals import Correlation
from seatrial.evaluation.scores import RecordingScore
from seatrial.recording.excitation import Excitation, excitation
from seatrial.recording.faults.pose_faults import GAP_FACTOR
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import motion
from seatrial.util.errors import ModelError, RecordingError
from seatrial.util.frames import Array

PLOT_WINDOW = 40.0  # [s] that a plot shows at first, as in Figs. 5 and 6
PICTURE_WINDOW = 60.0  # [s] of the first screen's picture
WINDOW_STEP = 5.0  # [s] between the windows that are compared
MOST_ROWS = 16_000  # drawn of all recordings together
NEARLY_ALL_PREDICTED = 0.95  # of the best window's predictions: a window with fewer is not chosen


@dataclass(frozen=True)
class Run:
    """One recording with its predictions. A row of NaN breaks a line."""

    assessment: Assessment
    excitation: Excitation
    t: Array  # (n,) time base: the poses', and the middle of every gap and jump [s]
    position: Array  # (n, 2) x, y [m] of the usable poses
    measured: Array  # (n, 3) [m/s, m/s, rad/s]; what predictions are compared with
    predicted: Array  # (n, 3) [m/s, m/s, rad/s]; NaN where there is none
    forces: Array  # (n, forces) [command units]
    # [s] interval with the strongest commands: the plots show it at first
    window: tuple[float, float]
    shown: NDArray[np.intp]  # rows that are drawn

    @property
    def recording(self) -> Recording:
        """What was recorded."""
        return self.assessment.recording

    @property
    def name(self) -> str:
        """The recording's."""
        return self.recording.name

    @property
    def unseen(self) -> bool:
        """Whether the model was not identified from it."""
        return not self.assessment.seen

    @property
    def tested(self) -> bool:
        """Whether it could be predicted."""
        return self.assessment.prediction is not None

    @property
    def failure(self) -> str:
        """Why there is no prediction."""
        return str(self.assessment.failure or "")

    @property
    def prediction(self) -> Prediction:
        """At the chosen horizon. Raises ModelError where there is none."""
        if self.assessment.prediction is None:
            raise ModelError(self.failure)
        return self.assessment.prediction

    @property
    def score(self) -> RecordingScore:
        """Raises ModelError where there is none."""
        if self.assessment.score is None:
            raise ModelError(self.failure)
        return self.assessment.score

    @property
    def correlations(self) -> tuple[Correlation, ...]:
        """Of the filter's residuals with the forces."""
        return self.assessment.correlations

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Disturbances, errors above the expected RMS, results that are not available."""
        return self.assessment.findings

    @property
    def noise(self) -> Array | None:
        """(12,) of the model's filter; None: it did not run."""
        filtered = self.assessment.filtered
        return None if filtered is None else filtered.noise

    @property
    def excluded(self) -> float:
        """Share of excluded poses."""
        return 1.0 - self.recording.usable


def gather(model: Model, found: Sequence[Assessment]) -> list[Run]:
    """Every recording with its predictions, as given, on its time base.

    A recording on which the model diverges is kept, with the reason. Raises RecordingError where
    none is as long as the horizon.
    """
    short = [one.failure for one in found if isinstance(one.failure, RecordingError)]
    if len(short) == len(found):
        raise short[0]
    every = max(1, -(-sum(len(one.recording.t) for one in found) // MOST_ROWS))
    return [_run(model, one, every) for one in found]


def judged(runs: Sequence[Run]) -> list[Run]:
    """The recordings that score the model: those that it has not seen, if there are any."""
    chosen = {id(one) for one in judging([run.assessment for run in runs])}
    return [run for run in runs if id(run.assessment) in chosen]


def _run(model: Model, found: Assessment, every: int) -> Run:
    recording, ahead = found.recording, found.prediction
    moving = motion(recording) if found.smoothed is None else found.smoothed
    t, row = time_base(recording)

    def spread(values: Array, index: NDArray[np.intp] | NDArray[np.bool_]) -> Array:
        out = np.full((len(t), values.shape[1]), np.nan)
        out[row[index]] = values
        return out

    predicted = np.full((len(t), 3), np.nan)
    usable = np.isin(np.arange(len(t)), row)
    if ahead is not None:
        predicted = spread(ahead.nu, np.asarray(ahead.index, dtype=np.intp))
        usable = np.isfinite(predicted[:, 0])
    forces = np.asarray(model.trace(recording).forces(t))
    measured = spread(moving.nu[moving.valid], moving.valid)
    return Run(
        found,
        excitation(model.vehicle, recording),
        t,
        spread(recording.eta[recording.valid, :2], recording.valid),
        measured,
        predicted,
        forces,
        busy_window(t, usable, forces),
        thinned(np.isfinite(measured[:, 0]), every),
    )


def time_base(recording: Recording) -> tuple[Array, NDArray[np.intp]]:
    """Pose times [s] with a row more in the middle of each gap and jump; the row of each pose."""
    t, valid, segment = recording.t, recording.valid, recording.segment
    breaks = np.diff(t) > GAP_FACTOR * recording.usual_step
    breaks |= valid[1:] & valid[:-1] & (np.diff(segment) != 0)
    before = np.flatnonzero(breaks)
    row = np.arange(len(t)) + np.searchsorted(before, np.arange(len(t)))
    base = np.insert(t, before + 1, 0.5 * (t[before] + t[before + 1]))
    return base, row


def thinned(present: NDArray[np.bool_], every: int) -> NDArray[np.intp]:
    """Each `every`-th row, and the ends of every interval, so that lines keep their breaks."""
    keep = np.arange(len(present)) % every == 0
    edge = np.flatnonzero(np.diff(present))
    keep[edge] = keep[edge + 1] = True
    keep[[0, -1]] = True
    return np.flatnonzero(keep)


def busy_window(
    t: Array, predicted: NDArray[np.bool_], forces: Array, length: float = PLOT_WINDOW
) -> tuple[float, float]:
    """The `length` [s] with the strongest commands, among those with nearly all predictions."""
    end = float(t[-1])
    if end <= length:
        return 0.0, end
    starts = np.append(np.arange(0.0, end - length, WINDOW_STEP), end - length)
    first, last = np.searchsorted(t, starts), np.searchsorted(t, starts + length)
    count = np.concatenate([[0], np.cumsum(predicted)])
    effort = np.concatenate([[0.0], np.cumsum(np.sum(forces**2, axis=1))])
    found = count[last] - count[first]
    strength = np.where(
        found >= NEARLY_ALL_PREDICTED * found.max(), effort[last] - effort[first], -1.0
    )
    best = float(starts[int(np.argmax(strength))])
    return best, best + length
