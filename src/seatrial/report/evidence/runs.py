# SPDX-License-Identifier: MIT
"""What the report needs of each recording, computed once and laid on one time base."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.evaluation.filtering import Causal, believed_noise, causal
from seatrial.evaluation.prediction import Prediction, predict
from seatrial.evaluation.residuals import Correlation, residuals
from seatrial.evaluation.validation import RecordingScore, Start, lookaheads, score, seen
from seatrial.recording.excitation import Excitation, excitation
from seatrial.recording.pose_faults import GAP_FACTOR
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import motion
from seatrial.util.errors import ModelError, RecordingError, SeatrialError
from seatrial.util.frames import Array

WINDOW = 40.0  # [s] that a plot opens at, as in Figs. 5 and 6
WINDOW_STEP = 5.0  # [s] between the windows that are compared
DRAWN = 16_000  # rows of all recordings together that are drawn at the most
NEARLY_ALL = 0.95  # share of the best window's predictions that a window must have


@dataclass(frozen=True)
class Run:
    """One recording beside its predictions. A row of NaN stands where a line must break."""

    recording: Recording
    outcome: tuple[Prediction, RecordingScore] | None  # at the chosen horizon; None: see `lost`
    lost: str  # why there is no prediction
    horizons: tuple[tuple[float, Start, Prediction], ...]  # horizon [s], start, prediction
    correlations: tuple[Correlation, ...]  # of the filter's residuals with the forces
    findings: tuple[Finding, ...]  # what else could not be had
    noise: Array | None  # (11,) what the model's filter believes; None: there is no filter
    excitation: Excitation
    unseen: bool  # the model was not identified from it
    t: Array  # (n,) time base: the poses', and the middle of every gap and jump [s]
    position: Array  # (n, 2) x, y [m] of the usable poses
    measured: Array  # (n, 3) [m/s, m/s, rad/s]
    predicted: Array  # (n, 3) [m/s, m/s, rad/s]; NaN where there is none
    forces: Array  # (n, forces) [command units]
    window: tuple[float, float]  # [s] busy stretch that the plots open at
    shown: NDArray[np.intp]  # rows that are drawn

    @property
    def tested(self) -> bool:
        """Whether it could be predicted."""
        return self.outcome is not None

    @property
    def prediction(self) -> Prediction:
        """Raises ModelError where there is none."""
        return self._outcome()[0]

    @property
    def score(self) -> RecordingScore:
        """Raises ModelError where there is none."""
        return self._outcome()[1]

    def _outcome(self) -> tuple[Prediction, RecordingScore]:
        if self.outcome is None:
            raise ModelError(self.lost)
        return self.outcome

    @property
    def name(self) -> str:
        """The recording's."""
        return self.recording.name

    @property
    def masked(self) -> float:
        """Share of the poses that were left out."""
        return 1.0 - self.recording.usable


def gather(model: Model, recordings: Sequence[Recording], horizon: float) -> list[Run]:
    """Every recording with its predictions, `horizon` [s] ahead and at all horizons, as given.

    A recording that a model runs away from is kept, with the reason. Raises RecordingError where
    none is as long as the horizon, or where there is none.
    """
    if not recordings:
        raise RecordingError("report: no recording given; pass at least one")
    filters = _filters(model, recordings)
    every = max(1, -(-sum(len(r.t) for r in recordings) // DRAWN))
    found = [_run(model, r, horizon, f, every) for r, f in zip(recordings, filters, strict=True)]
    short = [error for _, error in found if isinstance(error, RecordingError)]
    if len(short) == len(found):
        raise short[0]
    return [run for run, _ in found]


def _filters(model: Model, recordings: Sequence[Recording]) -> list[Causal | str]:
    """The model's filter along every recording, or why there is none."""
    try:
        noise = believed_noise(model, recordings)
    except SeatrialError as error:
        return [str(error)] * len(recordings)
    found: list[Causal | str] = []
    for recording in recordings:
        try:
            found.append(causal(model, recording, noise))
        except SeatrialError as error:
            found.append(str(error))
    return found


def _run(
    model: Model, recording: Recording, horizon: float, filtered: Causal | str, every: int
) -> tuple[Run, SeatrialError | None]:
    moving = motion(recording)
    t, row = time_base(recording)

    def spread(values: Array, index: NDArray[np.intp] | NDArray[np.bool_]) -> Array:
        out = np.full((len(t), values.shape[1]), np.nan)
        out[row[index]] = values
        return out

    outcome, failed = None, None
    predicted = np.full((len(t), 3), np.nan)
    try:
        ahead = predict(model, recording, horizon)
        outcome = ahead, score(model, recording, ahead)
        predicted = spread(ahead.nu, np.asarray(ahead.index, dtype=np.intp))
    except (ModelError, RecordingError) as error:
        failed = error
    known = filtered if isinstance(filtered, Causal) else None
    lost = [] if known else [finding_of(FindingKind.NO_FILTER, reason=str(filtered))]
    try:
        aheads, more = lookaheads(model, recording, horizon, known)
    except RecordingError as error:
        aheads = []
        more = [finding_of(FindingKind.HORIZON_NOT_PREDICTED, reason=str(error))]
    forces = np.asarray(model.trace(recording).forces(t))
    usable = np.isfinite(predicted[:, 0]) if outcome else np.isin(np.arange(len(t)), row)
    run = Run(
        recording,
        outcome,
        "" if failed is None else str(failed),
        tuple(aheads),
        () if known is None else tuple(residuals(model, recording, known)),
        (*lost, *more),
        None if known is None else known.noise,
        excitation(model.vehicle, recording),
        not seen(model, recording),
        t,
        spread(recording.eta[recording.valid, :2], recording.valid),
        spread(moving.nu[moving.valid], moving.valid),
        predicted,
        forces,
        busy_window(t, usable, forces),
        thinned(np.isfinite(spread(moving.nu[moving.valid], moving.valid)[:, 0]), every),
    )
    return run, failed


def time_base(recording: Recording) -> tuple[Array, NDArray[np.intp]]:
    """Pose times [s] with a row more in the middle of each gap and jump; the row of each pose."""
    t, valid, segment = recording.t, recording.valid, recording.segment
    breaks = np.diff(t) > GAP_FACTOR * recording.usual_step
    breaks |= valid[1:] & valid[:-1] & (np.diff(segment) != 0)
    before = np.flatnonzero(breaks)
    row = np.arange(len(t)) + np.searchsorted(before, np.arange(len(t)))
    base = np.insert(t, before + 1, 0.5 * (t[before] + t[before + 1]))
    return base, row


def thinned(there: NDArray[np.bool_], every: int) -> NDArray[np.intp]:
    """Every so-manieth row, and where samples begin and end, so that lines break where they did."""
    keep = np.arange(len(there)) % every == 0
    edge = np.flatnonzero(np.diff(there))
    keep[edge] = keep[edge + 1] = True
    keep[[0, -1]] = True
    return np.flatnonzero(keep)


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
