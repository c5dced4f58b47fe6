# SPDX-License-Identifier: MIT
"""Scores of predictions: RMS errors beside floor, expected error and "velocity stays constant"."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.findings import Finding
from seatrial.boat.model import Model
from seatrial.evaluation.predicted import Prediction
from seatrial.evaluation.reference import Reference
from seatrial.evaluation.residuals import Correlation
from seatrial.evaluation.scores import AxisScore, HorizonScore, Interval, RecordingScore
from seatrial.evaluation.through_water import same_recording
from seatrial.recording.excitation import excitation
from seatrial.recording.recording import Recording
from seatrial.util.block_bootstrap import block_length, block_sums, ratio_interval
from seatrial.util.frames import AXES, SYMBOLS, Array
from seatrial.util.statistics import kurtosis


def score(
    model: Model,
    recording: Recording,
    prediction: Prediction,
    *,
    horizons: Sequence[HorizonScore],
    correlations: Sequence[Correlation],
    findings: Sequence[Finding],
    reference: Reference,
) -> RecordingScore:
    """Scores of one recording, from its prediction at the chosen horizon and those at all horizons."""
    dominant = excitation(model.vehicle, recording).dominant
    return RecordingScore(
        recording.name,
        recording.duration,
        len(prediction.t),
        recording.usable,
        seen(model, recording),
        None if dominant is None else AXES[dominant],
        axis_scores(prediction),
        list(horizons),
        list(correlations),
        list(findings),
        reference,
    )


def axis_scores(prediction: Prediction) -> dict[str, AxisScore]:
    """Scores of one prediction by u, v, r, with their intervals."""
    squares = np.column_stack([prediction.squares, prediction.constant_squares])
    intervals = _intervals(squares, prediction.index, prediction.steps)
    rms = np.sqrt(np.mean(squares, axis=0)).tolist()
    return {
        symbol: _axis_score(prediction, axis, (rms[axis], rms[3 + axis]), intervals[axis])
        for axis, symbol in enumerate(SYMBOLS)
    }


def _intervals(squares: Array, index: NDArray[np.int64], steps: int) -> list[list[Interval | None]]:
    """Of RMS, of that of what stays constant, and of their ratio; axis by axis."""
    if not np.all(squares.sum(axis=0) > 0.0):  # a boat that never moves
        return [[None] * 3] * 3
    blocks = block_sums(
        np.column_stack([squares, np.ones(len(squares))]),
        index,
        block_length(squares, index, steps),
    )
    if blocks is None:
        return [[None] * 3] * 3
    own, still, count = blocks[:, :3], blocks[:, 3:6], np.repeat(blocks[:, 6:], 3, axis=1)
    found = np.sqrt(ratio_interval(np.hstack([own, still, own]), np.hstack([count, count, still])))
    pairs = [(float(low), float(high)) for low, high in found]
    return [[pairs[axis], pairs[3 + axis], pairs[6 + axis]] for axis in range(3)]


def _axis_score(
    prediction: Prediction,
    axis: int,
    found: tuple[float, float],
    intervals: Sequence[Interval | None],
) -> AxisScore:
    (rms, still), (own, constant, ratio) = found, intervals
    errors, floor = prediction.errors[:, axis], float(prediction.floor[axis])
    reference = prediction.reference_error
    return AxisScore(
        rms,
        still,
        rms / still if still > 0 else float("inf"),
        floor,
        None if prediction.expected_rms is None else float(prediction.expected_rms[axis]),
        None if prediction.parameter_rms is None else float(prediction.parameter_rms[axis]),
        _beyond(rms, floor),
        float(np.mean(errors)),
        kurtosis(errors),
        own,
        constant,
        ratio,
        None if own is None else (_beyond(own[0], floor), _beyond(own[1], floor)),
        None if reference is None else float(reference[axis]),
    )


def _beyond(rms: float, floor: float) -> float:
    return float(np.sqrt(max(0.0, rms**2 - floor**2)))


def seen(model: Model, recording: Recording) -> bool:
    """Whether the model was identified from any part of it: same file (or name), same seconds."""
    begin, end = recording.offset, recording.offset + recording.duration
    for entry in model.recordings:
        same = same_recording(entry, recording)
        if same and begin < entry.start + entry.length and entry.start < end:
            return True
    return False
