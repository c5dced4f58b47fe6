# SPDX-License-Identifier: MIT
"""Predictions of several recordings taken together: what they score as one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.evaluation.prediction import Prediction
from seatrial.evaluation.validation import AxisScore, Start, axis_scores
from seatrial.report.evidence.runs import Run
from seatrial.util.frames import Array


@dataclass(frozen=True)
class Pooled:
    """Some recordings at one horizon, from one kind of start."""

    horizon: float  # [s]
    steps: int  # poses, the fewest
    start: Start
    recordings: int
    predictions: int
    scores: dict[str, AxisScore]  # by u, v, r


def together(predictions: Sequence[Prediction]) -> Prediction:
    """One after the other, as far apart as makes blocks of time of their own."""
    steps = max(p.steps for p in predictions)
    moved, end = [], 0
    for one in predictions:
        moved.append(end - int(one.index.min()))
        end = int(one.index.max()) + moved[-1] + 10 * steps + 1
    count = np.array([len(p.t) for p in predictions], dtype=float)
    first = predictions[0]
    if len(predictions) == 1:
        return first
    return Prediction(
        np.concatenate([p.stamps for p in predictions]),
        np.concatenate([p.t for p in predictions]),
        np.concatenate([p.nu for p in predictions]),
        np.concatenate([p.measured for p in predictions]),
        np.concatenate([p.start for p in predictions]),
        np.concatenate([p.begun + by for p, by in zip(predictions, moved, strict=True)]),
        np.concatenate([p.index + by for p, by in zip(predictions, moved, strict=True)]),
        steps,
        np.sqrt(count @ np.square([p.floor for p in predictions]) / count.sum()),
        _mean([p.foreseen for p in predictions], count),
        _mean([p.unsure for p in predictions], count),
    )


def _mean(rms: Sequence[Array | None], count: Array) -> Array | None:
    """Of root mean squares (3,) of so many predictions each; None where one is not known."""
    known = [one for one in rms if one is not None]
    if len(known) < len(rms):
        return None
    return np.asarray(np.sqrt(count @ np.square(known) / count.sum()))


def pooled(runs: Sequence[Run]) -> list[Pooled]:
    """Scores of all these recordings together, at every horizon that one of them reaches."""
    kinds = sorted({(horizon, start) for run in runs for horizon, start, _ in run.horizons})
    found = []
    for horizon, start in kinds:
        every = [p for run in runs for h, s, p in run.horizons if (h, s) == (horizon, start)]
        whole = together(every)
        fewest = min(p.steps for p in every)
        found.append(Pooled(horizon, fewest, start, len(every), len(whole.t), axis_scores(whole)))
    return found


def judged(runs: Sequence[Run]) -> list[Run]:
    """The recordings that a model is judged by: those that it has not seen, if there are any."""
    tested = [run for run in runs if run.tested]
    return [run for run in tested if run.unseen] or tested
