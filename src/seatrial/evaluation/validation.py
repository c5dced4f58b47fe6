# SPDX-License-Identifier: MIT
"""How well a model predicts recordings: scores beside noise floor, expected error and constant velocity."""

from __future__ import annotations

from collections.abc import Sequence

from seatrial.boat.model import Model
from seatrial.boat.physics import axis_physics
from seatrial.evaluation.assessment import Assessment, assess, judging
from seatrial.evaluation.head_to_head import HeadToHead, head_to_head
from seatrial.evaluation.pooled_scores import pooled
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.evaluation.reference import Reference
from seatrial.evaluation.scores import SCORES_FORMAT, Scores, fingerprint
from seatrial.recording.recording import Recording
from seatrial.util.arguments import expect
from seatrial.util.blas import one_blas_thread


@one_blas_thread
def validate(
    model: Model,
    recordings: Sequence[Recording],
    horizon: float = DEFAULT_HORIZON,
    *,
    other: Model | None = None,
    reference: Reference = "smoothed",
) -> Scores:
    """Scores of the model on every recording, `horizon` [s] ahead, and at all `HORIZONS`.

    reference: "smoothed" velocities, predicted from the model's own filter, or the five-point "stencil"'s,
    predicted from the stencil's, as in the paper. With an `other` model also the table of `against`, relative to
    the stencil's. Refuses an unstable model, and one that diverges within `horizon`.
    """
    expect(model, Model, "model")
    if other is not None:
        expect(other, Model, "other")
    axis_physics(model)
    found = assess(model, recordings, horizon, reference)
    for one in found:
        if one.failure is not None:
            raise one.failure
    beside = None if other is None else head_to_head(model, other, recordings, horizon)
    return scores_of(model, found, horizon, beside, reference)


def scores_of(
    model: Model,
    found: Sequence[Assessment],
    horizon: float,
    beside: HeadToHead | None = None,
    reference: Reference = "smoothed",
) -> Scores:
    """The scores of all recordings that could be predicted."""
    return Scores(
        SCORES_FORMAT,
        model.name,
        model.estimator.method,
        horizon,
        [one.score for one in found if one.score is not None],
        beside,
        pooled(judging(found)),
        fingerprint(model),
        reference,
    )
