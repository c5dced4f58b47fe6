# SPDX-License-Identifier: MIT
"""Scores of several recordings together."""

from collections.abc import Sequence

import numpy as np

from seatrial.evaluation.assessment import Assessment
from seatrial.evaluation.predicted import Prediction
from seatrial.evaluation.scores import PooledScore
from seatrial.evaluation.scoring import axis_scores
from seatrial.util.frames import Array


def pooled(found: Sequence[Assessment]) -> list[PooledScore]:
    """Scores of all these recordings together, at every horizon that one of them reaches."""
    kinds = sorted({(horizon, start) for one in found for horizon, start, _ in one.ahead})
    scores = []
    for horizon, start in kinds:
        every = [p for one in found for h, s, p in one.ahead if (h, s) == (horizon, start)]
        whole, fewest = together(every), min(p.steps for p in every)
        scores.append(
            PooledScore(horizon, fewest, start, len(every), len(whole.t), axis_scores(whole))
        )
    return scores


def together(predictions: Sequence[Prediction]) -> Prediction:
    """One after the other, as far apart as makes blocks of time of their own."""
    steps = max(p.steps for p in predictions)
    moved, end = [], 0
    for one in predictions:
        moved.append(end - int(one.index.min()))
        end = int(one.index.max()) + moved[-1] + 10 * steps + 1
    count = np.array([len(p.t) for p in predictions], dtype=float)
    variances = [p.variance for p in predictions if p.variance is not None]
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
        _mean([p.expected_rms for p in predictions], count),
        _mean([p.parameter_rms for p in predictions], count),
        np.concatenate(variances) if len(variances) == len(predictions) else None,
    )


def _mean(rms: Sequence[Array | None], count: Array) -> Array | None:
    """Of root mean squares (3,) of so many predictions each; None where one is not known."""
    known = [one for one in rms if one is not None]
    if len(known) < len(rms):
        return None
    return np.asarray(np.sqrt(count @ np.square(known) / count.sum()))
